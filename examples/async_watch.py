"""Sample in an asyncio program: the event loop runs on while the ECU is asked."""

from __future__ import annotations

import asyncio
import sys

import mikas

PORT = sys.argv[1] if len(sys.argv) > 1 else "sim:?clock=simulated"


async def main() -> None:
    """Read one value, then watch two."""
    async with await mikas.AsyncEcu.connect(PORT) as ecu:
        print((await ecu.read("UACC"))["UACC"])
        async for sample in ecu.watch("FREQ", "JAIR", rate=5, count=10):
            print(f"{sample.time:.2f}", *sample.readings.values(), sep="  ")


asyncio.run(main())
