"""The handshake: is there an echo, a Mikas, an ELM327, or nothing behind the link (D1)?"""

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
    """Whether the line returns what is sent; AUTO finds out at connect (D1)."""

    AUTO = "auto"
    ON = "on"
    OFF = "off"


def handshake(line: Line, step: LineSync, echo: Echo, *, again: bool = False) -> int:
    """Set `line.echo` and return the unit's version code, which it has to give twice.

    `again`: the handshake has failed before; so look for a stream by strokes of an earlier session,
    which the short waits of the first attempt may miss. Raises `NoEcho`, `EchoOnly`, `EchoDiffers`,
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

    Sets `line.echo`, checked against `expected`; returns whether more than an echo came.
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
    """Send `01`; return it and all bytes that come."""
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
    """Return the one-byte answer to `01`, after which nothing comes for `quiet` seconds.

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
    """Raise `NotAKLineAdapter` if `came` is an ELM327's answer to bytes that it takes for text."""
    text = came.replace(encode(AVAILABILITY), b"").lstrip(b"\x01\xff")
    if _ELM_TEXT.issuperset(text) and (b"?" in text or b">" in text):
        raise NotAKLineAdapter(received=came)
