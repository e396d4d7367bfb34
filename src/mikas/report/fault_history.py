"""Fault readings of a recording (responses to 02, in order) and the faults cleared between."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

from mikas.catalog import Catalog, Fault
from mikas.commands import ERASE_FAULTS, ReadFaults
from mikas.errors import MikasError
from mikas.recording.capture.reader import Problem, Source
from mikas.recording.exchanges import read_exchanges
from mikas.recording.exchanges.result import Exchanges
from mikas.sampling.events import FaultReading


@dataclass(frozen=True, slots=True)
class ClearedFaults:
    """Faults that were no longer stored at `time`, on the link's clock. `erased`: by a tester;
    else for an unknown reason (battery disconnected, or the unit dropped them).
    """

    time: float
    faults: tuple[Fault, ...]
    erased: bool


def cleared_faults(heard: Sequence[FaultReading], catalog: Catalog) -> tuple[ClearedFaults, ...]:
    """Return the faults of one reading that are missing in the next."""
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
    """Return the fault readings by session and port; one without readings is missing."""
    heard: dict[Source, list[FaultReading]] = {}
    listeners: dict[Source, _Listener] = {}
    for item in read_exchanges(path):
        if not isinstance(item, Problem):
            listener = listeners.setdefault(item.source, _Listener())
            for each in listener.listen(item):
                heard.setdefault(item.source, []).append(each)
    return heard


class _Listener:
    """One port: whether faults were erased since the last reading."""

    def __init__(self) -> None:
        self._erased = False

    def listen(self, exchanges: Exchanges) -> Iterator[FaultReading]:
        """Yield the valid fault readings among these."""
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
