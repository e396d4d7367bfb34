"""What the unit told of its faults, one reading after the other, and what was gone in between."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

from mikas.catalog import Catalog, Fault
from mikas.commands import ERASE_FAULTS, ReadFaults
from mikas.errors import MikasError
from mikas.recording.capture.reader import Problem, Source
from mikas.recording.exchanges.reading import read_exchanges
from mikas.recording.exchanges.result import Exchanges
from mikas.sampling.events import FaultReading


@dataclass(frozen=True, slots=True)
class ClearedFaults:
    """Faults that were stored, and were not any more at `time`, on the link's clock. `erased`: by a
    tester; else nobody saw why (the battery was taken off, or the unit forgot them).
    """

    time: float
    faults: tuple[Fault, ...]
    erased: bool


def cleared_faults(heard: Sequence[FaultReading], catalog: Catalog) -> tuple[ClearedFaults, ...]:
    """What was told once and not the next time."""
    missing = (
        (after, tuple(code for code in before.codes if code not in after.codes))
        for before, after in pairwise(heard)
    )
    return tuple(
        ClearedFaults(after.time, tuple(map(catalog.fault, codes)), after.erased)
        for after, codes in missing
        if codes
    )


def faults_heard(path: Path) -> Mapping[Source, Sequence[FaultReading]]:
    """By session and port; one in which they were not asked, or not told, is missing."""
    heard: dict[Source, list[FaultReading]] = {}
    listeners: dict[Source, _Listener] = {}
    for item in read_exchanges(path):
        if not isinstance(item, Problem):
            listener = listeners.setdefault(item.source, _Listener())
            for each in listener.listen(item):
                heard.setdefault(item.source, []).append(each)
    return heard


class _Listener:
    """One port: whether faults were erased since they were told last."""

    def __init__(self) -> None:
        self._erased = False

    def listen(self, exchanges: Exchanges) -> Iterator[FaultReading]:
        """Yield the responses that make sense among these."""
        command, erasing = ReadFaults(), ERASE_FAULTS[-1].body()
        wanted = {
            number
            for number, body in enumerate(exchanges.bodies)
            if body in (command.body(), erasing)
        }
        for time, number, body in exchanges.responses.of(wanted):
            if exchanges.bodies[number] == erasing:
                self._erased = True
                continue
            try:
                codes = command.read(body)
            except MikasError:
                continue
            yield FaultReading(time, codes, self._erased)
            self._erased = False
