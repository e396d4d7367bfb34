"""Which `01`s are data, and which the refusal of D10, in a capture that is read as a whole.

An `01` is doubtful as the first response of a stream of one byte, and as the answer to a 61 with
one code of one byte. What came later settles it, and live it was settled before it was shown:

- a stream's counts if another response of that stream follows: a refusal comes only once;
- a 61's counts if the code's next datum, in whatever response, follows, and does not if the next
  thing is an `01` to the same code asked for twice (`61 P P`). Once that was said, only a datum 01
  that can't be a refusal makes those behind it count again;
- behind a datum 01 that can't be a refusal it counts anyhow; and at the end, where nothing follows,
  if two or more came though `61 P P` was asked: who asked that was satisfied.

So the file is gone through twice: `Weighing` notes what does not count, `Verdicts.weighed` leaves
it out. Both number what stands between two things that settle it.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from mikas import commands as c
from mikas.commands.base import ERROR
from mikas.recording.bulk.arrays import Index, Mask
from mikas.recording.bulk.columns import Layout, Part
from mikas.recording.bulk.match import Answers

_READ: Final = c.ReadParameters.CODES[0]
_STREAMS: Final = frozenset([*c.StreamCyclic.CODES, *c.StreamAtStroke.CODES])
_ONE: Final = ERROR[0]
_TWICE: Final = 3  # bytes of `61 P P`
_OTHER, _DATUM, _REFUSAL = 0, 1, 2  # what settles: another value; 01 beyond doubt; 01 to `61 P P`
_BELIEVED: Final = 2  # of 01s at the end
_NOWHERE: Final = np.empty(0, np.int64)


@dataclass(slots=True)
class Verdicts:
    """What does not count, of one port. `streams`: (request, which time it was sent); `lone`: by
    code, the stretches; `last`: by code, the last stretch, and whether what is in it counts.
    """

    streams: set[tuple[int, int]] = field(default_factory=set)
    lone: dict[int, set[int]] = field(default_factory=dict)
    last: dict[int, tuple[int, bool]] = field(default_factory=dict)


@dataclass(slots=True)
class _Code:
    """A code asked for alone, or twice at once, up to here. `stretch`: the present one's number."""

    stretch: int = 0
    sure: bool = False  # the present stretch is behind an 01 beyond doubt
    wary: bool = False  # behind an 01 to `61 P P`, and no 01 beyond doubt since
    waiting: int = 0  # doubtful ones in the present stretch


