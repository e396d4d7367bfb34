"""Which faults were stored, as a recording heard it: the unit's answers to 02, in their order."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path

from mikas.commands import ERASE_FAULTS, ReadFaults
from mikas.errors import MikasError
from mikas.recording.bulk.capture import read
from mikas.recording.bulk.match import Answers, Matcher
from mikas.recording.notes import Kind, Note
from mikas.recording.reader import Problem, Source
from mikas.report.told import Heard


def faults_heard(path: Path) -> Mapping[Source, Sequence[Heard]]:
    """By session and port; one in which they were not asked, or not told, is missing."""
    heard: dict[Source, list[Heard]] = {}
    listeners: dict[Source, _Listener] = {}
    for item in read(path):
        if isinstance(item, Problem):
            for listener in listeners.values():
                listener.matcher.interrupt()
            continue
        listener = listeners.setdefault(item.source, _Listener(item.source))
        for each in listener.listen(listener.matcher.feed(item)):
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

    def __init__(self, source: Source) -> None:
        self.matcher = Matcher(source)
        self._erased = False

    def listen(self, answers: Answers) -> Iterator[Heard]:
        """The answers that make sense among these."""
        command = ReadFaults()
        asked = self.matcher.number(command.body())
        erasing = self.matcher.number(ERASE_FAULTS[-1].body())
        wanted = (answers.requests == asked) | (answers.requests == erasing)
        for row in wanted.nonzero()[0].tolist():
            if answers.requests[row] == erasing:
                self._erased = True
                continue
            start = int(answers.starts[row])
            body = answers.bodies[start : start + int(answers.lengths[row])].tobytes()
            try:
                codes = command.read(body)
            except MikasError:
                continue
            yield Heard(float(answers.times[row]), codes, self._erased)
            self._erased = False
