"""What the bulk decoder has to come to: the same by `decode`, the commands and the catalog."""

from __future__ import annotations

from collections import Counter, defaultdict
from math import nan

from mikas import commands as c
from mikas.errors import MikasError
from mikas.link.base import Direction
from mikas.recording.capture.reader import Packet
from mikas.recording.exchanges.scalar import DecodedFrame
from mikas.recording.inspect import decode


def answers(items):
    """(source, time, body, request, list, start) of every sound received frame that is no echo.

    `list`: the codes of the last 64, if `00` has answered it and no other was sent since. `start`:
    how often the request had been sent.
    """
    items = list(items)
    ends = defaultdict(list)  # of received packets: where in their stream, and when
    for packet in items:
        if isinstance(packet, Packet) and packet.direction is Direction.RECEIVED:
            line = ends[packet.source]
            start = line[-1][1] if line else 0
            line.append((start, start + len(packet.data), packet.time))
    asked, listed, sent = {}, {}, Counter()
    for item in decode(items):
        if not isinstance(item, DecodedFrame) or item.echo:
            continue
        body = item.frame.body
        if item.direction is Direction.SENT:
            sent[item.source, body] += 1
            if body[:1] == b"\x64":
                asked[item.source], listed[item.source] = body, None
            continue
        if item.request == asked.get(item.source, b"") and body == b"\x00":
            listed[item.source] = item.request[1:]
        start = item.frame.offset
        stop, byte_time = start + len(item.frame.wire), 10 / (item.source.baud or 9600)
        brought = [it for it in ends[item.source] if it[1] > start and it[0] < stop]
        began = min(time - (end - start) * byte_time for _, end, time in brought)
        times = sent[item.source, item.request]
        codes = listed.get(item.source) if item.knows_list else None
        yield item.source, began, body, item.request, codes, times


def rows(items, catalog, interpretation="corrected"):
    """(source, time, values by name); a parameter that could not be read is NaN.

    So is a 01 that may be a refusal (D10), see `_refused`.
    """
    items = list(items)
    reported = list(answers(items))
    commands = [_command(request, listed, catalog) for _, _, _, request, listed, _ in reported]
    refused = _refused(reported, commands, _sent(items))
    for number, (source, time, body, *_) in enumerate(reported):
        command = commands[number]
        if command is None:
            continue
        parameters = [catalog.by_code(d.code) for d in command.parameters]
        try:
            if number in refused:
                raise MikasError
            data = command.read(body)
            values = {
                p.name: float(p.decode(raw, interpretation))
                for named, raw in zip(parameters, data, strict=True)
                for p in named
            }
        except MikasError:
            values = {p.name: nan for named in parameters for p in named}
        yield source, time, values


def _sent(items):
    frames = (item for item in decode(items) if isinstance(item, DecodedFrame))
    return {(it.source, it.frame.body) for it in frames if it.direction is Direction.SENT}


def _refused(reported, commands, sent):
    """The numbers of the answers 01 that do not count as a datum."""
    refused, doubted = set(), {}  # `doubted`: streams that began with 01, until they go on
    for number, (source, _, body, request, _, start) in enumerate(reported):
        command = commands[number]
        if not isinstance(command, STREAMS) or len(request) != 2 or command.parameters[0].size != 1:
            continue
        stream = source, request, start
        if stream not in doubted:
            doubted[stream] = number if body == b"\x01" else None
            if body == b"\x01":
                refused.add(number)
        elif len(body) == 1:
            refused.discard(doubted[stream])
    firsts = {number for number in doubted.values() if number is not None}
    for source in {source for source, *_ in reported}:
        mine = [number for number, it in enumerate(reported) if it[0] == source]
        for code in {reported[n][3][1] for n in mine if _alone(reported[n][3], commands[n])}:
            refused |= _lone_refused(code, mine, reported, commands, firsts, sent)
    return refused


def _lone_refused(code, mine, reported, commands, firsts, sent):
    """Those to `61 code`: each waits for what settles it."""
    alone, twice = bytes([0x61, code]), bytes([0x61, code, code])
    refused, waiting, sure, wary = set(), [], False, False
    for number in mine:
        _, _, body, request, _, _ = reported[number]
        if commands[number] is None or number in firsts:
            continue
        if request == twice and body == b"\x01":
            refused.update(waiting)
            waiting, sure, wary = [], False, True
        elif request == alone and body == b"\x01":
            waiting.append(number)
        elif (datum := _datum(code, commands[number], body)) is not None:
            sure = datum == b"\x01"
            if wary and not sure:
                refused.update(waiting)
            waiting, wary = [], wary and not sure
    asked_twice = (reported[mine[0]][0], twice) in sent
    if not sure and (wary or len(waiting) < 2 or not asked_twice):
        refused.update(waiting)
    return refused


def _alone(request, command):
    return isinstance(command, c.ReadParameters) and (
        len(request) == 2 and request[0] == 0x61 and command.parameters[0].size == 1
    )


def _datum(code, command, body):
    """The code's last one in the body; None: there is none."""
    if len(body) != sum(datum.size for datum in command.parameters):
        return None
    found, start = None, 0
    for datum in command.parameters:
        if datum.code == code:
            found = body[start : start + datum.size]
        start += datum.size
    return found


STREAMS = (c.StreamCyclic, c.StreamAtStroke)


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
