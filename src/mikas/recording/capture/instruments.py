"""Instruments in a capture: each has an interface of its own, of link type 148, beside the unit's.

    if_name         its port, as of the unit's
    if_description  `left:aem, AEM wide-band gauge`: label, definition, text for a person
    if_speed        bits a second of a serial port
    opt_comment     the text of the definition, so that the bytes can be decoded anywhere

A packet is a chunk that the instrument sent. One without bytes says by its comment that the
connection began, or was lost: so a message is never made of bytes from both sides of a loss. All
that stays with the interface when another tool cuts, shifts or merges recordings.
"""

from __future__ import annotations

import os
import re
import struct
from collections.abc import Iterator
from typing import Final

from mikas.cancellation import check_cancelled
from mikas.catalog import Catalog
from mikas.cleaning import clean_line, public_port
from mikas.errors import UsageError
from mikas.i18n import Text
from mikas.instruments import InstrumentDefinition, definition_named, definition_of_text
from mikas.instruments.choosing import line_baud
from mikas.recording.capture import blocks as pcapng
from mikas.recording.capture.dating import corrections_in
from mikas.recording.capture.opening import opened_capture
from mikas.recording.capture.reader import Blocks, Packet, Source
from mikas.recording.capture.scan import RawBlock, scan

CONNECTED: Final = "connected"
LOST: Final = "lost"
_NAME: Final = re.compile(r"(?:([A-Za-z][A-Za-z0-9_]{0,19}):)?([a-z0-9][a-z0-9-]{0,39})(?:,|$)")


def instrument_port(
    definition: InstrumentDefinition, url: str, label: str = ""
) -> pcapng.Interface:
    """Return the description of an instrument's port."""
    name = f"{label}:{definition.name}" if label else definition.name
    return pcapng.Interface(
        link_type=pcapng.LINKTYPE_USER1,
        name=public_port(url),
        description=f"{name}, {clean_line(definition.text.en)}",
        speed=line_baud(definition, url),
        comment=definition.toml,
    )


def loss(reason: Text) -> str:
    """Return the comment of a lost connection."""
    return f"{LOST}\n{clean_line(reason.en)}\n{clean_line(reason.ru)}"


def loss_of(packet: Packet) -> Text | None:
    """Return why the connection was lost here; None: it was not."""
    word, _, reason = packet.comment.partition("\n")
    if packet.data or word != LOST:
        return None
    en, _, ru = reason.partition("\n")
    return Text(en, ru or en)


def label_and_name(source: Source) -> tuple[str, str]:
    """Return the label and the definition's name of an instrument's port; empty: not known."""
    match = _NAME.match(source.description)
    return (match[1] or "", match[2]) if match else ("", "")


def recorded_definition(source: Source, catalog: Catalog) -> InstrumentDefinition:
    """Return the present definition of an instrument's name, or that in the file if none is known.

    Raises `UsageError` if neither can be used.
    """
    _, name = label_and_name(source)
    try:
        return definition_named(name, catalog)
    except UsageError:
        return definition_of_text(name, source.definition, catalog)


def instrument_packets(path: str | os.PathLike[str]) -> Iterator[Packet]:
    """Yield the packets of instruments, in the order of the file.

    Damage is a matter of the unit's readers. Raise as `CaptureReader` does.
    """
    with opened_capture(path) as file:
        blocks = Blocks(corrections_in(file), pcapng.LINKTYPE_USER1)
        for item in scan(file):
            check_cancelled()
            if isinstance(item, RawBlock) and _is_of_unit(item, blocks):
                continue
            yield from (each for each in blocks.read(item) if isinstance(each, Packet))


def _is_of_unit(block: RawBlock, blocks: Blocks) -> bool:
    """Return whether this is a packet of another port, which need not be read."""
    if block.kind != pcapng.ENHANCED or len(block.body) < 4:
        return False
    number = int(struct.unpack_from(block.order + "I", block.body)[0])
    known = blocks.interfaces
    return number < len(known) and known[number][0].link_type != pcapng.LINKTYPE_USER1
