"""One request out, one response in, on a wire that echoes (D1, D2, D14). No policy: no retries
here.

`Line` is what the tester knows of the wire: it sends a frame and compares its echo byte by byte, it
collects the frame that answers, and it waits for silence. Every failure is an error that carries
what was sent, what came, and when; what to do about it is the tester's business.
"""

from __future__ import annotations

from math import inf

from mikas.errors import DamagedResponse, EchoDiffers, LineNotQuiet, NoEcho, NoResponse
from mikas.framing import Damage, DamageReason, Decoder, Frame, encode
from mikas.i18n import Text
from mikas.link import Chunk, Link
from mikas.tester.timed_decoder import TimedDecoder
from mikas.tester.timing import Reply, Timing

WRONG_CHECKSUM = Text("the checksum is wrong", "неверна контрольная сумма")
_DAMAGE = {
    DamageReason.CHECKSUM: WRONG_CHECKSUM,
    DamageReason.TOO_LONG: Text("it has no end", "у него нет конца"),
    DamageReason.IRREGULAR_ESCAPE: Text("an escape is wrong", "неверна замена байта"),
}
_AROUND = 2  # bytes of a response besides its body, at least: checksum and terminator
_CUT = Text("it ends in the middle", "он обрывается на середине")
_TOO_SOON = Text("it began while the request was being sent", "он начался, пока посылался запрос")
_DOUBLED = Text("more than one response came", "пришло больше одного ответа")


