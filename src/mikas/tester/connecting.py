"""Finding out what is behind a link: an echo or none, a Mikas, an ELM327, or nobody (D1)."""

from __future__ import annotations

from enum import Enum

from mikas.errors import (
    DamagedResponse,
    EchoDiffers,
    NoEcho,
    NoResponse,
    NotAKLineAdapter,
    OutOfStep,
)
from mikas.framing import TERMINATOR, encode
from mikas.tester.line import Line
from mikas.tester.step import AVAILABILITY, Step, nobody

_ELM_TEXT = frozenset(b"?>\r\n .0123456789abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ")


class Echo(Enum):
    """Whether the line gives back what is sent; AUTO finds out at connect (D1)."""

    AUTO = "auto"
    ON = "on"
    OFF = "off"


def introduce(line: Line, step: Step, echo: Echo) -> int:
    """Settles `line.echo` and returns the unit's version code, given twice and alike.

    Raises `NoEcho`, `EchoOnly`, `EchoDiffers`, `NotAKLineAdapter`, `OutOfStep` or another
    `LineError`.
    """
    came = step.silence()
    line.echo = _find_echo(line, came) if echo is Echo.AUTO else echo is Echo.ON
    first = _ask_who(line)
    if _ask_who(line) != first:  # one of them was a late answer to somebody else
        raise OutOfStep(received=bytes([first]), time=line.link.now())
    return first


def _find_echo(line: Line, came_before: bytes) -> bool:
    """`01` comes back as itself, or is answered by something that it can't be."""
    link, request = line.link, encode(AVAILABILITY, raw_checksum=line.raw_checksum)
    link.write(request)
    deadline = link.now() + len(request) * link.byte_time + line.timing.first_byte
    received = bytearray()
    while (chunk := link.read(deadline)).data:
        received += chunk.data
        if not request.startswith(received):
            # More than the echo has come: that is enough to tell. The rest is waited out.
            deadline = chunk.time + line.timing.quiet
    data = bytes(received)
    if not data:
        raise NoEcho(request=request, received=data, time=chunk.time)
    refuse_elm(came_before + data)
    if data.startswith(request):
        return True
    if len(data) > 2 and data[-1] == TERMINATOR and sum(data[:-1]) & 0xFF == 0:
        return False  # a sound frame and no echo before it
    raise EchoDiffers(request=request, received=data, time=chunk.time)


def _ask_who(line: Line) -> int:
    try:
        reply = line.exchange(AVAILABILITY)
    except NoResponse as error:
        raise nobody(error, echoes=line.echo) from error
    except DamagedResponse as error:
        refuse_elm(error.received or b"")
        raise
    came = line.wait_for_quiet(line.timing.quiet)
    if came or len(reply.body) != 1:
        raise OutOfStep(request=encode(AVAILABILITY), received=reply.wire + came, time=reply.ended)
    return reply.body[0]


def refuse_elm(came: bytes) -> None:
    """Raises `NotAKLineAdapter` if `came` is what an ELM327 says to bytes that it takes for
    text.
    """
    text = came.replace(encode(AVAILABILITY), b"").lstrip(b"\x01\xff")
    if _ELM_TEXT.issuperset(text) and (b"?" in text or b">" in text):
        raise NotAKLineAdapter(received=came)
