"""The car of the campaigns `make soak` and `make hour`: its data tell code and moment."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import inf
from random import Random
from typing import Final
from zlib import crc32

from mikas.catalog import shipped

STEP: Final = 0.25  # s between two changes of the data
AGE: Final = 0.5  # s from the answer in the unit to its first byte here, stalls included


@dataclass
class Outages:
    """Random spans without a thing, after `start`, `count` so far. Times must not run back."""

    every: tuple[float, float]
    length: tuple[float, float]
    random: Random
    start: float = 0.0
    count: int = 0
    _past: list[tuple[float, float]] = field(default_factory=list)

    def __post_init__(self) -> None:
        self._plan(self.start)

    def _plan(self, after: float) -> None:
        self.begin = after + self.random.uniform(*self.every)
        self.end = self.begin + self.random.uniform(*self.length)

    def covers(self, time: float) -> bool:
        while time >= self.end:
            self.count += 1
            self._past.append((self.begin, self.end))
            self._plan(self.end)
        return time >= self.begin

    def next_change(self, after: float) -> float:
        self.covers(after)
        return self.begin if after < self.begin else self.end

    def seconds_in(self, begin: float, end: float) -> float:
        """Return how much of a span was lost; nothing before it is asked for again."""
        self._past = [it for it in self._past if it[1] > begin]
        known = (*self._past, (self.begin, self.end))
        return sum(max(0.0, min(end, last) - max(begin, first)) for first, last in known)


class SoakCar:
    """Data that tell code and moment: random bytes that change every `STEP` seconds."""

    def __init__(self, seed: int, ignition_off: Outages) -> None:
        self._sizes = dict(shipped().codes)
        self._seed = seed
        self._ignition_off = ignition_off
        self.codes = tuple(self._sizes)
        self.faults = [13, 53]

    def size_of(self, code: int) -> int | None:
        return self._sizes.get(code)

    def raw(self, code: int, now: float) -> bytes:
        return self.at(code, int(now // STEP))

    def at(self, code: int, step: int) -> bytes:
        number = crc32(f"{self._seed} {code} {step}".encode())
        return number.to_bytes(4, "little")[: self._sizes[code]]

    def may_be(self, code: int, raw: bytes, time: float) -> bool:
        """Return whether the unit gave this answer shortly before `time`."""
        steps = range(int((time - AGE) // STEP), int(time // STEP) + 1)
        return any(self.at(code, step) == raw for step in steps)

    def write(self, code: int, data: bytes) -> bool:  # noqa: ARG002  (read-only)
        return False

    def powered(self, now: float) -> bool:
        return not self._ignition_off.covers(now)

    def next_change(self, after: float) -> float:
        return self._ignition_off.next_change(after)

    def next_stroke(self, stroke: int, after: float) -> float:  # noqa: ARG002  (none)
        return inf

    def engine_speed(self, now: float) -> float:  # noqa: ARG002  (constant)
        return 850.0

    def power_cycle(self) -> None:
        """Do nothing: all data are read-only."""
