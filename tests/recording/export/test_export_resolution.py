"""A number in a file leads back to the raw datum, for every parameter and every raw value (§4)."""

from __future__ import annotations

import numpy as np
import pytest

from csv_columns import columns_of
from mikas.catalog import shipped
from mikas.recording.export import EXCEL, PLAIN, export
from mikas.recording.table.channels import Channel, Rows
from viewer_logs import read_mlg, read_msl


def numbers_of(path, dialect, names):
    """The columns of these channels, as numbers."""
    if path.suffix == ".csv":
        columns = columns_of(path.read_text(encoding="utf-8-sig"), dialect.separator)
        cells = [[cell.replace(dialect.decimal, ".") for cell in columns[it]] for it in names]
        return np.array(cells, float)
    rows = read_mlg(path.read_bytes()).values if path.suffix == ".mlg" else read_msl(path)[4]
    return np.array(rows, float).T[1:]


@pytest.mark.parametrize(
    ("name", "dialect"),
    [("a.csv", PLAIN), ("a.csv", EXCEL), ("a.msl", PLAIN), ("a.mlg", PLAIN)],
    ids=["csv", "excel", "msl", "mlg"],
)
@pytest.mark.parametrize(
    ("interpretation", "size"),
    [
        ("corrected", 1),
        ("corrected", 2),
        ("literal", 1),
        ("alternative", 1),
        ("family", 1),
    ],  # errata: one byte
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
    for parameter, column in zip(
        chosen.values(), numbers_of(result.out, dialect, chosen), strict=True
    ):
        conversion = parameter.interpretation(interpretation)
        if conversion.is_flag or result.out.suffix != ".mlg":  # no rounding at all
            assert column.tolist() == values[parameter.name].tolist()
        else:
            assert [conversion.encode(value, "") for value in column.tolist()] == raw
