"""A line as a file: its packets, and where a part of it is missing."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Final

from fuzz.exchanges.sessions import Packet
from mikas.recording.capture import blocks as pcapng

PORTS: Final = ("/dev/ttyUSB0", "/dev/ttyUSB1")
_DAMAGED: Final = b"\x15" * 16  # no block: readers say that a part is missing


def file_of(sections: Iterable[Sequence[Packet]]) -> bytes:
    """Return a file with these sections."""
    return b"".join(map(_section, sections))


def _section(packets: Sequence[Packet]) -> bytes:
    parts = [pcapng.encode(pcapng.Section(application="mikas fuzz"))]
    parts += [pcapng.encode(pcapng.Interface(name=name, speed=9600)) for name in PORTS]
    return b"".join([*parts, *map(_block, packets)])


def _block(packet: Packet) -> bytes:
    if packet.missing:
        return _DAMAGED
    flags = pcapng.OUTBOUND if packet.sent else pcapng.INBOUND
    ticks = max(0, round(packet.time * 1e6))
    return pcapng.encode(pcapng.EnhancedPacket(packet.port, ticks, packet.data, flags))


def text_of(sections: Iterable[Sequence[Packet]]) -> str:
    """Return the packets for a person: time, port, direction, bytes; `+`: not as recorded."""
    lines = []
    for number, packets in enumerate(sections):
        lines += [f"section {number}"]
        for it in packets:
            what = "a part is missing" if it.missing else it.data.hex(" ")
            mark = "+" if it.changed else " "
            lines.append(f" {mark}{it.time:12.6f} {it.port} {'>' if it.sent else '<'} {what}")
    return "\n".join(lines)
