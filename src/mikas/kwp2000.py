"""Messages of KWP2000 (ISO 14230-2): only what names a unit that speaks it, not the Mikas protocol.

    83 F1 10  C1 EF 8F  C4
    header    data      checksum: the sum of all before

The header's first byte has the length of the data in its low six bits (0: a byte of its own
follows the addresses) and the kind of addresses in its top two (0: there are none).
"""

from __future__ import annotations

from typing import NamedTuple

BAUD = 10_400
TESTER = 0xF1
ENGINE = 0x10
"""The address of an engine's unit."""
OBD = 0x33
"""The address that every unit of ISO 14230-4 answers after the slow wake-up."""
SYNC = 0x55
"""The first byte after a slow wake-up."""

START = b"\x81"
PRESENT = b"\x3e"
STOP = b"\x82"
POSITIVE = 0x40
"""Added to the service in a positive response."""
REFUSED = 0x7F


class KwpMessage(NamedTuple):
    """One message; without addresses they are None."""

    data: bytes
    target: int | None
    source: int | None
    length: int
    """Bytes on the wire."""


def encode(data: bytes, target: int = ENGINE, source: int = TESTER) -> bytes:
    """Return a message with addresses as on the wire: `81` → `81 10 F1 81 03`."""
    body = bytes([0x80 | len(data), target, source]) + data
    return body + bytes([sum(body) & 0xFF])


def decode(received: bytes) -> KwpMessage | None:
    """Return the message that `received` begins with; None: it is none, or not whole."""
    if not received:
        return None
    form = received[0]
    addressed, length = form & 0xC0, form & 0x3F
    begin = 3 if addressed else 1
    if not length:
        if len(received) <= begin:
            return None
        length, begin = received[begin], begin + 1
    end = begin + length
    if not length or len(received) <= end or sum(received[:end]) & 0xFF != received[end]:
        return None
    target, source = (received[1], received[2]) if addressed else (None, None)
    return KwpMessage(received[begin:end], target, source, end + 1)


def find(received: bytes) -> KwpMessage | None:
    """Return the first message in `received`; bytes before it are noise."""
    for at in range(len(received)):
        if (message := decode(received[at:])) is not None:
            return message
    return None
