"""The link interface: bytes out, bytes in with their arrival times, and the clock (§1).

Every higher layer waits with `Link.read` and takes the time from `Link.now`, in plain blocking
code. So the same tester runs on an adapter in real time and on a simulated bus at full speed.

A link knows no frames, echo, requests or retries. One thread at a time uses it; only `close` may be
called from another. The contract suite `mikas.testing.LinkContract` checks the sentences below.
"""

from __future__ import annotations

import time
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from math import inf
from typing import NamedTuple, Protocol, Self, runtime_checkable

from mikas.errors import LineError, LinkClosed, LinkLost, NoConnection, PortKind
from mikas.i18n import Text
from mikas.link.clocks import WallClock

BAUD = 9600  # §1
BITS_PER_BYTE = 10  # §1: start bit, eight data bits, stop bit

# s; by so much bytes may come late and together, through (D14):
AT_ONCE = 0.001  # an adapter without a latency timer, or with one of 1 ms; WebUSB adds as much
LATENCY_TIMER = 0.016  # the FT232's own setting
WEB_SERIAL = LATENCY_TIMER + 0.014  # a page can't change that timer; a browser's buffers
NETWORK = 0.2  # a Wi-Fi bridge

PATIENCE = 2.0  # s; a write may take so much longer than its time on the wire
LONGEST_REQUEST = 1024  # bytes; 26 with 255 data bytes, all of them stuffed, has 519 (§2.4)

EMPTY_LINES = b"\r\n\r\n\r"  # no request to a unit (§2.2, D5); a server of lines answers
TEXT_ANSWER = 0.5  # s that such an answer may take

# Why a link is lost, after "the adapter is gone:"
CLOSED_HERE = Text("it was closed here", "он закрыт этой программой")
TAKES_NO_BYTES = Text("it takes no more bytes", "он не принимает байты")
UNPLUGGED = Text("unplugged, or closed by the other end", "отключён или закрыт другой стороной")


def link_lost(
    url: str, why: Text, *, request: bytes | None = None, time: float | None = None
) -> LinkLost:
    """Return the error of a link that is gone; after `CLOSED_HERE` no plug is to blame."""
    if why is CLOSED_HERE:
        return LinkClosed(url=url, request=request, time=time)
    return LinkLost(url=url, problem=why, request=request, time=time)


class Chunk(NamedTuple):
    """The bytes of one read; empty if the deadline passed first.

    `time`: the link's clock when the last byte was seen, or when the wait ended.
    """

    data: bytes
    """The bytes; empty: none came."""
    time: float
    """The link's clock when the last byte was seen, or when the wait ended."""


class AwaitedAnswer(NamedTuple):
    """How a link knows an answer that has come whole.

    It is the echo of the request, then one frame of a right checksum (§2), and nothing behind it.
    """

    echo: bytes
    """The request that was written last, as on the wire."""
    length: int
    """Bytes of the response's body."""


