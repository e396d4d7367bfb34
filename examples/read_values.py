"""Connect to an ECU and read values."""

from __future__ import annotations

import sys

import mikas

PORT = sys.argv[1] if len(sys.argv) > 1 else "sim:?clock=simulated"

with mikas.connect(PORT) as ecu:
    print(ecu.model.text.en, ecu.passport().program)
    for reading in ecu.read("FREQ", "TWAT", "UACC", "0x1A").values():
        print(f"{reading.name:6} {reading.value:8} {reading.unit:4} bytes {reading.raw.hex()}")
