"""The rules of matching: which received frame is an echo, which request a response answers.

On a line with echo, the first received frame that repeats a sent frame byte for byte is its echo
(D1). A response can look like an echo too (`11 11` may be answered `11 11`), so the availability
request, whose response never repeats it, decides whether the line echoes at all. A response carries
neither its command nor an identifier: a frame that is no echo counts as the response to the last
request before it (D13).

`exchanges.scalar` applies these rules to every frame, `exchanges.columnar` and `exchanges.turns`
only to irregular traffic: for regular traffic they compute their outcome in one step.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Iterator
from typing import TYPE_CHECKING, Final, NamedTuple, Protocol, TypeVar

from mikas.commands import COMMANDS_BY_CODE, Availability
from mikas.recording.capture.notes import Note
from mikas.recording.capture.reader import Problem, Source
from mikas.recording.exchanges.result import Exchanges

if TYPE_CHECKING:
    from mikas.recording.exchanges.packets import Packets
    from mikas.recording.exchanges.runs import PacketRun

# s; an unfinished frame is abandoned after such a silence: longer than D14's pause inside a
# response and a latency timer. If a request was sent in between, the tester has abandoned it.
SILENCE: Final = 0.25
SILENCE_AFTER_SENDING: Final = 0.02

AVAILABILITY: Final = Availability().body()
_MOST_UNECHOED: Final = 64


class SentRequest(NamedTuple):
    """A request frame. `serial`: counts all frames sent on the port from 0; -1: not known.
    `body`: None if not known, or damaged.
    """

    serial: int
    body: bytes | None


NO_REQUEST: Final = -1
UNKNOWN: Final = SentRequest(NO_REQUEST, None)


class Matching:
    """The state of one port. `request`: the last one; `count`: how many were sent.

    `echoes`: whether the line returns the sent bytes; None: not known yet.
    """

    def __init__(self) -> None:
        self.request = UNKNOWN
        self.count = 0
        self.echoes: bool | None = None
        self.bodies: list[bytes] = []
        self._numbers: dict[bytes, int] = {}
        self._before = UNKNOWN
        self._unechoed: deque[bytes] = deque(maxlen=_MOST_UNECHOED)

    def number(self, body: bytes | None) -> int:
        """Return the number of a request body, its place in `bodies`; NO_REQUEST for None."""
        if body is None:
            return NO_REQUEST
        number = self._numbers.setdefault(body, len(self.bodies))
        if number == len(self.bodies):
            self.bodies.append(body)
        return number

    @property
    def settled(self) -> bool:
        """Whether, until something is sent, no frame can be an echo or change this state."""
        if self.echoes or self.request.body != AVAILABILITY:
            return self.echoes is False or not self._unechoed
        return False

    @property
    def answered(self) -> SentRequest:
        """The request that a response at this point answers."""
        # Before its echo, a frame can't be the response to the request that was just sent.
        return self._before if self.echoes and self._unechoed else self.request

    def turn(self) -> None:
        """Begin to send after receiving: missing echoes will not follow any more."""
        self._unechoed.clear()

    def interrupt(self) -> None:
        """Drop the requests: a part of the file is missing, perhaps with a request in it.

        A stream continues: its next response is one of many.
        """
        body = self.request.body
        command = COMMANDS_BY_CODE.get(body[0]) if body else None
        if command is None or not command.STREAM:
            self.request = UNKNOWN
        self._before = UNKNOWN

    def sent(self, wire: bytes, body: bytes | None) -> None:
        """Take a sent frame, or damage, which has no `body`."""
        self._before, self.request = self.request, SentRequest(self.count, body)
        self.count += 1
        self._unechoed.append(wire)

    def follow(self, count: int, before: bytes | None, body: bytes, wire: bytes) -> None:
        """Follow `count` requests, each one with its echo, if the line echoes, and no other frames
        but responses. `before`, `body`, `wire`: of the last two, and of the last one on the wire.
        """
        self.count += count
        self._before = SentRequest(self.count - 2, before) if count > 1 else self.request
        self.request = SentRequest(self.count - 1, body)
        self._unechoed.clear()
        if not self.echoes:
            self._unechoed.append(wire)

    def received(self, wire: bytes, body: bytes | None) -> bool:
        """Take a received frame, or damage; return whether it is an echo."""
        if body is None:
            self._before = self.request  # the damage may have been the echo
        came_back = wire in self._unechoed
        if self.request.body == AVAILABILITY and body is not None and len(body) == 1:
            if came_back:
                self.echoes = True
            elif self.echoes is None:
                self.echoes = False
        if self.echoes is False or not came_back:
            return False
        while self._unechoed.popleft() != wire:
            pass
        return True


P = TypeVar("P", bound="Packets | PacketRun")
P_contra = TypeVar("P_contra", contravariant=True)


class Matcher(Protocol[P_contra]):
    """One port of one recording."""

    matching: Matching

    def feed(self, packets: P_contra, /) -> Exchanges:
        """Return the exchanges that these packets complete."""


def matched(
    items: Iterable[P | Problem | Note], matcher: Callable[[Source], Matcher[P]]
) -> Iterator[Exchanges | Problem | Note]:
    """Yield the exchanges of stretches of packets; each port of a recording has a matcher."""
    ports: dict[Source, Matcher[P]] = {}
    for item in items:
        if isinstance(item, Note):
            yield item
            continue
        if isinstance(item, Problem):
            for port in ports.values():
                port.matching.interrupt()
            yield item
            continue
        source = item.source
        if source not in ports:
            if any(other.recording != source.recording for other in ports):
                ports.clear()
            ports[source] = matcher(source)
        yield ports[source].feed(item)
