"""The interpretation of recorded traffic: requests, and which of them each response answers.

`exchanges.scalar` (the reference, without numpy) and `exchanges.columnar` (arrays) yield the same
result, a stretch of packets at a time, for tables, exports, replay, summary and report.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Generic, Protocol, TypeVar, overload

if TYPE_CHECKING:
    from collections.abc import Collection, Iterator, Sequence

    import numpy as np
    from numpy.typing import NDArray

    from mikas.recording.capture.reader import Source

GAP: Final = 0.5
"""s; `Exchanges.gaps` lists longer times without a packet."""

JUMP: Final = 1.0
"""s; where times run back by more, a clock was set, and a stretch ends. Less is jitter."""

LONGEST_PAUSE: Final = 86_400.0
"""s; a stretch also ends where no packet came for longer: another day, as in another recording."""

T = TypeVar("T")


class Column(Protocol[T]):
    """An `array.array` or a numpy array of one dimension."""

    def __len__(self) -> int: ...

    @overload
    def __getitem__(self, index: int, /) -> T: ...

    @overload
    def __getitem__(self, index: slice, /) -> Column[T]: ...

    def tolist(self) -> list[T]:
        """Return the values as a list."""


B_co = TypeVar("B_co", bound="bytes | NDArray[np.uint8]", covariant=True)
F_co = TypeVar("F_co", bound=Column[float], covariant=True)
I_co = TypeVar("I_co", bound=Column[int], covariant=True)


@dataclass(frozen=True, slots=True)
class Requests(Generic[F_co, I_co]):
    """Sent frames in order. `first`: the serial of the first one; serials count through all
    stretches of a port. `numbers`: of their bodies in `Exchanges.bodies`; -1: damaged. `times`: of
    the packets with their first bytes. `lengths`: bytes on the wire.
    """

    first: int
    numbers: I_co
    times: F_co
    lengths: I_co


@dataclass(frozen=True, slots=True)
class Responses(Generic[B_co, F_co, I_co]):
    """Sound received frames that are no echo, in order.

    `starts`, `lengths`: of their bodies in `bodies`. `times`: when their first bytes began on the
    wire. `requests`, `numbers`: serials and bodies of the requests that they answer; -1: not known.
    `after`: serials of the last requests before them. `wire_lengths`: bytes on the wire.
    """

    bodies: B_co
    times: F_co
    requests: I_co
    numbers: I_co
    after: I_co
    starts: I_co
    lengths: I_co
    wire_lengths: I_co

    def body(self, row: int) -> bytes:
        """Return the body of one response."""
        start = self.starts[row]
        return bytes(self.bodies[start : start + self.lengths[row]])


@dataclass(frozen=True, slots=True)
class ExchangesOf(Generic[B_co, F_co, I_co]):
    """A stretch of one port's traffic.

    `bodies`: all request bodies of the port so far, by number; grows. `damaged`: for every damaged
    received frame that is no echo, the serial of the last request before it. `echoes`: number of
    echoes. `raw_checksum`: whether a response had one (D3). `gaps`: (begin, end) of times longer
    than `GAP` without a packet. `begin`, `end`: times of the first and last packet.
    """

    source: Source
    bodies: list[bytes]
    requests: Requests[F_co, I_co]
    responses: Responses[B_co, F_co, I_co]
    damaged: I_co
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


Exchanges = ExchangesOf["bytes | NDArray[np.uint8]", Column[float], Column[int]]
