"""Read 4 KiB of program memory into code-8000.bin, with progress; Ctrl-C keeps what was read.

Reading changes nothing in the ECU. `mikas mem dump` can also resume and compare a second pass.
"""

from __future__ import annotations

import sys
from pathlib import Path

import mikas

PORT = sys.argv[1] if len(sys.argv) > 1 else "sim:?clock=simulated"
FIRST, COUNT = 0x8000, 4096
FILE = Path("code-8000.bin")


def progress(done: int) -> None:
    """Show how much was read. An exception from here would cancel the dump as Ctrl-C does."""
    print(f"{done / COUNT:4.0%} {FIRST + done:04X}", end="\r", flush=True)


with mikas.connect(PORT) as ecu, FILE.open("wb") as file:
    try:
        for block in ecu.memory.code.blocks(FIRST, COUNT):
            file.write(block)
            progress(file.tell())
    except KeyboardInterrupt:
        print(f"\ncancelled at {FIRST + file.tell():04X}")
    print(f"\n{file.tell()} bytes in {FILE}; the line is in step: {ecu.read('UACC')['UACC']}")