class Link(ABC):
    """A wire with a clock. Opened by `mikas.link.open_link`; usable as a context manager.

    A link of your own has a `url` (its name in messages), `write`, `read`, `now`, `send_break` and
    `close`; `examples/socket_link` is one. `WallClock` is a clock that never runs back.
    `connect(link=…)` takes it.
    """

    url: str
    """The port, as the user wrote it."""

    baud: int = BAUD
    """Bits a second on the wire (§1)."""

    kind: PortKind = PortKind.CABLE
    """What lies between this computer and the K-Line, for the words of errors."""

    opened: float = inf
    """The clock when the port was opened, if `PortAhead` did so; `read` returns what came since."""

    is_virtual: bool = False
    """Whether the unit is known to be a virtual or a replayed one."""

    is_simulated: bool = False
    """Whether its time passes only while it is used."""

    granularity: float = LATENCY_TIMER
    """Seconds by which bytes may come late and together (D14); that of a latency timer."""

    _can_break: bool = True

    @property
    def can_break(self) -> bool:
        """Whether `send_break` pulls the wire low; may turn false at the first attempt."""
        return self._can_break

    @property
    def description(self) -> str:
        """The adapter's name for display; never empty."""
        return self.url

    @property
    def chip(self) -> str:
        """The adapter's USB serial chip (`FT232R`); empty: unknown."""
        return ""

    @property
    def byte_time(self) -> float:
        """Seconds that one byte takes on the wire: 1.0417 ms at 9600 baud."""
        return BITS_PER_BYTE / self.baud

    @abstractmethod
    def write(self, data: bytes) -> None:
        """Hand `data` to the adapter; return once the system has accepted all bytes.

        The wire then still needs `byte_time` for each byte. Raises `LinkLost` if the adapter is
        gone, accepts nothing for seconds, or the link is closed; how much was sent is unknown.
        """

    @abstractmethod
    def read(self, deadline: float) -> Chunk:
        """Wait for bytes until `deadline` of this link's clock; return all that have arrived.

        An empty chunk is returned at the deadline, never earlier; a deadline in the past does not
        wait. Ctrl-C interrupts the wait. Raises `LinkLost` at once if the adapter is gone or the
        link is closed; bytes that arrived before may be returned first, or be lost.
        """

    @abstractmethod
    def now(self) -> float:
        """Return the clock in seconds: UNIX time (`WallClock`) or simulated time.

        The clock never runs back, and works on a closed or lost link too.
        """

    def date(self) -> float:
        """Return the computer's date, in UNIX time, for kept files; if simulated, the clock.

        It follows when the date is set, and may run back then.
        """
        return self.now() if self.is_simulated else time.time()

    def gather(self, until: float) -> None:  # noqa: B027  (a back end need not sleep)
        """Sleep until this time of the link's clock, so that bytes accumulate for the next `read`.

        The computer then wakes up once and not for every byte. The default does not sleep. Never
        raises `LinkLost`; the next `read` does.
        """

    def write_after(self, answer: AwaitedAnswer, data: bytes) -> bool:  # noqa: ARG002  (a back end may)
        """Let the link itself write `data` once `answer` has come; return whether it can.

        For a link that sees bytes earlier than this program. Doubtful bytes are no answer to it.
        What comes after that write is read after `take_back`, which always follows.
        """
        return False

    def take_back(self) -> float | None:
        """Return when the link wrote the data of `write_after`; None: it did not, and will not."""
        return None

    @abstractmethod
    def send_break(self, seconds: float) -> None:
        """Hold the wire low for `seconds`, to silence a transmitter (D12).

        If the port can't, `can_break` turns false and the time passes. Raises `LinkLost`.
        """

    def set_baud(self, baud: int) -> bool:  # noqa: ARG002  (a back end may)
        """Change the baud rate of the open port; return whether the link can. `baud` follows.

        What was written before has to have left. The default changes nothing. Raises `LinkLost`.
        """
        return False

    @abstractmethod
    def close(self) -> None:
        """Close the port; a second call does nothing.

        `read`, `write` and `send_break` then raise `LinkLost`, a `read` that waits in another
        thread within a second.
        """

    def explained(self, error: NoConnection | LineError) -> NoConnection | LineError:
        """Return the error to raise for a handshake that failed with `error`.

        It is another one where the other end of a network port has said what it is.
        """
        return error

    def give_up(self) -> None:
        """As `close`, for a link whose other end may not learn of it, or keeps from closing."""
        self.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


class LinkWrapper(Link):
    """A link that passes every call on to `link`; a subclass overrides what differs."""

    def __init__(self, link: Link) -> None:
        self.link = link
        """The inner link."""
        self.url: str = link.url
        self.baud: int = link.baud
        self.kind: PortKind = link.kind
        self.opened: float = link.opened
        self.is_virtual: bool = link.is_virtual
        self.is_simulated: bool = link.is_simulated
        self.granularity: float = link.granularity

    @property
    def description(self) -> str:
        return self.link.description

    @property
    def chip(self) -> str:
        return self.link.chip

    @property
    def can_break(self) -> bool:
        return self.link.can_break

    def write(self, data: bytes) -> None:
        self.link.write(data)

    def read(self, deadline: float) -> Chunk:
        return self.link.read(deadline)

    def gather(self, until: float) -> None:
        self.link.gather(until)

    def write_after(self, answer: AwaitedAnswer, data: bytes) -> bool:
        return self.link.write_after(answer, data)

    def take_back(self) -> float | None:
        return self.link.take_back()

    def now(self) -> float:
        return self.link.now()

    def date(self) -> float:
        return self.link.date()

    def send_break(self, seconds: float) -> None:
        self.link.send_break(seconds)

    def set_baud(self, baud: int) -> bool:
        can = self.link.set_baud(baud)
        self.baud = self.link.baud
        return can

    def close(self) -> None:
        self.link.close()

    def give_up(self) -> None:
        self.link.give_up()

    def explained(self, error: NoConnection | LineError) -> NoConnection | LineError:
        return self.link.explained(error)


