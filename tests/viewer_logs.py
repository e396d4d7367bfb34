"""Readers of MegaLogViewer's logs, written from the formats' descriptions alone."""

from __future__ import annotations

import struct
from typing import NamedTuple


class MlgLog(NamedTuple):
    timestamp: int
    names: list[str]
    units: list[str]
    digits: list[int]
    info: str
    clocks: list[int]
    values: list[tuple[float, ...]]
    marks: list[tuple[int, int, str]]
    """(how many rows stand before it, clock, words)"""


def read_mlg(data):
    """The whole of an .mlg, version 1; anything that does not fit is an error."""
    assert data[:6] == b"MLVLG\0"
    assert int.from_bytes(data[6:8]) == 1
    timestamp, info_at, data_at, record, count = struct.unpack(">IHIHH", data[8:22])
    names, units, digits, kinds = [], [], [], []
    at = 22
    for _ in range(count):
        kind, name, unit, style, scale, transform, decimals = struct.unpack_from(
            ">b34s10sbffb", data, at
        )
        assert style == 0
        assert transform == 0
        assert b"\0" in name
        assert b"\0" in unit
        names.append(name.partition(b"\0")[0].decode())
        units.append(unit.partition(b"\0")[0].decode())
        digits.append(decimals)
        kinds.append(({5: "i", 7: "f"}[kind], scale))
        at += 55
    assert at == info_at
    info = data[info_at:data_at]
    assert info.index(b"\0") == len(info) - 1
    code = ">" + "".join(kind for kind, _ in kinds)
    assert struct.calcsize(code) == record
    clocks, values, marks = [], [], []
    at = data_at
    while at < len(data):
        block, number, clock = struct.unpack_from(">BBH", data, at)
        assert number == (len(values) + len(marks)) % 256
        if block == 1:
            words = data[at + 4 : at + 54]
            assert words[-1] == 0
            marks.append((len(values), clock, words.rstrip(b"\0").decode()))
            at += 54
            continue
        raw = data[at + 4 : at + 4 + record]
        assert block == 0
        assert data[at + 4 + record] == sum(raw) % 256
        clocks.append(clock)
        values.append(
            tuple(
                value * scale
                for value, (_, scale) in zip(struct.unpack(code, raw), kinds, strict=True)
            )
        )
        at += 5 + record
    assert at == len(data)
    return MlgLog(timestamp, names, units, digits, info[:-1].decode(), clocks, values, marks)


def read_msl(path):
    """Two lines in quotation marks, names, units, data: what such readers rely on."""
    first, second, names, units, *data = path.read_bytes().decode().removesuffix("\n").split("\n")
    for line in (first, second):
        assert line[0] == line[-1] == '"'
        assert line.count('"') == 2
    table = [names.split("\t"), units.split("\t"), *(line.split("\t") for line in data)]
    assert {len(row) for row in table} == {len(table[0])}
    return first[1:-1], second[1:-1], table[0], table[1], table[2:]
