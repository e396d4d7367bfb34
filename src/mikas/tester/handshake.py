"""Finding out what is behind a link: an echo or none, a Mikas, an ELM327, or nobody (D1)."""

from __future__ import annotations

from enum import Enum

from mikas.errors import (
    DamagedResponse,
    EchoDiffers,
    EchoOnly,
    NoEcho,
    NoResponse,
    NotAKLineAdapter,
    SyncLost,
)
from mikas.framing import TERMINATOR, encode
from mikas.tester.line import Line
from mikas.tester.line_sync import AVAILABILITY, LineSync, no_ecu_error

_ELM_TEXT = frozenset(b"?>\r\n .0123456789abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ")


class Echo(Enum):
    """Whether the line gives back what is sent; AUTO finds out at connect (D1)."""

    AUTO = "auto"
    ON = "on"
    OFF = "off"


def handshake(line: Line, step: LineSync, echo: Echo, *, again: bool = False) -> int:
    """Settles `line.echo` and returns the unit's version code, given twice and alike.

    `again`: it has failed before, so an earlier session's stream by strokes is looked for, which
    the pauses of a first, quick try may hide. Raises `NoEcho`, `EchoOnly`, `EchoDiffers`,
    `NotAKLineAdapter`, `SyncLost` or another `LineError`.
    """
    came = step.silence(patient=again)
    answered = _find_echo(line, echo, came)
    first = _ask_who(line, line.timing.idle_time, answered=answered)
    # Whatever an earlier session has left behind, a late answer or a stream by strokes, shows
    # itself in the silence of a whole `response_timeout` at the end.
    if _ask_who(line, line.timing.response_timeout, answered=True) != first:
        raise SyncLost(received=bytes([first]), time=line.link.now())
    return first


def _find_echo(line: Line, expected: Echo, came_before: bytes) -> bool:
    """`01` comes back as itself, or is answered by something that it can't be.

    Settles `line.echo`, against what is `expected`; returns whether there was more than an echo.
    """
    request, data = _call(line)
    if not data:
        request, data = _call(line)  # without an echo, one lost answer looks like a dead line
    if not data:
        raise NoEcho(request=request, received=data, time=line.link.now())
    refuse_elm(came_before + data)
    sound = len(data) > 2 and data[-1] == TERMINATOR and sum(data[:-1]) & 0xFF == 0
    line.echo = data.startswith(request)
    if data == request and expected is Echo.OFF:
        raise EchoOnly(request=request, received=data, time=line.link.now())
    if (not line.echo and not sound) or expected is (Echo.OFF if line.echo else Echo.ON):
        raise EchoDiffers(request=request, received=data, time=line.link.now())
    return data != request


def _call(line: Line) -> tuple[bytes, bytes]:
    """Sends `01`; returns it and all that comes then."""
    link, timing = line.link, line.timing
    request = line.interject(AVAILABILITY)
    deadline = line.sent_until + timing.response_timeout
    last = deadline + timing.max_busy_time
    received = bytearray()
    while (chunk := link.read(deadline)).data and chunk.time < last:
        received += chunk.data
        if not request.startswith(received):
            # More than the echo has come: that is enough to tell. The rest is waited out.
            deadline = min(chunk.time + timing.idle_time, last)
    return request, bytes(received)


def _ask_who(line: Line, quiet: float, *, answered: bool) -> int:
    """The one-byte answer to `01`, with nothing behind it for `quiet` seconds.

    `answered`: the unit has answered before, so its silence is a lost response.
    """
    try:
        reply = line.exchange(AVAILABILITY)
    except NoResponse as error:
        if answered:
            raise
        raise no_ecu_error(error, echoes=line.echo) from error
    except DamagedResponse as error:
        refuse_elm(error.received or b"")
        raise
    came = line.wait_for_quiet(quiet)
    if came or len(reply.body) != 1:
        raise SyncLost(request=encode(AVAILABILITY), received=reply.wire + came, time=reply.ended)
    return reply.body[0]


def refuse_elm(came: bytes) -> None:
    """Raises `NotAKLineAdapter` if `came` is what an ELM327 says to bytes that it takes for
    text.
    """
    text = came.replace(encode(AVAILABILITY), b"").lstrip(b"\x01\xff")
    if _ELM_TEXT.issuperset(text) and (b"?" in text or b">" in text):
        raise NotAKLineAdapter(received=came)
