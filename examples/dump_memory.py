"""Read 4 KiB of program memory into code-8000.bin. Reading changes nothing in the ECU.

`mikas mem dump` can also resume after an interruption and compare a second pass.
"""

from __future__ import annotations

import sys
from pathlib import Path

import mikas

PORT = sys.argv[1] if len(sys.argv) > 1 else "sim:?clock=simulated"
FIRST, COUNT = 0x8000, 4096

with mikas.connect(PORT) as ecu, Path("code-8000.bin").open("wb") as file:
    for block in ecu.memory.code.blocks(FIRST, COUNT):
        file.write(block)
        print(f"{FIRST + file.tell():04X}", end="\r", flush=True)
    print(f"{file.tell()} bytes in {file.name}")