class Doubt:
    """Goes through one port's answers: the first time without `verdicts`, then with them."""

    def __init__(self, bodies: list[bytes], verdicts: Verdicts | None = None) -> None:
        self._bodies = bodies  # of requests, by number; grows
        self._verdicts = verdicts
        self._found = Verdicts()
        self._codes: dict[int, _Code] = {}
        self._fed = 0
        self._latest: dict[Layout, tuple[int, int, bytes]] = {}  # which time, row, body
        self._starts: dict[int, int] = {}  # stream request → which time it was sent last
        self._pending: set[tuple[int, int]] = set()  # streams that began with 01 and may go on

    def weighed(self, parts: list[Part], answers: Answers) -> Iterator[Part]:
        """The parts, without values that do not count; the first time, without doubtful ones."""
        certain: list[Part] = []
        alone: dict[int, Part] = {}
        for part in parts:
            request = self._bodies[part.request]
            if len(request) != 2 or part.layout.length != 1:
                if len(request) == _TWICE and request[0] == _READ and request[1] == request[2]:
                    self._follow(request[1])
                certain.append(part)
                yield part
            elif request[0] in _STREAMS:
                doubtful = self._beginnings(part, answers)
                certain.append(part.only(np.setdiff1d(part.fitting, doubtful)))
                counting = self._going_on(certain[-1], doubtful, answers)
                yield part.only(np.union1d(certain[-1].fitting, counting))
            else:
                alone[request[1]] = part
                self._follow(request[1])
        self._remember(certain, answers)
        for code, state in self._codes.items():
            lone = alone.get(code)
            counting = self._lone(code, state, lone, certain, answers)
            if lone is not None:
                others = lone.fitting[~_is_one(lone, answers)]
                yield lone.only(np.union1d(others, counting))

    def conclude(self) -> tuple[Verdicts, set[int]]:
        """After the first time: what was found, and codes of which the last ones count."""
        found = self._found
        found.streams |= self._pending
        believed = set()
        for code, state in self._codes.items():
            asked = self._twice(code) >= 0
            counts = state.sure or (asked and not state.wary and state.waiting >= _BELIEVED)
            found.last[code] = state.stretch, counts
            if counts and state.waiting:
                believed.add(code)
        return found, believed

    # Streams

    def _beginnings(self, part: Part, answers: Answers) -> Index:
        """The doubtful responses of a stream of one byte."""
        starts = answers.sent[part.rows]
        before = np.concatenate(([self._starts.get(part.request, 0)], starts[:-1]))
        self._starts[part.request] = int(starts[-1])
        first = np.isin(part.fitting, part.rows[starts != before])
        doubtful: Index = part.fitting[first & _is_one(part, answers)]
        return doubtful

    def _going_on(self, part: Part, doubtful: Index, answers: Answers) -> Index:
        """Those of the doubtful ones that count. `part`: the others, which are certain."""
        request = part.request
        starts = answers.sent[doubtful]
        if self._verdicts is not None:
            refused = self._verdicts.streams
            counts = [(request, start) not in refused for start in starts.tolist()]
            return doubtful[np.array(counts, np.bool_)]
        maybe = {(request, start) for start in starts.tolist()} | self._pending
        maybe -= {(request, start) for start in answers.sent[part.fitting].tolist()}
        self._pending = {it for it in maybe if it == (it[0], self._starts[it[0]])}
        self._found.streams |= maybe - self._pending
        return _NOWHERE

    # What came before a code was asked for so

    def _follow(self, code: int) -> None:
        if code not in self._codes:
            self._codes[code] = _Code(sure=self._was_one(code))

    def _remember(self, certain: list[Part], answers: Answers) -> None:
        self._fed += 1
        for part in certain:
            if part.fitting.size:
                last = int(part.fitting[-1])
                start = int(answers.starts[last])
                body = answers.bodies[start : start + part.layout.length].tobytes()
                self._latest[part.layout] = self._fed, last, body

    def _was_one(self, code: int) -> bool:
        """Whether the code's latest datum, up to the answers before these, was 01."""
        told = [
            (*when, body[place])
            for layout, (*when, body) in self._latest.items()
            if (place := layout.last_of(code)) is not None
        ]
        return bool(told) and max(told)[-1] == _ONE

    # A 61 with one code

    def _lone(
        self,
        code: int,
        state: _Code,
        part: Part | None,
        certain: list[Part],
        answers: Answers,
    ) -> Index:
        """Which of the doubtful answers to `61 code` count; the first time, none."""
        doubtful = _NOWHERE if part is None else part.fitting[_is_one(part, answers)]
        rows, kinds = _settling(code, self._twice(code), certain, answers)
        if part is not None:
            rows.append(part.fitting[~_is_one(part, answers)])
            kinds.append(np.full(rows[-1].size, _OTHER))
        settling = np.concatenate([*rows, _NOWHERE])
        order = settling.argsort(kind="stable")
        within = settling[order].searchsorted(doubtful)
        if self._verdicts is not None:
            counting = doubtful[self._counts(code, state.stretch + within)]
        else:
            counting = _NOWHERE
            self._note(code, state, within, np.concatenate([*kinds, _NOWHERE])[order])
        state.stretch += settling.size
        return counting

    def _twice(self, code: int) -> int:
        """The number of the request that asks for `code` twice; -1: there is none."""
        request = bytes([_READ, code, code])
        return self._bodies.index(request) if request in self._bodies else -1

    def _note(self, code: int, state: _Code, within: Index, kinds: Index) -> None:
        """Which stretches do not count, as they end here; and how it is at the end."""
        count = kinds.size
        held = np.zeros(count + 1, np.bool_)
        held[within] = True
        held[0] |= state.waiting > 0
        decided = np.maximum.accumulate(np.where(kinds != _OTHER, np.arange(count), -1))
        wary = np.full(count + 1, state.wary)
        known = (decided >= 0).nonzero()[0]
        wary[known + 1] = kinds[decided[known]] == _REFUSAL
        refused = held[:count] & ((kinds == _REFUSAL) | ((kinds == _OTHER) & wary[:count]))
        numbers = (refused.nonzero()[0] + state.stretch).tolist()
        self._found.lone.setdefault(code, set()).update(numbers)
        state.waiting = int((within == count).sum()) + (0 if count else state.waiting)
        if count:
            state.wary = bool(wary[count])
            state.sure = bool(kinds[-1] == _DATUM)

    def _counts(self, code: int, stretches: Index) -> Mask:
        assert self._verdicts is not None
        last, last_counts = self._verdicts.last.get(code, (-1, False))
        counts: Mask = stretches < last
        counts |= (stretches == last) & last_counts
        refused = self._verdicts.lone.get(code)
        if refused and stretches.size:
            counts &= ~np.isin(stretches, np.array(sorted(refused)))
        return counts


def _settling(
    code: int, twice: int, certain: list[Part], answers: Answers
) -> tuple[list[Index], list[Index]]:
    """What settles a doubt about `code`, but for its own other answers: rows, and their kinds.

    `twice`: the number of the request `61 code code`.
    """
    rows: list[Index] = []
    kinds: list[Index] = []
    for part in certain:
        place = part.layout.last_of(code)
        if place is not None and part.fitting.size:
            values = answers.bodies[answers.starts[part.fitting] + place]
            rows.append(part.fitting)
            kinds.append(np.where(values == _ONE, _DATUM, _OTHER))
        if part.request == twice:
            short = part.rows[answers.lengths[part.rows] == 1]
            rows.append(short[answers.bodies[answers.starts[short]] == _ONE])
            kinds.append(np.full(rows[-1].size, _REFUSAL))
    return rows, kinds


def _is_one(part: Part, answers: Answers) -> Mask:
    one: Mask = answers.bodies[answers.starts[part.fitting]] == _ONE
    return one
