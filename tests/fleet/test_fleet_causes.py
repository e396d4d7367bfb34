"""The causes of drives in a dataset: collected by pieces, in the table, in the report's words."""

from __future__ import annotations

import json
from datetime import datetime, timedelta
from pathlib import Path

import duckdb
import numpy as np
import pytest

import mikas.fleet.causes as module
from fleet_rig import SETTINGS, add_here, ask, counts, make_dataset
from mikas.catalog import shipped
from mikas.causes.result import CauseVerdict, Likelihood
from mikas.fleet.causes import CauseCollector
from mikas.fleet.ledger import FOLDER
from mikas.fleet.query.database import opened
from mikas.fleet.report.causes import JudgedDrive, car_words, latest
from mikas.fleet.report.figures import figures
from mikas.fleet.report.findings import find
from mikas.fleet.report.page import render
from mikas.fleet.tables import LATER
from mikas.i18n import Text
from mikas.recording.table.channels import Rows

NOW = datetime(2026, 6, 1)
BEGAN = datetime(2026, 3, 2)
LEAK = Text("Air leak", "Подсос воздуха")
COLUMNS = "verdict, cause, likelihood, cause_en, cause_ru"


@pytest.fixture
def dataset(tmp_path) -> Path:
    worn = {"condition": {"air_meter": 0.72}, "seconds": 40.0, "rate": 2.0, "warm": True}
    return make_dataset(tmp_path, {"drive.pcapng": worn})


def page(dataset: Path, language: str = "en") -> str:
    with opened(str(dataset)) as database:
        return render(find(figures(database, shipped(), NOW), shipped()), language)


def make_earlier(dataset: Path) -> None:
    """Take from a dataset what an earlier version did not write."""
    (table,) = dataset.rglob("drives/*/*/*.parquet")
    rows = f"read_parquet('{table}', hive_partitioning = false)"
    without = ", ".join(sorted(LATER["drives"]))
    duckdb.sql(f"COPY (SELECT * EXCLUDE ({without}) FROM {rows}) TO '{table}' (FORMAT parquet)")
    (entry,) = (dataset / FOLDER).iterdir()
    value = json.loads(entry.read_text("utf-8"))
    del value["tables"]
    value["version"] = "mikas of before"
    entry.write_text(json.dumps(value), "utf-8")


def test_a_drive_has_its_likeliest_cause_in_the_table_and_on_the_page(dataset) -> None:
    ((verdict, cause, likelihood, en, ru),) = ask(dataset, f"SELECT {COLUMNS} FROM drives")
    assert (verdict, cause, likelihood) == ("causes", "air_meter", "probable")
    assert en == "Air meter shows too little"
    assert f"probably: {en}" in page(dataset)
    assert f"вероятно: {ru}" in page(dataset, "ru")
    assert "not from cars" in page(dataset)


def test_a_dataset_of_an_earlier_version_counts_and_its_causes_are_named_as_missing(
    dataset, tmp_path
) -> None:
    make_earlier(dataset)
    assert ask(dataset, f"SELECT seconds > 30, {COLUMNS} FROM drives") == [(True, *[None] * 5)]
    assert "The causes in 1 drive: an earlier version of mikas added them" in page(dataset)
    assert counts(add_here(tmp_path / "in", to=dataset)) == (1, 1, 0, 0)
    assert ask(dataset, "SELECT cause FROM drives") == [("air_meter",)]
    assert "an earlier version" not in page(dataset)


def test_an_earlier_and_a_present_recording_are_read_together(tmp_path) -> None:
    home = make_dataset(tmp_path, {"drive.pcapng": {}})
    make_earlier(home)
    (tmp_path / "in" / "drive.pcapng").unlink()
    other = make_dataset(tmp_path / "b", {"drive.pcapng": {"seed": 2, "seconds": 50.0}})
    add_here(tmp_path / "b" / "in", to=home)
    assert other.is_dir()
    asked = "SELECT verdict FROM drives ORDER BY verdict NULLS FIRST"
    assert ask(home, asked) == [(None,), ("cannot-tell",)]


def test_a_column_of_causes_of_another_type_costs_its_own_recording_only(dataset) -> None:
    (table,) = dataset.rglob("drives/*/*/*.parquet")
    rows = f"read_parquet('{table}', hive_partitioning = false)"
    wrong = f"SELECT * REPLACE (1 AS verdict) FROM {rows}"
    duckdb.sql(f"COPY ({wrong}) TO '{table}' (FORMAT parquet)")
    (entry,) = (dataset / FOLDER).iterdir()
    value = json.loads(entry.read_text("utf-8"))
    del value["tables"]
    entry.write_text(json.dumps(value), "utf-8")
    with opened(str(dataset)) as database:
        assert len(database.ledger.refused) == 1


def drive(day: int, verdict: CauseVerdict, text: Text | None = None) -> JudgedDrive:
    likely = Likelihood.ALMOST_CERTAIN if text else None
    return JudgedDrive(BEGAN + timedelta(days=day), 600.0, verdict, likely, text)


def test_a_car_has_the_words_of_its_latest_drive_that_decides() -> None:
    found, undecided = drive(1, CauseVerdict.CAUSES, LEAK), drive(2, CauseVerdict.CANNOT_TELL)
    assert latest([found, undecided]) is found
    assert car_words([found, undecided]) == Text(
        "almost certainly: Air leak (1 of 2 drives)",
        "почти наверняка: Подсос воздуха (поездок: 1 из 2)",
    )
    assert car_words([undecided]) == Text("can't tell", "сказать нельзя")
    assert car_words([drive(1, CauseVerdict.SOUND)]) == Text("sound", "исправна")
    assert car_words([drive(1, CauseVerdict.UNKNOWN, LEAK)]) == Text("unknown", "неизвестна")
    assert car_words([]) is None
    many = [found, *(drive(2 + n, CauseVerdict.CANNOT_TELL) for n in range(5))]
    assert latest(many) is many[-1]  # a cause of long ago is not the car's


def rows(first: float, seconds: float, rate: float = 5.0) -> Rows:
    times = first + np.arange(int(seconds * rate)) / rate
    flat = np.ones(len(times))
    names = {"FREQ": 850.0, "UACC": 14.0, "JAIR": 14.0, "INJ": 4.5, "OTHER": 1.0}
    return Rows(times, {name: value * flat for name, value in names.items()})


def test_a_long_drive_is_never_kept_whole(monkeypatch) -> None:
    pieces: list[float] = []
    whole = module.samples_of_rows

    def counted(stretches):
        samples = whole(stretches)
        pieces.extend(each.seconds for each in samples)
        return samples

    monkeypatch.setattr(module, "samples_of_rows", counted)
    collector = CauseCollector()
    for number in range(50):  # of ten minutes each
        collector.add(rows(600.0 * number, 600.0, rate=1.0))
    assert collector.columns(())["verdict"] == "cannot-tell"
    assert max(pieces) <= module.PIECE
    assert sum(pieces) > 29_000


def test_a_drive_without_a_row_can_t_be_judged() -> None:
    assert CauseCollector().columns((13,)) == {
        "verdict": "cannot-tell", "cause": None, "likelihood": None, "cause_en": None,
        "cause_ru": None,
    }  # fmt: skip


def test_the_version_names_the_edition_of_the_tables() -> None:
    assert ", tables 3, " in SETTINGS.version