class Line:
    """A link seen as requests and responses. `echo`: whether the line gives back what is sent."""

    def __init__(
        self,
        link: Link,
        timing: Timing,
        *,
        echo: bool = True,
        raw_checksum: bool = False,
        strict: bool = False,
    ) -> None:
        self.link = link
        self.timing = timing
        self.echo = echo
        self.raw_checksum = raw_checksum
        self.strict = strict
        self.sent_until = -inf
        """When the last byte of the latest request was out."""
        self.echo_heard = -inf
        """When its echo had come; an adapter may make that itself, before the bytes are out."""
        self.silences = 0
        """How often nothing at all came to two requests in a row."""
        self._unanswered = 0  # requests in a row
        self._ahead = Chunk(b"", 0.0)  # came together with the end of an echo

    def exchange(self, body: bytes, *, of_many: bool = False, least: int = 0) -> Reply:
        """Sends `body`, returns the one response, or with `of_many` the first.

        `least`: the bytes of the shortest body that may be its response; only then is it worth
        while to look what has come. Raises `NoEcho` or a `LineError`.
        """
        wire, sent_at = self.send(body)
        return self.receive(wire, sent_at, of_many=of_many, least=least)

    def send(self, body: bytes, *, hasty: bool = False) -> tuple[bytes, float]:
        """Sends `body` and checks the echo; returns its wire form and the time when it was out.

        `hasty`: an echo that comes before the wire can have made it is heard when it comes.
        """
        wire = self.interject(body)
        if self.echo:
            if not hasty:  # all of it, and be it a little late: the response is later
                self.link.gather(self.sent_until + self.link.byte_time / 2)
            self.echo_heard = self._check_echo(wire, self.sent_until + self.timing.response_timeout)
            self.sent_until = max(self.sent_until, self.echo_heard)
        return wire, self.sent_until

    def interject(self, body: bytes) -> bytes:
        """Sends `body` and lets the echo come as it may; returns the wire form."""
        wire = encode(body, raw_checksum=self.raw_checksum)
        self._ahead = Chunk(b"", 0.0)
        self.sent_until = self.link.now() + len(wire) * self.link.byte_time
        self.link.write(wire)
        return wire

    def _check_echo(self, wire: bytes, deadline: float) -> float:
        received = bytearray()
        while len(received) < len(wire):
            chunk = self.link.read(deadline)
            if not chunk.data:
                error = EchoDiffers if received else NoEcho
                if not received:
                    self._count_silence()
                raise error(request=wire, received=bytes(received), time=chunk.time)
            received += chunk.data
            compared = min(len(received), len(wire))
            if received[:compared] != wire[:compared]:
                raise EchoDiffers(request=wire, received=bytes(received), time=chunk.time)
        extra = bytes(received[len(wire) :])
        self._ahead = Chunk(extra, chunk.time)
        return chunk.time - len(extra) * self.link.byte_time

    def receive(
        self, wire: bytes, sent_at: float, *, of_many: bool = False, least: int = 0
    ) -> Reply:
        """The one response to the request `wire`, which was out at `sent_at`.

        `of_many`: the first of those that a stream request brings; more may have come with it.
        `least`: as for `exchange`. The first byte is seen when it comes, so `began` is as exact as
        the adapter.
        """
        decoder = self.decoder()
        received = bytearray()
        deadline = sent_at + self.timing.response_timeout
        while True:
            chunk = self._next(deadline)
            if not chunk.data:
                if not received:
                    self._count_silence()
                raise self._nothing_more(wire, bytes(received), chunk.time)
            if not received:
                if chunk.time < sent_at + self.link.byte_time / 2 and not self.echo:
                    # No echo tells of the collision (D2), and the wreck of two frames may be sound.
                    raise self._damaged(wire, chunk.data, chunk.time, _TOO_SOON)
                self._unanswered = 0
            received += chunk.data
            deadline = chunk.time + self._pause()
            events = decoder.feed(chunk)
            if not events:
                # A pause inside (D14) must not be slept through: half of it at a time, so that one
                # that is too long is found, at worst so much later.
                missing = least + _AROUND - len(received)
                self._gather(chunk.time, missing, most=self.timing.inter_byte_timeout / 2)
                continue
            first, began = events[0]
            if isinstance(first, Damage):
                raise self._damaged(wire, bytes(received), chunk.time, _DAMAGE[first.reason])
            if not of_many and (len(events) > 1 or decoder.pending):
                # One of them answers an earlier request, and nothing says which (D13).
                raise self._damaged(wire, bytes(received), chunk.time, _DOUBLED)
            return Reply(first.body, first.wire, max(sent_at, began), chunk.time)

    def _count_silence(self) -> None:
        self._unanswered += 1
        self.silences += self._unanswered == 2

    def decoder(self) -> TimedDecoder:
        """For what comes from here on."""
        return TimedDecoder(Decoder(strict=self.strict), self.link.byte_time)

    def _next(self, deadline: float) -> Chunk:
        if self._ahead.data:
            chunk, self._ahead = self._ahead, Chunk(b"", 0.0)
            return chunk
        return self.link.read(deadline)

    def _gather(self, since: float, count: int, *, most: float = inf) -> None:
        """Lets `count` bytes come that can't be there `since` then yet; but for the last, so that
        its time is seen, and for `most` seconds.
        """
        if count > 1:
            self.link.gather(since + min((count - 1) * self.link.byte_time, most))

    def _pause(self) -> float:
        return self.timing.inter_byte_timeout + self.link.byte_time

    def _nothing_more(self, wire: bytes, received: bytes, time: float) -> Exception:
        if received:
            return self._damaged(wire, received, time, _CUT)
        return NoResponse(
            seconds=self.timing.response_timeout, request=wire, received=received, time=time
        )

    @staticmethod
    def damaged(wire: bytes, event: Damage, time: float) -> DamagedResponse:
        """The error for a response to `wire` that came as `event`."""
        return Line._damaged(wire, event.data, time, _DAMAGE[event.reason])

    @staticmethod
    def _damaged(wire: bytes, received: bytes, time: float, damage: Text) -> DamagedResponse:
        return DamagedResponse(damage=damage, request=wire, received=received, time=time)

    def arrived(self) -> bytes:
        """What came unasked, without waiting: a request is not begun on a talking line (D2)."""
        ahead, self._ahead = self._ahead.data, Chunk(b"", 0.0)
        return ahead + self.link.read(self.link.now()).data

    def wait_for_quiet(
        self, seconds: float, *, until: float = -inf, patience: float | None = None
    ) -> bytes:
        """Waits for the time `until`, and until nothing has come for `seconds`; returns what came.

        Raises `LineNotQuiet` if something still comes `patience` after the beginning (by default
        `timing.max_busy_time` more than `seconds`) and after `until`.
        """
        came = bytearray(self.arrived())
        began = self.link.now()
        last = max(
            until, began + (seconds + self.timing.max_busy_time if patience is None else patience)
        )
        quiet_at = max(until, began + seconds)
        while True:
            chunk = self.link.read(quiet_at)
            if not chunk.data:
                return bytes(came)
            came += chunk.data
            quiet_at = max(until, chunk.time + seconds)
            if chunk.time > last:
                raise LineNotQuiet(received=bytes(came[-64:]), time=chunk.time)

    def next_frame(
        self, decoder: TimedDecoder, deadline: float, *, least: int, heard: float
    ) -> list[tuple[Frame | Damage, float]]:
        """The next events of a stream, each with the time its bytes began; empty at the deadline.

        `least`: the bytes of the shortest body that comes, `heard`: when the last byte came.
        """
        while True:
            missing = least + _AROUND - len(decoder.pending)
            self._gather(heard, missing, most=max(0.0, deadline - heard))
            chunk = self._next(deadline)
            if not chunk.data:
                return []
            heard = chunk.time
            if events := decoder.feed(chunk):
                return events
