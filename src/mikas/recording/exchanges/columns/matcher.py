"""Recorded exchanges as arrays: the result of `exchanges.scalar`, many times faster (D1, D13).

`columns.directions` cuts each direction into frames, `columns.turn_runs` matches them.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from functools import partial
from typing import BinaryIO

import numpy as np

from mikas.commands.base import SizeOf
from mikas.recording.capture.blocks import Order
from mikas.recording.capture.notes import Note
from mikas.recording.capture.reader import Blocks, Problem, Source
from mikas.recording.exchanges.arrays import Floats, Index
from mikas.recording.exchanges.columns.directions import Events, PacketStream
from mikas.recording.exchanges.columns.packets import WINDOW, PacketColumns, Packets, Window, read
from mikas.recording.exchanges.columns.pieces import equal
from mikas.recording.exchanges.columns.turn_runs import DAMAGE, ECHO, LISTED, Turns
from mikas.recording.exchanges.fitting import Fitting
from mikas.recording.exchanges.layouts import READ_LIST
from mikas.recording.exchanges.matching import Matching
from mikas.recording.exchanges.ports import matched
from mikas.recording.exchanges.result import GAP, Exchanges, Requests, Responses
from mikas.recording.exchanges.verdicts import NO_REQUEST


def column_exchanges(
    path: str | os.PathLike[str], size_of: SizeOf, window: int = WINDOW
) -> Iterator[Exchanges | Problem | Note]:
    """Yield the exchanges of a capture. Raise as `CaptureReader` does."""
    return matched(read(path, window), partial(ColumnarMatcher, fitting=Fitting(size_of)))


def responses_in(
    file: BinaryIO, piece: range, order: Order, blocks: Blocks, size_of: SizeOf
) -> tuple[int, int]:
    """Return the number of responses in a run of packets at the begin of a piece of a file, and the
    length of the run in bytes. `blocks`: as before the piece.
    """
    window = Window(file, piece.start, len(piece), order)
    found, end = window.run(piece.start)
    if not found.size or not blocks.interfaces:
        return 0, 0
    runs, fitting = PacketColumns(window, found, blocks).packets(0, found.size), Fitting(size_of)
    stretches = (ColumnarMatcher(packets.source, fitting).feed(packets) for packets in runs)
    return sum(len(each.responses.times) for each in stretches), end - piece.start


class ColumnarMatcher:
    """The exchanges of one port of one recording."""

    def __init__(self, source: Source, fitting: Fitting) -> None:
        self.matching: Matching = Matching(fitting, source.byte_time)
        self._source = source
        self._sent = PacketStream(source.byte_time)
        self._received = PacketStream(source.byte_time)
        self._sent_last = False
        self._last: float = np.inf
        self._latest = np.full(2, NO_REQUEST)  # numbers of the last two requests
        self._lengths: Index = np.empty(0, np.int64)  # of responses, by the request's number

    def go_on(self, stream: bytes) -> None:
        """Go on with the responses to a stream whose request is missing."""
        self.matching.interrupt(stream)
        self._latest = np.array([self._latest[-1], self.matching.number(stream)])

    def feed(self, packets: Packets) -> Exchanges:
        """Return the exchanges that these packets complete."""
        after_sent = np.concatenate(([self._sent_last], packets.sent[:-1]))
        self._sent_last = bool(packets.sent[-1])
        turns = (packets.sent & ~after_sent).cumsum()
        count = int(turns[-1]) + 1
        requests = self._sent.events(
            packets, (packets.sent, turns, count), np.zeros_like(after_sent)
        )
        responses = self._received.events(packets, (~packets.sent, turns, count), after_sent)
        first = self.matching.count
        self._number_requests(requests)
        self._add_lengths()
        turned = Turns(self.matching, requests, responses, (packets, turns), self._lengths)
        answers = turned.answers()
        self.matching.count = first + requests.index.size
        after = first - 1 + requests.turns.searchsorted(responses.turns, "right")
        chosen = (answers > ECHO).nonzero()[0]
        sent_times = requests.begins
        return Exchanges(
            source=self._source,
            bodies=self.matching.bodies,
            requests=Requests(first, requests.numbers, sent_times, requests.lengths),
            responses=self._responses(requests, responses, chosen, answers, after),
            damaged=after[answers == DAMAGE],
            lists_lost=self.matching.take_lists_lost(),
            echoes=int(np.count_nonzero(answers == ECHO)),
            raw_checksum=bool(responses.block.raw_checksum[responses.index[chosen]].any()),
            gaps=self._gaps(packets.times),
            begin=float(packets.times[0]),
            end=float(packets.times[-1]),
        )

    def _add_lengths(self) -> None:
        matching = self.matching
        new = [
            LISTED if body == READ_LIST else matching.fitting.length(body, None)
            for body in matching.bodies[self._lengths.size :]
        ]
        if new:
            self._lengths = np.concatenate((self._lengths, np.array(new)))

    def _number_requests(self, sent: Events) -> None:
        """Number the requests; equal ones in a row are looked up once."""
        block, starts = sent.block, sent.starts
        new = np.ones(sent.index.size, np.bool_)
        same = (sent.lengths[1:] == sent.lengths[:-1]) & sent.sound[1:] & sent.sound[:-1]
        pairs = same.nonzero()[0]
        new[pairs + 1] = ~equal(
            block.wire, starts[pairs], block.wire, starts[pairs + 1], sent.lengths[pairs]
        )
        numbers = [self.matching.number(sent.body(event)) for event in new.nonzero()[0].tolist()]
        if numbers:
            sent.numbers[:] = np.array(numbers)[new.cumsum() - 1]

    def _responses(
        self, requests: Events, responses: Events, chosen: Index, answers: Index, after: Index
    ) -> Responses:
        block, events = responses.block, responses.index[chosen]
        serials = answers[chosen]
        # A response answers one of the last two earlier requests, or one of this stretch.
        first = self.matching.count - requests.index.size
        known = np.concatenate((self._latest, requests.numbers))
        numbers = known[np.maximum(serials - first + 2, 0)]
        numbers[serials == NO_REQUEST] = NO_REQUEST
        self._latest = known[-2:]
        return Responses(
            times=self._received.wire_times(block, events),
            requests=serials,
            numbers=numbers,
            after=after[chosen],
            bodies=block.bodies,
            starts=block.body_starts[events],
            lengths=block.body_ends[events] - block.body_starts[events],
            wire_lengths=responses.lengths[chosen],
        )

    def _gaps(self, times: Floats) -> list[tuple[float, float]]:
        before = np.concatenate(([self._last], times[:-1]))
        self._last = float(times[-1])
        at = (times - before > GAP).nonzero()[0]
        return list(zip(before[at].tolist(), times[at].tolist(), strict=True))