class Direction(Enum):
    """The direction of bytes, seen from the tester."""

    SENT = "sent"
    """To the unit."""
    RECEIVED = "received"
    """From the line, echo included."""


class Sink(Protocol):
    """The receiver of the bytes."""

    def record(self, direction: Direction, data: bytes, time: float) -> None:
        """Record `data`; `time` is the link's clock and never runs back."""


@runtime_checkable
class BaudSink(Protocol):
    """A sink that keeps the bytes of another baud rate apart."""

    def change_baud(self, baud: int | None) -> None:
        """Take all bytes from here on as of this rate; None: of the one at the begin."""


@dataclass(slots=True)
class WireCount:
    """The bytes on the wire of links that follow each other; an echo is not counted twice."""

    bytes: int = 0
    echoes: bool = True  # whether the line echoes what is sent; to be set once that is known


class CaptureTee(LinkWrapper):
    """`link`, with every byte also recorded by `sink`, in the order of the tester's calls.

    - Received bytes have their chunk's time.
    - Sent bytes have the time when the system had accepted them: about when the first bit goes out,
      and never later than the echo. Bytes that the link refused are not recorded.
    - A failing sink ends the recording: `failure` keeps the exception for the sink's owner, and
      `on_failure` gets it, once. What that raises is raised again by each later call, so that
      nothing is exchanged unrecorded unless somebody wants that.
    - Closing the tee closes the link, not the sink.
    - `wire` counts the bytes, also after a failure of the sink.
    """

    def __init__(
        self,
        link: Link,
        sink: Sink,
        wire: WireCount | None = None,
        on_failure: Callable[[Exception], None] = lambda _: None,
    ) -> None:
        super().__init__(link)
        self._on_failure = on_failure
        self._refusal: Exception | None = None
        self.failure: Exception | None = None
        """The exception of the sink; None: it works."""
        self._wire = wire or WireCount()
        self._sink = sink
        self._prepared = b""
        self._usual_baud = link.baud
        self._wall = WallClock()

    @property
    def date_set(self) -> float:
        """The seconds by which the computer's date was set since; 0 if time is simulated."""
        return 0.0 if self.is_simulated else self._wall.date() - self._wall.now()

    def write(self, data: bytes) -> None:
        self.link.write(data)
        if data:
            self._record(Direction.SENT, data, self.link.now())

    def read(self, deadline: float) -> Chunk:
        chunk = self.link.read(deadline)
        if chunk.data:
            self._record(Direction.RECEIVED, chunk.data, chunk.time)
        return chunk

    def set_baud(self, baud: int) -> bool:
        can = super().set_baud(baud)
        if can and self.failure is None and isinstance(self._sink, BaudSink):
            self._sink.change_baud(None if self.baud == self._usual_baud else self.baud)
        return can

    def write_after(self, answer: AwaitedAnswer, data: bytes) -> bool:
        self._prepared = data
        return self.link.write_after(answer, data)

    def take_back(self) -> float | None:
        written = self.link.take_back()
        if written is not None:
            self._record(Direction.SENT, self._prepared, written)
        return written

    def _record(self, direction: Direction, data: bytes, time: float) -> None:
        wire = self._wire
        if direction is Direction.RECEIVED or not wire.echoes:
            wire.bytes += len(data)
        if self._refusal is not None:
            raise self._refusal.with_traceback(None)  # else each call would lengthen it
        if self.failure is not None:
            return
        try:
            self._sink.record(direction, data, time)
        except Exception as error:  # any: a sink of other code
            self.failure = error
            try:
                self._on_failure(error)
            except Exception as refusal:  # any: whoever records decides by it
                self._refusal = refusal
                raise
