"""Which faults were stored, as a recording heard it: each session's last answer to 02."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from mikas.commands import ReadFaults
from mikas.errors import MikasError
from mikas.recording.bulk.capture import read
from mikas.recording.bulk.match import Answers, Matcher
from mikas.recording.reader import Problem, Source


@dataclass(frozen=True, slots=True)
class Heard:
    """The numbers that the unit told at `time`, in its order."""

    time: float
    codes: tuple[int, ...]


def faults_heard(path: Path) -> Mapping[Source, Heard]:
    """By session and port; one in which they were not asked, or not told, is missing."""
    heard: dict[Source, Heard] = {}
    matchers: dict[Source, Matcher] = {}
    for item in read(path):
        if isinstance(item, Problem):
            for matcher in matchers.values():
                matcher.interrupt()
            continue
        matcher = matchers.setdefault(item.source, Matcher(item.source))
        last = _last(matcher, matcher.feed(item))
        if last is not None:
            heard[item.source] = last
    return heard


def _last(matcher: Matcher, answers: Answers) -> Heard | None:
    """The last answer that makes sense among these."""
    command = ReadFaults()
    asked = matcher.number(command.body())
    for row in (answers.requests == asked).nonzero()[0][::-1].tolist():
        start = int(answers.starts[row])
        body = answers.bodies[start : start + int(answers.lengths[row])].tobytes()
        try:
            return Heard(float(answers.times[row]), command.read(body))
        except MikasError:
            continue
    return None
