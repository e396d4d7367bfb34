"""Runs every benchmark and prints the machine, the method and the figures, as Markdown."""

from __future__ import annotations

import os
import platform
import sys

from bench import bulk, decoder, startup, wire


def main() -> None:
    quick = "--quick" in sys.argv[1:]
    print(f"Machine: {platform.machine()}, {os.cpu_count()} cores, {platform.system()}, ", end="")
    print(f"Python {platform.python_version()}.\n")
    wire.run(quick=quick)
    decoder.run()
    bulk.run(quick=quick)
    startup.run()


main()
