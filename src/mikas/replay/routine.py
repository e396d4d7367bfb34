"""Runs of routine exchanges, whose responses differ only in their data, kept at once.

An exchange is routine if one more response to its request adds only data to the replay. The result
is the same as exchange by exchange. The first and the last exchange of a run are taken singly, so
that the builder's state before and after a run is complete.
"""

from __future__ import annotations

from itertools import chain
from typing import Final

import numpy as np

from mikas import commands as c
from mikas.recording.exchanges.arrays import Floats, Index, Mask, present
from mikas.recording.exchanges.columns.pieces import joined
from mikas.recording.exchanges.groups import ResponseGroup
from mikas.recording.exchanges.layouts import STREAMS
from mikas.recording.exchanges.result import Exchanges
from mikas.replay.contents import ROUNDING, RecordedPort, Request
from mikas.replay.model import Series
from mikas.replay.outages import Outages

_MIN_RUN: Final = 16  # exchanges
_RETRY_AFTER: Final = 64  # rows after an attempt that found no run
_LOOKED_AT: Final = 256  # rows at first; twice as many after each run without an end


class Routine:
    """The routine exchanges of one stretch."""

    def __init__(
        self,
        port: RecordedPort,
        exchanges: Exchanges,
        groups: list[ResponseGroup],
        outages: Outages,
        shift: float,
    ) -> None:
        self._port = port
        self._outages = outages
        self._shift = shift
        self._exchanges = exchanges
        self._groups = groups
        self._responses = responses = exchanges.responses
        self._group = np.full(len(responses.times), -1)  # of each response that may be routine
        for number, group in enumerate(groups):
            self._group[group.fitting] = number
        self._group[responses.requests != responses.after] = -1
        self._group[np.isin(responses.requests, exchanges.damaged)] = -1
        self._group[port.refusals.doubtful] = -1
        self._next_attempt = 0
        self._looked_at = _LOOKED_AT

    def add_routine(self, row: int) -> int:
        """Keep the routine exchanges from `row` on, but for the last one; return how many."""
        request = self._port.request
        steady = request and request.answered and self._outages.failing_since is None
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
        self._keep(rows, times + self._shift, series)
        return count

    def _fitting(self, rows: slice, request: Request) -> tuple[Mask, dict[Series, list[int]]]:
        """Return which of these rows are routine, and the numbers of their groups by series."""
        serials, groups = self._responses.requests[rows], self._group[rows]
        streamed = request.body[0] in STREAMS
        expected = request.serial + (0 if streamed else 1 + np.arange(serials.size))
        found: dict[Series, list[int]] = {}
        for number in present(groups[groups >= 0]):
            if self._is_routine(self._groups[number], streamed=streamed):
                series = self._port.contents.series_of(self._groups[number].layout)
                found.setdefault(series, []).append(number)
        fits: Mask = (serials == expected) & np.isin(groups, [*chain(*found.values())])
        return fits, found

    def _is_routine(self, group: ResponseGroup, *, streamed: bool) -> bool:
        """Return whether one more response of a group brings only data."""
        body, behaviour = self._exchanges.bodies[group.request], self._port.contents.behaviour
        if (body[0] in STREAMS) != streamed or body[0] in c.StreamAtStroke.CODES:
            return False
        known = behaviour.knows_gaps if streamed else behaviour.is_known(body)
        return known and not self._port.contents.is_refused(group.layout)

    def _keep(self, rows: Index, times: Floats, series: dict[Series, list[int]]) -> None:
        responses = self._responses
        for each, numbers in series.items():
            chosen = np.isin(self._group[rows], numbers).nonzero()[0]
            if chosen.size:
                mine = rows[chosen]
                bodies = joined(responses.bodies, responses.starts[mine], responses.lengths[mine])
                rising = np.maximum.accumulate(np.maximum(times[chosen], each.latest))
                each.extend(rising.tobytes(), bodies.tobytes())
