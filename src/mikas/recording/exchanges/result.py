"""The interpretation of recorded traffic: requests, and which of them each response answers.

`exchanges.columns.matcher` and, in a browser, `exchanges.turns` yield the same result, a stretch of
packets at a time, for tables, exports, replay, summary and report. All columns are arrays.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from collections.abc import Collection, Iterator, Sequence

    from mikas.recording.capture.reader import Source
    from mikas.recording.exchanges.arrays import Bytes, Floats, Index

GAP: Final = 0.5
"""s; `Exchanges.gaps` lists longer times without a packet."""

JUMP: Final = 1.0
"""s; where times run back by more, a clock was set, and a stretch ends. Less is jitter."""

LONGEST_PAUSE: Final = 86_400.0
"""s; a stretch also ends where no packet came for longer: another day, as in another recording."""


@dataclass(frozen=True, slots=True)
class Requests:
    """Sent frames in order. `first`: the serial of the first one; serials count through all
    stretches of a port. `numbers`: of their bodies in `Exchanges.bodies`; -1: damaged. `times`: of
    the packets with their first bytes. `lengths`: bytes on the wire.
    """

    first: int
    numbers: Index
    times: Floats
    lengths: Index


@dataclass(frozen=True, slots=True)
class Responses:
    """Sound received frames that are no echo, in order.

    `starts`, `lengths`: of their bodies in `bodies`. `times`: when their first bytes began on the
    wire. `requests`, `numbers`: serials and bodies of the requests that they answer; -1: not known.
    `after`: serials of the last requests before them. `wire_lengths`: bytes on the wire.
    """

    bodies: Bytes
    times: Floats
    requests: Index
    numbers: Index
    after: Index
    starts: Index
    lengths: Index
    wire_lengths: Index

    def body(self, row: int) -> bytes:
        """Return the body of one response."""
        start = self.starts[row]
        return bytes(self.bodies[start : start + self.lengths[row]])


@dataclass(frozen=True, slots=True)
class Exchanges:
    """A stretch of one port's traffic.

    `bodies`: all request bodies of the port so far, by number; grows. `damaged`: for every damaged
    received frame that is no echo, the serial of the last request before it. `lists_lost`: the same
    for where the unit's list (63) is not known any more, of a missing part too. `echoes`: number of
    echoes. `raw_checksum`: whether a response had one (D3). `gaps`: (begin, end) of times longer
    than `GAP` without a packet. `begin`, `end`: times of the first and last packet.
    """

    source: Source
    bodies: list[bytes]
    requests: Requests
    responses: Responses
    damaged: Index
    lists_lost: Sequence[int]
    echoes: int
    raw_checksum: bool
    gaps: Sequence[tuple[float, float]]
    begin: float
    end: float

    def answers(self, requests: Collection[bytes]) -> Iterator[tuple[float, bytes, bytes]]:
        """Yield (time, request, response) of the responses to these requests, as bodies."""
        numbers = self.responses.numbers.tolist()
        wanted = {it for it in set(numbers) if it >= 0 and self.bodies[it] in requests}
        for row, number in enumerate(numbers) if wanted else ():
            if number in wanted:
                yield self.responses.times[row], self.bodies[number], self.responses.body(row)
