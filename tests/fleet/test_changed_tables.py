"""A table that another program has changed: noticed, and made again from its recording."""

from __future__ import annotations

import json
from pathlib import Path

import duckdb
import pytest

from fleet_rig import SETTINGS, HereRunner, add_here, ask, counts, make, make_dataset
from mikas.fleet.adding import Added, add, plan
from mikas.fleet.ledger import FOLDER

HOTTEST = "SELECT max(TWAT) FROM samples"


@pytest.fixture
def dataset(tmp_path) -> Path:
    return make_dataset(tmp_path, {"drive.pcapng": {}})


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


@pytest.mark.posix
@pytest.mark.parametrize("state", ["link", "folder away", "disk away", "file as folder"])
def test_a_recording_whose_tables_are_away_is_named_and_counts_when_they_are_back(
    dataset, tmp_path, state
) -> None:
    """Its entry was deleted, so it never counted again though its tables came back."""
    before, samples, aside = ask(dataset, HOTTEST), dataset / "samples", tmp_path / "aside"
    (tmp_path / "in" / "drive.pcapng").rename(tmp_path / "elsewhere.pcapng")
    samples.rename(aside)
    match state:
        case "link":
            samples.symlink_to(aside)
        case "disk away":
            samples.mkdir()
        case "file as folder":
            samples.write_bytes(b"")
    for _ in range(2):
        (bad,) = add_here(tmp_path / "in", to=dataset).bad
        assert FOLDER in bad.file
        assert "drive.pcapng" in bad.reason.en
        assert "does not count until" in bad.reason.en
        assert ask(dataset, "SELECT count(*) FROM drives") == [(0,)]
    samples.rmdir() if samples.is_dir() and not samples.is_symlink() else samples.unlink(True)
    aside.rename(samples)
    assert counts(add_here(tmp_path / "in", to=dataset)) == (0, 0, 0, 0)
    assert ask(dataset, HOTTEST) == before


@pytest.mark.posix
def test_tables_that_are_away_are_made_again_where_the_recording_is(dataset, tmp_path) -> None:
    (entry,) = (dataset / FOLDER).iterdir()
    written, before = entry.read_bytes(), ask(dataset, HOTTEST)
    (dataset / "samples").rename(tmp_path / "aside")
    (dataset / "samples").symlink_to(tmp_path / "aside")
    assert counts(add_here(tmp_path / "in", to=dataset)) == (0, 0, 0, 2)  # not through a link
    assert entry.read_bytes() == written
    (dataset / "samples").unlink()
    result = add_here(tmp_path / "in", to=dataset)
    assert counts(result) == (1, 0, 0, 0)
    assert result.remade == [str(tmp_path / "in" / "drive.pcapng")]
    assert ask(dataset, HOTTEST) == before


@pytest.mark.posix
def test_a_recording_that_grew_while_its_tables_were_away_counts_once(dataset, tmp_path) -> None:
    drive, aside = tmp_path / "in" / "drive.pcapng", tmp_path / "aside"
    (dataset / "samples").rename(aside)
    make(drive, seconds=90.0)
    assert counts(add_here(tmp_path / "in", to=dataset))[0] == 1
    for table in aside.rglob("*.parquet"):
        table.rename(dataset / "samples" / table.relative_to(aside))
    assert ask(dataset, "SELECT count(*) FROM drives") == [(1,)]


def test_two_copies_read_at_the_same_time_leave_the_tables_of_one(tmp_path) -> None:
    """The tables of the second replaced those of the first, which then did not count."""

    class AtOnce(HereRunner):
        def outcomes(self, work, files):
            yield from [work(file) for file in files]  # before the first of them counts

    for name in ("drive.pcapng", "copy.pcapng"):
        make(tmp_path / "in" / name)
    dataset = str(tmp_path / "set")
    result = add(plan([str(tmp_path / "in")], dataset, SETTINGS), dataset, SETTINGS, AtOnce())
    assert counts(result) == (1, 0, 1, 0)
    assert ask(tmp_path / "set", "SELECT count(*) FROM drives") == [(1,)]
    assert len(list((tmp_path / "set").rglob("samples/*/*/*.parquet"))) == 1
