"""Network namespaces: they need Linux, root and iproute2.

Tests are skipped without, unless `MIKAS_REQUIRE_NETNS` is set: then it is a failure.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

IP = shutil.which("ip", path=f"{os.environ.get('PATH', '')}:/usr/sbin:/sbin") or "ip"


def run(*words: str, check: bool = True) -> str:
    done = subprocess.run(words, capture_output=True, text=True, timeout=120, check=False)
    assert not check or done.returncode == 0, (words, done.stderr)
    return done.stdout


def is_possible() -> bool:
    if sys.platform != "linux" or not Path(IP).is_absolute() or os.geteuid() != 0:
        return False
    name = f"mikas-try-{os.getpid()}"
    made = subprocess.run([IP, "netns", "add", name], capture_output=True, check=False)
    run(IP, "netns", "del", name, check=False)
    return made.returncode == 0


marks = [
    pytest.mark.realtime,
    pytest.mark.skipif(
        not os.environ.get("MIKAS_REQUIRE_NETNS") and not is_possible(),
        reason="network namespaces need Linux, root and iproute2",
    ),
]


@contextmanager
def two_namespaces(first: str, second: str) -> Iterator[list[str]]:
    """Make two namespaces, each with the interface `lan` at an end of one cable."""
    names = [f"mikas-{who}-{os.getpid()}" for who in (first, second)]
    try:
        for name in names:
            run(IP, "netns", "add", name)
            run(IP, "-n", name, "link", "set", "lo", "up")
        cable = ("link", "add", "lan", "type", "veth", "peer", "lan", "netns", names[1])
        run(IP, "-n", names[0], *cable)
        for name, end in zip(names, "21", strict=True):
            run(IP, "-n", name, "addr", "add", f"10.77.0.{end}/24", "dev", "lan")
            run(IP, "-n", name, "addr", "add", f"fd77::{end}/64", "dev", "lan", "nodad")
            run(IP, "-n", name, "link", "set", "lan", "up")
        yield names
    finally:
        for name in names:
            run(IP, "netns", "del", name, check=False)
