"""The behaviour of a recorded ECU: the commands it lacks, its longest list, its delays.

The outcomes of all requests become the settings of a virtual ECU that behaves in the same way (D3,
D7, D10, D11, D14). Requests during a loss of supply do not count, nor does a single lost response
to a command that the ECU answered at other times.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Collection
from statistics import median
from typing import Final

from mikas import commands as c
from mikas.commands.base import ERROR
from mikas.virtual.quirks import EcuQuirks, LongList, Unknown

_MIN_FAILURES: Final = 2  # of longer requests; fewer may be lost responses
_MOST_DELAYS: Final = 1000
_MAX_DELAY: Final = 1.0  # s

_LISTS: Final = frozenset(
    [0x61, 0x64, *c.StreamCyclic.CODES, *c.StreamAtStroke.CODES]
)  # their size is the number of codes
_BLOCKS: Final = frozenset([0x21, 0x23, 0x25])  # the count is the last byte


class EcuBehaviour:
    """Counts the outcomes of requests."""

    def __init__(self) -> None:
        self.raw_checksum = False
        self.counted_blocks = False
        self._answered: dict[int, int] = {}  # command code → the longest list or block
        self._failed: list[tuple[float, bytes, bytes | None]] = []
        self._delays: list[float] = []
        self._gaps: list[float] = []

    def answered(self, request: bytes, delay: float | None) -> None:
        """Note a response to `request`, `delay` seconds after its end, if known."""
        code = request[0]
        size = _size(request)
        if size >= self._answered.get(code, 0):
            self._answered[code] = size
        if delay is not None and len(self._delays) < _MOST_DELAYS:
            self._delays.append(delay)

    @property
    def answered_codes(self) -> frozenset[int]:
        """The commands that were answered at least once."""
        return frozenset(self._answered)

    def is_known(self, request: bytes) -> bool:
        """Return whether one more response to `request` would change nothing."""
        longest = self._answered.get(request[0], -1)
        return _size(request) <= longest and len(self._delays) >= _MOST_DELAYS

    @property
    def knows_gaps(self) -> bool:
        """Whether one more response of a stream would change nothing."""
        return len(self._gaps) >= _MOST_DELAYS

    def streamed(self, gap: float) -> None:
        """Note one more response of a stream, `gap` seconds after the end of the last one."""
        if len(self._gaps) < _MOST_DELAYS:
            self._gaps.append(gap)

    def failed(self, time: float, request: bytes, response: bytes | None) -> None:
        """Note that `request` got no response, or a refusal or too short `response`."""
        self._failed.append((time, request, response))

    def conclude(
        self, has_supply: Callable[[float], bool], known: Collection[int]
    ) -> tuple[EcuQuirks, dict[int, bytes | None]]:
        """Return the ECU's quirks, and its response to each command code that it lacks.

        `known`: its parameter codes; failed lists with other codes do not count.
        """
        failed = [
            (request, response)
            for time, request, response in self._failed
            if request and has_supply(time) and _asks_known(request, known)
        ]
        responses_of: dict[int, Counter[bytes | None]] = {}
        for request, response in failed:
            if request[0] not in self._answered and response in (None, ERROR):
                responses_of.setdefault(request[0], Counter())[response] += 1
        refusals = {code: each.most_common(1)[0][0] for code, each in responses_of.items()}
        refusals.pop(c.Availability.CODES[0], None)  # without it, no session is possible
        tried = [(request, it) for request, it in failed if request[0] in self._answered]
        max_list, short = self._limit(_LISTS, tried)
        quirks = EcuQuirks(
            turn_round=_typical(self._delays, EcuQuirks().turn_round),
            stream_gap=_typical(self._gaps, EcuQuirks().stream_gap),
            max_list=max_list,
            long_list=LongList.SHORT if short else LongList.SILENT,
            max_block=self._limit(_BLOCKS, tried)[0],
            unknown=self._unknown(),
            missing=frozenset(refusals),
            counted_blocks=self.counted_blocks,
            raw_checksum=self.raw_checksum,
        )
        return quirks, refusals

    def _limit(
        self, codes: Collection[int], tried: list[tuple[bytes, bytes | None]]
    ) -> tuple[int, bool]:
        """Return the longest answered list or block, if longer ones failed, and whether a response
        to these was too short.
        """
        longest = max((size for code, size in self._answered.items() if code in codes), default=0)
        over = [
            response
            for request, response in tried
            if request[0] in codes and _size(request) > longest
        ]
        if not longest or len(over) < _MIN_FAILURES:
            return 255, False
        return longest, any(response not in (None, ERROR) for response in over)

    def _unknown(self) -> Unknown:
        errors = sum(response == ERROR for _, _, response in self._failed)
        return Unknown.ERROR if 2 * errors > len(self._failed) else Unknown.SILENT


def _typical(seconds: list[float], default: float) -> float:
    return round(min(max(median(seconds), 0.0), _MAX_DELAY), 6) if seconds else default


def _size(request: bytes) -> int:
    if request[0] in _LISTS:
        return len(request) - 1
    return request[-1] if request[0] in _BLOCKS else 0


def _asks_known(request: bytes, known: Collection[int]) -> bool:
    return request[0] not in _LISTS or all(code in known for code in request[1:])
