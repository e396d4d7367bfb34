"""A table that another program has changed: noticed, and made again from its recording."""

from __future__ import annotations

import json
from pathlib import Path

import duckdb
import pytest

from fleet_rig import SETTINGS, HereRunner, add_here, ask, counts, make
from mikas.fleet.adding import Added, add, plan
from mikas.fleet.ledger import FOLDER

HOTTEST = "SELECT max(TWAT) FROM samples"


@pytest.fixture
def dataset(tmp_path) -> Path:
    make(tmp_path / "in" / "drive.pcapng")
    add_here(tmp_path / "in", to=tmp_path / "set")
    return tmp_path / "set"


def checked(folder: Path, dataset: Path) -> Added:
    planned = plan([str(folder)], str(dataset), SETTINGS, check=True)
    return add(planned, str(dataset), SETTINGS, HereRunner())


def table_of(dataset: Path) -> Path:
    (table,) = dataset.rglob("samples/*/*/*.parquet")
    return table


def heat(table: Path) -> None:
    """Write other values into a table."""
    rows = f"read_parquet('{table}', hive_partitioning = false)"
    hot = f"SELECT * REPLACE (TWAT + 40 AS TWAT) FROM {rows}"
    duckdb.sql(f"COPY ({hot}) TO '{table}' (FORMAT parquet)")


def test_values_that_another_program_has_replaced_do_not_stay(dataset, tmp_path) -> None:
    before, table = ask(dataset, HOTTEST), table_of(dataset)
    written = table.read_bytes()
    heat(table)
    assert len(table.read_bytes()) != len(written)
    assert ask(dataset, "SELECT count(*) FROM samples") == [(0,)]  # no value is invented
    result = add_here(tmp_path / "in", to=dataset)
    assert counts(result) == (1, 0, 0, 0)
    assert result.remade == [str(tmp_path / "in" / "drive.pcapng")]
    assert table.read_bytes() == written
    assert ask(dataset, HOTTEST) == before
    assert counts(add_here(tmp_path / "in", to=dataset)) == (0, 0, 1, 0)


def test_a_change_that_keeps_the_size_is_found_by_a_check(dataset, tmp_path) -> None:
    table = table_of(dataset)
    written = table.read_bytes()
    table.write_bytes(written[:100] + bytes([written[100] ^ 1]) + written[101:])
    assert counts(add_here(tmp_path / "in", to=dataset)) == (0, 0, 1, 0)
    assert counts(checked(tmp_path / "in", dataset)) == (1, 0, 0, 0)
    assert table.read_bytes() == written
    assert counts(checked(tmp_path / "in", dataset)) == (0, 0, 1, 0)


def test_a_changed_table_whose_recording_is_gone_is_named_and_does_not_count(
    dataset, tmp_path
) -> None:
    heat(table_of(dataset))
    (tmp_path / "in" / "drive.pcapng").rename(tmp_path / "elsewhere.pcapng")
    (bad,) = add_here(tmp_path / "in", to=dataset).bad
    assert "no longer in the dataset as they were written" in bad.reason.en
    assert ask(dataset, "SELECT count(*) FROM drives") == [(0,)]
    assert counts(add_here(tmp_path / "elsewhere.pcapng", to=dataset)) == (1, 0, 0, 0)
    assert ask(dataset, "SELECT count(*) FROM drives") == [(1,)]


def test_an_entry_of_an_earlier_version_counts_and_is_not_checked(dataset, tmp_path) -> None:
    (entry,) = (dataset / FOLDER).iterdir()
    value = json.loads(entry.read_text())
    assert set(value.pop("tables")) == set(value["files"])
    entry.write_text(json.dumps(value))
    assert counts(checked(tmp_path / "in", dataset)) == (0, 0, 1, 0)
    assert ask(dataset, "SELECT count(*) FROM drives") == [(1,)]
