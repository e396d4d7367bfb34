"""In step with the ECU: what a response has to be before it is trusted (D12, D13).

A response carries neither its command nor an id. `Step` remembers whether a late one may still be
under way (`doubt`), and takes the doubt away: a quiet line, a clean `01`, exactly one response to
it, the unit's own, and silence behind it for as long as the late one could still come.
"""

from __future__ import annotations

from mikas.errors import (
    DamagedResponse,
    EchoOnly,
    LineError,
    LineNotQuiet,
    MikasError,
    NoEcho,
    NoResponse,
    OutOfStep,
)
from mikas.framing import TERMINATOR, encode
from mikas.tester.line import WRONG_CHECKSUM, Line

AVAILABILITY = b"\x01"

_ROUNDS = 5  # of D13 before giving up
_INTERRUPTIONS = 6  # attempts to end a stream before a line break, D12
_BREAK = 0.05  # s; far over the ten bits that a talker takes for a byte


class Step:
    """Whether the line and the unit are where the tester thinks they are."""

    def __init__(self, line: Line) -> None:
        self.line = line
        self.doubt: float | None = None
        """Seconds of silence that would take the doubt away; None: in step."""
        self.found_again = 0
        self.breaks = 0

    def lose(self, error: BaseException | None = None) -> None:
        """After `error`, or before something whose end is open, nothing that comes is trusted.

        A whole frame with a wrong checksum was this request's response, and nothing more is to
        come. After silence, a cut or another request's response the real one may still be on its
        way, for as long as a response takes at most.
        """
        over = isinstance(error, DamagedResponse) and error.fields.get("damage") == WRONG_CHECKSUM
        timing = self.line.timing
        self.doubt = timing.quiet if over else timing.first_byte

    def keep(self) -> None:
        """The exchange ended as it should."""
        self.doubt = None

    def assure(self, version_code: int) -> None:
        """Comes back in step if there is any doubt; what came unasked is reason enough for one.

        Raises `NoEcho` or `EchoOnly` if nobody is there any more, `LineNotQuiet`, `OutOfStep`.
        """
        if self.doubt is None:
            if not self.line.arrived():
                return
            self.lose()
        self.found_again += 1
        failure: MikasError = OutOfStep()
        for _ in range(_ROUNDS):
            try:
                self.silence()
                if self._confirm(version_code):
                    self.keep()
                    return
                failure = OutOfStep()
            except (NoEcho, EchoOnly) as error:
                if type(error) is type(failure):  # twice in a row: it is no accident
                    raise
                failure = error
            except LineError as error:
                failure = error
        raise failure

    def _confirm(self, version_code: int) -> bool:
        """D13: exactly one response, the unit's own, and a quiet line after it."""
        try:
            reply = self.line.exchange(AVAILABILITY)
        except NoResponse as error:
            raise nobody(error, echoes=self.line.echo) from error
        guard = max(self.doubt or 0.0, self.line.timing.quiet)
        came = self.line.wait_for_quiet(guard)
        return not came and reply.body == bytes([version_code])

    def silence(self) -> bytes:
        """Waits for a quiet line, ending a stream that keeps it from that; returns what came."""
        try:
            return self.line.wait_for_quiet(self.line.timing.quiet)
        except LineNotQuiet as error:
            self.lose()
            self.interrupt()
            return error.received or b""

    def interrupt(self) -> None:
        """Ends a stream: `01` in a gap, again if need be, at last after a line break (D12).

        Raises `LineNotQuiet` if the unit goes on all the same.
        """
        line, link = self.line, self.line.link
        for attempt in range(_INTERRUPTIONS + 1):
            if attempt < _INTERRUPTIONS:
                self._wait_for_gap()
                link.write(encode(AVAILABILITY, raw_checksum=line.raw_checksum))
            else:
                self.breaks += 1
                link.send_break(_BREAK)
            try:
                line.wait_for_quiet(line.timing.quiet, babble=line.timing.quiet)
            except LineNotQuiet:
                if attempt == _INTERRUPTIONS:
                    raise
            else:
                return

    def _wait_for_gap(self) -> None:
        """Until a response has just ended, or nothing has come for a moment."""
        link, timing = self.line.link, self.line.timing
        deadline = link.now() + timing.babble
        while link.now() < deadline:
            chunk = link.read(link.now() + timing.between_bytes)
            if not chunk.data or chunk.data[-1] == TERMINATOR:
                return


def nobody(error: NoResponse, *, echoes: bool) -> EchoOnly | NoEcho:
    """Silence after `01`: the ECU is not there, or with no echo nothing may be."""
    if echoes:
        return EchoOnly(request=error.request, received=error.request, time=error.time)
    return NoEcho(request=error.request, received=b"", time=error.time)
