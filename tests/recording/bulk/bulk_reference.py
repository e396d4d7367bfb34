"""What the bulk decoder has to come to: the same by `decode`, the commands and the catalog."""

from __future__ import annotations

from collections import defaultdict
from math import nan

from mikas import commands as c
from mikas.errors import MikasError
from mikas.link.tee import Direction
from mikas.recording.decode import SeenFrame, decode
from mikas.recording.reader import Packet


def answers(items):
    """(source, time, body, request, list) of every sound received frame that is no echo.

    `list`: the codes of the last 64, if `00` has answered it and no other was sent since.
    """
    items = list(items)
    ends = defaultdict(list)  # of received packets: up to where in their stream, and when
    for packet in items:
        if isinstance(packet, Packet) and packet.direction is Direction.RECEIVED:
            line = ends[packet.source]
            line.append(((line[-1][0] if line else 0) + len(packet.data), packet.time))
    asked, listed = {}, {}
    for item in decode(items):
        if not isinstance(item, SeenFrame) or item.echo:
            continue
        body = item.frame.body
        if item.direction is Direction.SENT:
            if body[:1] == b"\x64":
                asked[item.source], listed[item.source] = body, None
            continue
        if item.request == asked.get(item.source, b"") and body == b"\x00":
            listed[item.source] = item.request[1:]
        start = item.frame.offset
        end, time = next(it for it in ends[item.source] if it[0] > start)
        began = time - (end - start) * (10 / (item.source.baud or 9600))
        yield item.source, began, body, item.request, listed.get(item.source)


def rows(items, catalog, reading="corrected"):
    """(source, time, values by name); a parameter that could not be read is NaN.

    So is a lone 01 to a 61 of one code, until that was answered otherwise (D10).
    """
    known = set()
    for source, time, body, request, listed in answers(items):
        command = _command(request, listed, catalog)
        if command is None:
            continue
        parameters = [catalog.by_code(d.code) for d in command.parameters]
        alone = request[:1] == b"\x61" and len(request) == 2 and command.parameters[0].size == 1
        if alone and len(body) == 1 and body != b"\x01":
            known.add((source, request))
        try:
            if alone and body == b"\x01" and (source, request) not in known:
                raise MikasError
            data = command.read(body)
            values = {
                p.name: float(p.decode(raw, reading))
                for named, raw in zip(parameters, data, strict=True)
                for p in named
            }
        except MikasError:
            values = {p.name: nan for named in parameters for p in named}
        yield source, time, values


def _command(request, listed, catalog):
    if request == b"\x63":
        request = b"\x61" + listed if listed else None
    if request is None:
        return None
    try:
        command = c.parse(request, catalog.size_of)
    except c.MalformedRequest:
        return None
    data = (c.ReadParameters, c.StreamCyclic, c.StreamAtStroke)
    return command if isinstance(command, data) else None
