"""The handshake: detects the echo, a Mikas, an ELM327, or a dead line (D1)."""

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
    """Whether the line returns the sent bytes; AUTO detects it at connect (D1)."""

    AUTO = "auto"
    ON = "on"
    OFF = "off"


def handshake(line: Line, sync: LineSync, echo: Echo, *, again: bool = False) -> int:
    """Set `line.echo`; return the unit's version code, received twice.

    `again`: after a failed handshake, also end a stream by strokes of an earlier session, which the
    short waits of the first attempt may miss. Raises `NoEcho`, `EchoOnly`, `EchoDiffers`,
    `NotAKLineAdapter`, `SyncLost` or another `LineError`.
    """
    received = sync.silence(patient=again)
    answered = _find_echo(line, echo, received)
    first = _request_version(line, line.timing.idle_time, answered=answered)
    # A late answer or a stream by strokes of an earlier session shows in the silence of a whole
    # `response_timeout` at the end.
    if _request_version(line, line.timing.response_timeout, answered=True) != first:
        raise SyncLost(received=bytes([first]), time=line.link.now())
    return first


def _find_echo(line: Line, expected: Echo, received_before: bytes) -> bool:
    """Set `line.echo` by the bytes that follow `01`; return whether more than an echo arrived."""
    request, data = _send_availability(line)
    if not data:  # without an echo, one lost answer looks like a dead line
        request, data = _send_availability(line)
    if not data:
        raise NoEcho(request=request, received=data, time=line.link.now())
    refuse_elm(received_before + data)
    sound = len(data) > 2 and data[-1] == TERMINATOR and sum(data[:-1]) & 0xFF == 0
    line.echo = data.startswith(request)
    if data == request and expected is Echo.OFF:
        raise EchoOnly(request=request, received=data, time=line.link.now())
    if (not line.echo and not sound) or expected is (Echo.OFF if line.echo else Echo.ON):
        raise EchoDiffers(request=request, received=data, time=line.link.now())
    return data != request


def _send_availability(line: Line) -> tuple[bytes, bytes]:
    """Send `01`; return its frame and all bytes received."""
    link, timing = line.link, line.timing
    request = line.interject(AVAILABILITY)
    deadline = line.sent_until + timing.response_timeout
    last = deadline + timing.max_busy_time
    received = bytearray()
    while (chunk := link.read(deadline)).data and chunk.time < last:
        received += chunk.data
        if not request.startswith(received):
            # More than the echo has arrived, which is enough. Wait for the rest to end.
            deadline = min(chunk.time + timing.idle_time, last)
    return request, bytes(received)


def _request_version(line: Line, quiet: float, *, answered: bool) -> int:
    """Return the one-byte answer to `01`, followed by `quiet` seconds of silence.

    `answered`: the unit has answered before, so silence is a lost response.
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
    extra = line.wait_for_quiet(quiet)
    if extra or len(reply.body) != 1:
        raise SyncLost(request=encode(AVAILABILITY), received=reply.wire + extra, time=reply.ended)
    return reply.body[0]


def refuse_elm(received: bytes) -> None:
    """Raise `NotAKLineAdapter` for the answer of an ELM327, which interprets bytes as text."""
    text = received.replace(encode(AVAILABILITY), b"").lstrip(b"\x01\xff")
    if _ELM_TEXT.issuperset(text) and (b"?" in text or b">" in text):
        raise NotAKLineAdapter(received=received)
