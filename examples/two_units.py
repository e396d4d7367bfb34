"""Sample two units at once in an asyncio program, each at its own pace."""

from __future__ import annotations

import asyncio
import sys

import mikas

PORTS = sys.argv[1:] or ["sim:?clock=simulated&model=5.4", "sim:?clock=simulated&scenario=city"]


async def mean_speed(port: str) -> float:
    """Return the mean engine speed of 50 cycles; the event loop runs on meanwhile."""
    async with mikas.AsyncEcu.connect(port) as ecu:
        print(f"{port}: {ecu.model.text.en}")
        speeds = [
            sample.readings["FREQ"].value
            async for sample in ecu.watch("FREQ", "JAIR", count=50)
            if not sample.gap  # a gap: this cycle failed, `sample.error` is the reason
        ]
    return sum(speeds) / len(speeds)


async def main() -> None:
    """Ask both at once; a unit that fails, or a minute without an end, ends both."""
    async with asyncio.timeout(60), asyncio.TaskGroup() as group:
        tasks = {port: group.create_task(mean_speed(port)) for port in PORTS}
    for port, task in tasks.items():
        print(f"{port}: {task.result():.0f} rpm")


asyncio.run(main())
