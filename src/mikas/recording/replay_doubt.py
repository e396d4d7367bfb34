"""Which `01`s to a 61 with one code of one byte are data, and which the refusal of D10, in order.

The rules are those of `exchanges.refusals`: the code's next datum confirms what waits, an
`01` to the same code asked for twice (`61 P P`) refutes it, and makes wary of later ones until a
datum 01 came that can't be a refusal. Until it is confirmed an `01` is not played; while a code is
refused the replayed unit refuses it too, rather than telling its last value again and again.
"""

from __future__ import annotations

from array import array
from collections.abc import Callable, ValuesView
from dataclasses import dataclass, field
from typing import Final

from mikas import commands as c
from mikas.commands.base import ERROR
from mikas.recording.replay_recorded import Latest, Recorded, Series

_READ: Final = c.ReadParameters.CODES[0]
_TWICE: Final = 3  # bytes of `61 P P`
_BELIEVED: Final = 2  # of 01s at the end, if who asked knew to ask twice


@dataclass(slots=True)
class Doubt:
    """About one code. `waiting`: times of `01`s that nothing has settled yet."""

    series: Series
    waiting: array[float] = field(default_factory=lambda: array("d"))
    sure: bool = False  # behind an 01 beyond doubt


class Doubts:
    """Of the present recording. `series`: all there are; `refuted` is told the time and the request
    of each refusal.
    """

    def __init__(
        self,
        found: Recorded,
        series: ValuesView[Series],
        refuted: Callable[[float, bytes], None],
    ) -> None:
        self.of: dict[int, Doubt] = {}
        self.since = 0.0
        """When the recording began."""
        self._found = found
        self._series = series
        self._refuted = refuted
        self._twice: set[int] = set()  # codes that were asked for twice at once
        self._wary: set[int] = set()  # behind an 01 to that, and no 01 beyond doubt since

    @property
    def followed(self) -> set[int]:
        """Codes of which every datum tells something."""
        return self.of.keys() | self._found.refused.keys()

    def asked(self, request: bytes) -> None:
        """`request` was sent."""
        if len(request) == _TWICE and request[0] == _READ and request[1] == request[2]:
            self._twice.add(request[1])

    def about(self, request: bytes, series: Series) -> Doubt | None:
        """What is held of the code that `request` asks for alone; None: an `01` to it is clear."""
        if not (len(request) == 2 and request[0] == _READ and series.size == 1):
            return None
        code = request[1]
        if code not in self.of:
            sure = code not in self._wary and self._was_one(code)
            self.of[code] = Doubt(series, sure=sure)
        return self.of[code]

    def holds(self, request: bytes, body: bytes, time: float, series: Series) -> bool:
        """Whether `body` is doubtful, the answer to a `request` of `time`; then it waits here."""
        doubt = self.about(request, series)
        if doubt is None or body != ERROR:
            return False
        doubt.waiting.append(time)
        return True

    def refused(self, request: bytes, time: float) -> None:
        """`request` was answered `01`, and that is no datum."""
        if request[0] != _READ or len(set(request[1:])) != 1:
            return
        code = request[1]
        doubt = self.of.get(code)
        if doubt is None:
            self._mark(code, time)
        elif len(request) == _TWICE:
            self._drop(code, doubt, time)
            doubt.sure = False
        if len(request) == _TWICE:
            self._wary.add(code)

    def settle(self, series: Series, body: bytes, time: float) -> None:
        """A response with data beyond doubt, before it is kept."""
        for code in self.followed:
            place = series.last_of(code)
            if place is not None:
                begin, size = place
                self.settled(code, time, one=body[begin : begin + size] == ERROR)

    def run(
        self,
        code: int,
        doubtful: list[float],
        behind: list[int],
        settling: list[float],
        ones: list[bool],
    ) -> list[bool]:
        """Many responses at once, none of them a refusal: which of the doubtful ones count.

        `doubtful`, `settling`: their times; `behind`: how many of the latter were before each of
        the former; `ones`: which of those are 01. Some that do not count wait here, as they would
        one by one.
        """
        doubt = self.of.get(code)
        counting = [False] * len(doubtful)
        count = len(settling)
        trusted = 0  # from which settling one on
        if code in self._wary:
            trusted = ones.index(True) if True in ones else count
        for at, place in enumerate(behind):
            if place >= trusted:
                counting[at] = place < count
        for place in sorted({0, trusted, *(it for it in behind if it < trusted)}):
            if place < count:
                if doubt is not None and place < trusted:
                    doubt.waiting.extend(
                        time for time, it in zip(doubtful, behind, strict=True) if it == place
                    )
                self.settled(code, settling[place], one=ones[place])
        if doubt is not None:
            if count:
                doubt.sure = ones[-1]
            doubt.waiting.extend(
                time for time, it in zip(doubtful, behind, strict=True) if it == count
            )
        return counting

    def settled(self, code: int, time: float, *, one: bool) -> None:
        """The code has a datum beyond doubt. `one`: it is 01."""
        doubt = self.of.get(code)
        if doubt is not None:
            if one or code not in self._wary:
                self._keep(doubt)
            elif doubt.waiting:
                self._drop(code, doubt, time)
            doubt.sure = one
        if one:
            self._wary.discard(code)
        if code in self._found.refused:
            self._found.refused[code].add(time, value=False)

    def conclude(self, time: float) -> None:
        """The recording ends."""
        for code, doubt in self.of.items():
            believed = len(doubt.waiting) >= _BELIEVED and code in self._twice - self._wary
            if doubt.sure or believed:
                self._keep(doubt)
            elif doubt.waiting:
                self._drop(code, doubt, time)
        self.of.clear()
        self._twice.clear()
        self._wary.clear()

    def _was_one(self, code: int) -> bool:
        """Whether the code's latest datum was 01."""
        told = [
            (series.times[-1], series.datum(len(series.times) - 1, *place))
            for series in self._series
            if series.times
            and series.times[-1] >= self.since
            and (place := series.last_of(code)) is not None
        ]
        return bool(told) and max(told)[1] == ERROR

    def _keep(self, doubt: Doubt) -> None:
        for time in doubt.waiting:
            doubt.series.add(time, ERROR)
        del doubt.waiting[:]

    def _drop(self, code: int, doubt: Doubt, time: float) -> None:
        self._mark(code, doubt.waiting[0] if doubt.waiting else time)
        for each in doubt.waiting:
            self._refuted(each, bytes([_READ, code]))
        del doubt.waiting[:]

    def _mark(self, code: int, time: float) -> None:
        refused = self._found.refused.setdefault(code, Latest())
        if not refused.values:
            refused.add(0.0, value=False)
        refused.add(time, value=True)
