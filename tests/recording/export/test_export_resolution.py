"""A number in a file leads back to the raw datum, for every parameter and every raw value (§4)."""

from __future__ import annotations

import csv

import numpy as np
import pytest
from test_export_mlg import read as read_mlg
from test_export_msl import read as read_msl

from mikas.catalog import shipped
from mikas.recording.export import EXCEL, PLAIN, export
from mikas.recording.table.channels import Channel, Rows


def numbers_of(path, dialect):
    """The columns after the time, as numbers."""
    if path.suffix == ".mlg":
        rows = read_mlg(path.read_bytes()).values
    elif path.suffix == ".msl":
        rows = read_msl(path)[4]
    else:
        lines = path.read_text(encoding="utf-8-sig").splitlines()
        rows = list(csv.reader(lines, delimiter=dialect.separator))[1:]
    if dialect.decimal != ".":
        rows = [[cell.replace(dialect.decimal, ".") for cell in row] for row in rows]
    return np.array(rows, float).T[1:]


@pytest.mark.parametrize(
    ("name", "dialect"),
    [("a.csv", PLAIN), ("a.csv", EXCEL), ("a.msl", PLAIN), ("a.mlg", PLAIN)],
    ids=["csv", "excel", "msl", "mlg"],
)
@pytest.mark.parametrize(
    ("interpretation", "size"),
    [("corrected", 1), ("corrected", 2), ("literal", 1), ("alternative", 1)],  # errata: one byte
)
def test_every_raw_value_is_read_back(tmp_path, name, dialect, interpretation, size):
    raw = [number.to_bytes(size, "little") for number in range(256**size)]
    chosen = {each.name: each for each in shipped().parameters if each.size == size}
    values = {
        name: np.array(list(map(each.interpretation(interpretation).decode, raw)), float)
        for name, each in chosen.items()
    }
    channels = [Channel(name, p.unit, p.text, p.is_flag, 0) for name, p in chosen.items()]
    rows = Rows(np.arange(len(raw)) / 32, values)
    result = export(tmp_path / name, channels, [rows], dialect=dialect, overwrite=True)
    for parameter, column in zip(chosen.values(), numbers_of(result.out, dialect), strict=True):
        conversion = parameter.interpretation(interpretation)
        if conversion.is_flag or result.out.suffix != ".mlg":  # no rounding at all
            assert column.tolist() == values[parameter.name].tolist()
        else:
            assert [conversion.encode(value, "") for value in column.tolist()] == raw
