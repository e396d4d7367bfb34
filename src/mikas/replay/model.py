"""The content of a recording that can be replayed, by time: a datum is found by bisection.

Bodies are kept unconverted, those with the same parameters in one series: ten hours at the full
rate of a stream are 1.3 million responses of 35 bytes each.
"""

from __future__ import annotations

from array import array
from bisect import bisect_right
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, field
from math import inf
from typing import Generic, TypeVar

from mikas import commands as c
from mikas.recording.annotations.cars import RecordedCar
from mikas.recording.exchanges.layouts import Layout
from mikas.virtual.quirks import EcuQuirks

T = TypeVar("T")


class ChangingValue(Generic[T]):
    """A value that changes seldom, with the times of its changes."""

    def __init__(self) -> None:
        self.times: array[float] = array("d")
        self.values: list[T] = []

    def add(self, time: float, value: T) -> None:
        """Add the value at `time` if it is another than the last."""
        if not self.values or self.values[-1] != value:
            self.times.append(time)
            self.values.append(value)

    def index(self, time: float) -> int:
        """Return the index of the value at `time`; before the first, of the first."""
        return max(0, bisect_right(self.times, time) - 1)

    def at(self, time: float) -> T | None:
        """Return the value at `time`; None if there is none at all."""
        return self.values[self.index(time)] if self.values else None


class Series:
    """Responses of the same layout."""

    def __init__(self, layout: Layout) -> None:
        self.layout = layout
        self.size: int = layout.length
        self.times: array[float] = array("d")
        self._bodies = bytearray()

    @property
    def latest(self) -> float:
        """The time of the latest response."""
        return self.times[-1] if self.times else -inf

    def add(self, time: float, body: bytes) -> None:
        """Add the response of `time`, never before the latest."""
        self.times.append(max(time, self.latest))
        self._bodies += body

    def extend(self, times: bytes, bodies: bytes) -> None:
        """Add many responses at once. `times`: 64-bit floats that rise from the latest one."""
        self.times.frombytes(times)
        self._bodies += bodies

    def datum(self, index: int, begin: int, size: int) -> bytes:
        """Return the bytes from `begin` of response number `index`."""
        start = index * self.size + begin
        return bytes(self._bodies[start : start + size])


@dataclass(frozen=True, slots=True)
class Cells:
    """Memory cells that were read or written at `time`."""

    time: float
    space: str
    address: int
    data: bytes


@dataclass(slots=True)
class ReplayData:
    """The content of a recording.

    `places`: by parameter code, its data: series, place in the body, size. `others`: responses to
    commands not in §3. `silences`: when the ECU had no supply, in order; `holes`: when the line was
    not recorded, in order. `refused`: by parameter code, whether the ECU refused it. `refusals`:
    responses to commands that the ECU lacks, or that were not recorded. `answered`: commands that
    were answered at least once. `cars`: those of the file.
    """

    begin: float = 0.0
    duration: float = 0.0
    baud: int = 9600
    echo: bool = True
    frames: int = 0
    problems: int = 0
    cars: Sequence[RecordedCar] = ()
    places: dict[int, list[tuple[Series, int, int]]] = field(default_factory=dict)
    version: ChangingValue[int] = field(default_factory=ChangingValue)
    passports: tuple[ChangingValue[str], ...] = field(
        default_factory=lambda: tuple(ChangingValue() for _ in range(8))
    )
    count: ChangingValue[int] = field(default_factory=ChangingValue)
    faults: ChangingValue[tuple[int, ...]] = field(default_factory=ChangingValue)
    cells: list[Cells] = field(default_factory=list)
    strokes: dict[int, array[float]] = field(default_factory=dict)
    others: dict[bytes, ChangingValue[bytes]] = field(default_factory=dict)
    writable: set[int] = field(default_factory=set)
    silences: list[tuple[float, float]] = field(default_factory=list)
    holes: list[tuple[float, float]] = field(default_factory=list)
    refused: dict[int, ChangingValue[bool]] = field(default_factory=dict)
    quirks: EcuQuirks = field(default_factory=EcuQuirks)
    refusals: dict[int, bytes | None] = field(default_factory=dict)
    answered: frozenset[int] = frozenset()

    def has_supply(self, time: float) -> bool:
        """Return whether the ECU had its supply at `time`."""
        return not _within(self.silences, time)

    def is_audible(self, time: float) -> bool:
        """Return whether the ECU had its supply at `time`, and the line was recorded."""
        return not (_within(self.silences, time) or _within(self.holes, time))

    def size_of(self, code: int, time: float | None = None) -> int | None:
        """Return the bytes of a datum; None if it was never recorded, or refused at `time`."""
        places = self.places.get(code)
        if time is not None and code in self.refused and self.refused[code].at(time):
            return None
        return places[0][2] if places else None

    def knows(self, codes: Collection[int]) -> bool | None:
        """Return whether the recorded ECU knew one of these commands; None: it was not asked."""
        noted = (code for code, passport in self._passports() if passport.values)
        if self.answered.union(noted).intersection(codes):
            return True
        return False if self.quirks.missing.intersection(codes) else None

    def unrecorded(self) -> Iterator[int]:
        """Yield the commands whose responses would have to be invented."""
        recorded = {
            c.ReadFaults: bool(self.faults.values),
            c.CountParameters: bool(self.count.values),
        }
        spaces = {cells.space for cells in self.cells}
        for command in c.ALL_COMMANDS:
            space = getattr(command, "SPACE", None)
            if not recorded.get(command, True) or (space is not None and space not in spaces):
                yield from command.CODES
        yield from (code for code, passport in self._passports() if not passport.values)

    def _passports(self) -> Iterator[tuple[int, ChangingValue[str]]]:
        codes = c.ReadProgramPassport.CODES + c.ReadDataPassport.CODES
        return zip(codes, self.passports, strict=True)


def _within(stretches: list[tuple[float, float]], time: float) -> bool:
    index = bisect_right(stretches, time, key=lambda stretch: stretch[0]) - 1
    return index >= 0 and time < stretches[index][1]
