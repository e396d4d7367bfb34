"""What `mikas decode` makes of a capture, in the form of `tshark_harness.decoded`."""

from __future__ import annotations

from functools import partial
from itertools import groupby
from pathlib import Path

from mikas import commands as c
from mikas.catalog import Catalog, shipped
from mikas.errors import MikasError
from mikas.link.base import Direction
from mikas.recording.capture.reader import CaptureReader, Packet
from mikas.recording.exchanges.scalar import DecodedDamage, DecodedFrame
from mikas.recording.inspect import Describer, decode, to_json

Part = DecodedFrame | DecodedDamage


def parts(path: Path, catalog: Catalog | None = None, interpretation="corrected") -> list[Part]:
    describer = partial(Describer, catalog or shipped(), interpretation)
    items = decode(CaptureReader(path), describer)
    return [item for item in items if isinstance(item, Part)]


def line(part: Part) -> dict:
    line = to_json(part)
    del line["schema"], line["offset"]
    if line["recording"]:
        line["port"] = ""  # as `tshark_harness.Shown`
    for name in ("meaning", "doubt"):
        if line.get(name):
            line[name] = line[name]["en"]
    return line


def without_ends(path: Path, found: list[Part]) -> list[Part]:
    """Leave out the frames in which a recording ends: one pass can't know that nothing follows."""
    last = {}
    for packet in CaptureReader(path):
        if isinstance(packet, Packet):
            last[packet.source, packet.direction] = packet.time
    return [
        part
        for part in found
        if not (
            isinstance(part, DecodedDamage)
            and part.abandoned
            and part.end == last[part.source, part.direction]
        )
    ]


def values(found: list[Part], catalog: Catalog, interpretation="corrected") -> list[list[tuple]]:
    """Return the parameters of each frame with their values, by `mikas.commands` and catalog."""
    result = []
    for _, recorded in groupby(found, lambda part: part.source.recording):
        lists: dict[str, tuple[c.Datum, ...]] = {}
        result += [_values(part, lists, catalog, interpretation) for part in recorded]
    return result


def _values(part: Part, lists: dict, catalog: Catalog, interpretation: str) -> list[tuple]:
    port = part.source.url
    if not isinstance(part, DecodedFrame) or part.echo:
        return []
    request = part.frame.body if part.direction is Direction.SENT else part.request
    if part.direction is Direction.SENT:
        if request[:1] == b"\x64":
            lists[port] = ()
        return []
    if request == b"\x63" and not part.knows_list:
        return []
    command = _command(request, lists.get(port, ()), catalog)
    if command is None:
        return []
    body = part.frame.body
    try:
        data = command.read(body)
    except MikasError:
        return []
    if isinstance(command, c.WriteList):
        lists[port] = command.parameters
    asked = getattr(command, "parameters", ())
    if not isinstance(data, tuple) or not asked or part.meaning.en.startswith("a value of 01"):
        return []
    return [
        (parameter.name, parameter.decode(raw, interpretation))
        for datum, raw in zip(asked, data, strict=True)
        for parameter in catalog.by_code(datum.code)
    ]


def _command(request: bytes | None, listed: tuple, catalog: Catalog):
    if request is None:
        return None
    if request == b"\x63":
        return c.ReadList(listed) if listed else None
    try:
        return c.parse(request, catalog.size_of)
    except c.MalformedRequest:
        return None
