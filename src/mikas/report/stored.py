"""Which faults were stored, as a recording heard it: the unit's answers to 02, in their order."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path

from mikas.commands import ERASE_FAULTS, ReadFaults
from mikas.errors import MikasError
from mikas.recording.exchanges.reading import read_exchanges
from mikas.recording.exchanges.result import Exchanges
from mikas.recording.notes import Kind, Note
from mikas.recording.reader import Problem, Source
from mikas.report.told import Heard


def faults_heard(path: Path) -> Mapping[Source, Sequence[Heard]]:
    """By session and port; one in which they were not asked, or not told, is missing."""
    heard: dict[Source, list[Heard]] = {}
    listeners: dict[Source, _Listener] = {}
    for item in read_exchanges(path):
        if not isinstance(item, Problem):
            listener = listeners.setdefault(item.source, _Listener())
            for each in listener.listen(item):
                heard.setdefault(item.source, []).append(each)
    return heard


def faults_noted(notes: Iterable[Note]) -> Iterator[Heard]:
    """What had been told before the recording began, by the same unit to the same program."""
    for note in notes:
        if note.kind == Kind.FAULTS and isinstance(told := note.data.get("readings"), list):
            yield from filter(None, map(_heard, told))


def _heard(told: object) -> Heard | None:
    """A file may hold anything."""
    if not isinstance(told, dict):
        return None
    time, codes = told.get("time"), told.get("codes")
    if not isinstance(time, (int, float)) or not isinstance(codes, list):
        return None
    known = all(isinstance(code, int) and 0 <= code <= 0xFF for code in codes)
    return Heard(float(time), tuple(codes), told.get("erased") is True) if known else None


class _Listener:
    """One port: whether faults were erased since they were told last."""

    def __init__(self) -> None:
        self._erased = False

    def listen(self, exchanges: Exchanges) -> Iterator[Heard]:
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
            yield Heard(time, codes, self._erased)
            self._erased = False
