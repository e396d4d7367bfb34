"""Runs of routine exchanges, whose responses differ only in their data, kept at once.

An exchange is routine if one more response to its request adds only data to the replay. The result
is the same as exchange by exchange. The first and the last exchange of a run are taken singly, so
that the builder's state before and after a run is complete.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from mikas import commands as c
from mikas.recording.exchanges.arrays import Floats, Index, Mask
from mikas.recording.exchanges.layouts import STREAMS
from mikas.recording.exchanges.pieces import joined
from mikas.recording.exchanges.refusals import is_lone, is_twice
from mikas.recording.exchanges.result import Exchanges
from mikas.replay.contents import ROUNDING, RecordedPort, Request
from mikas.replay.model import Series

if TYPE_CHECKING:
    from mikas.replay.build import ReplayBuilder

_MIN_RUN: Final = 16  # exchanges
_RETRY_AFTER: Final = 64  # rows after an attempt that found no run
_LOOKED_AT: Final = 256  # rows at first; twice as many after each run without an end


class Routine:
    """The routine exchanges of one stretch."""

    def __init__(self, builder: ReplayBuilder, port: RecordedPort, exchanges: Exchanges) -> None:
        self._builder = builder
        self._port = port
        self._exchanges = exchanges
        self._responses = responses = exchanges.responses
        self._usual: Mask = responses.requests == responses.after
        self._usual &= ~np.isin(responses.requests, exchanges.damaged)
        self._next_attempt = 0
        self._looked_at = _LOOKED_AT

    def add_routine(self, row: int) -> int:
        """Keep the routine exchanges from `row` on, but for the last one; return how many."""
        request = self._port.request
        steady = request and request.answered and self._builder.outages.failing_since is None
        if row < self._next_attempt or not request or not steady:
            return 0
        fits, series = self._fitting(slice(row, row + self._looked_at), request)
        self._looked_at = 2 * self._looked_at if fits.all() else _LOOKED_AT
        count = (int(fits.argmin()) if not fits.all() else fits.size) - 1
        if count < _MIN_RUN:
            self._next_attempt = row + _RETRY_AFTER
            return 0
        rows = np.arange(row, row + count)
        if request.body[0] in STREAMS:
            times = self._responses.times[rows] - ROUNDING
        else:
            requests = self._exchanges.requests
            times = requests.times[self._responses.requests[rows] - requests.first]
        times = times + self._builder.shift
        self._keep(rows, times, series)
        self._builder.data.frames += count
        return count

    def _fitting(self, rows: slice, request: Request) -> tuple[Mask, dict[int, Series]]:
        """Return which of these rows are routine, and the series by the request's number."""
        responses = self._responses
        numbers, serials = responses.numbers[rows], responses.requests[rows]
        lengths, starts = responses.lengths[rows], responses.starts[rows]
        streamed = request.body[0] in STREAMS
        expected = request.serial + (0 if streamed else 1 + np.arange(serials.size))
        fits: Mask = self._usual[rows] & (serials == expected)
        found: dict[int, Series] = {}
        different, at = np.unique(numbers, return_inverse=True)
        sizes = np.full(different.size, -1)
        for place, number in enumerate(different.tolist()):
            body = self._exchanges.bodies[number] if number >= 0 else b""
            if body and (body[0] in STREAMS) == streamed and (series := self._series_of(body)):
                found[number], sizes[place] = series, series.layout.length
        fits &= sizes[at] == lengths
        for number, series in found.items():
            for begin, size in self._port.resolver.followed(series.layout):
                if size == 1:
                    mine = (fits & (numbers == number)).nonzero()[0]
                    fits[mine] = responses.bodies[starts[mine] + begin] != 1
        return fits, found

    def _series_of(self, body: bytes) -> Series | None:
        """Return the series of a request of which one more response brings only data."""
        builder = self._builder
        series = builder.contents.series_of(body, self._port)
        if series is None or is_twice(body) or body[0] in c.StreamAtStroke.CODES:
            return None
        if body[0] in STREAMS:
            known = builder.behaviour.knows_gaps
        else:
            is_new = is_lone(body, series.layout) and not self._port.resolver.follows(body[1])
            known = builder.behaviour.is_known(body) and not is_new
        return series if known and builder.contents.is_routine(series, self._port) else None

    def _keep(self, rows: Index, times: Floats, series: dict[int, Series]) -> None:
        responses = self._responses
        numbers_of: dict[Series, list[int]] = {}
        for number, each in series.items():
            numbers_of.setdefault(each, []).append(number)
        latest: list[tuple[int, Series]] = []
        for each, numbers in numbers_of.items():
            chosen = np.isin(responses.numbers[rows], numbers).nonzero()[0]
            if chosen.size:
                mine = rows[chosen]
                bodies = joined(responses.bodies, responses.starts[mine], responses.lengths[mine])
                rising = np.maximum.accumulate(np.maximum(times[chosen], each.latest))
                each.extend(rising.tobytes(), bodies.tobytes())
                latest.append((int(mine[-1]), each))
        for row, each in sorted(latest, key=lambda it: it[0]):
            start = int(responses.starts[row])
            body = responses.bodies[start : start + each.layout.length].tobytes()
            self._port.resolver.pass_over(each.layout, body)
