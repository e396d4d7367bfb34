"""Formulas of a recording's instruments: searched moments, and columns computed from both."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from instrument_recording import record
from mikas.catalog import Catalog, load, shipped
from mikas.errors import CatalogError, UnknownParameter, UsageError
from mikas.instruments import definition_of_text
from mikas.recording.recording import Recording
from mikas.recording.search import SearchCondition, search, search_rows
from mikas.recording.table.channels import Rows

OWN = definition_of_text(
    "own",
    'text = "Manometer"\ndecoder = "line"\npatterns = ["{PRESSURE} kPa"]\n'
    '[instrument.PRESSURE]\ntext = "Pressure"\nunit = "kPa"\n',
)
DERIVED = """
[derived.LEANER]
text = "Leaner than asked"
formula = "LAMBDA - TWAT / 1000"
decimals = 3
[derived.TWICE]
text = "Twice"
formula = "LEANER * 2"
[derived.WAY]
text = "Way"
formula = "GPS_SPEED / 3600"
accumulates = true
unit = "km"
"""
LAMBDAS = {at: b"1.250\r\n" if 10 <= at < 20 else b"0.950\r\n" for at in range(1, 40)}


@pytest.fixture
def catalog(tmp_path: Path) -> Catalog:
    (tmp_path / "mine.toml").write_text(DERIVED, encoding="utf-8")
    return load(tmp_path / "mine.toml")


@pytest.fixture(scope="module")
def three(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The unit, a λ meter, and an own instrument that is plugged in at the twentieth sample."""
    said = [(0, [(0, b"\r\n", 0.0, ""), (1, b"\n", 0.0, "")])]
    for at, line in LAMBDAS.items():
        both = [(0, line, 0.0, "")]
        if at >= 20:
            both.append((1, f"{100 + at} kPa\n".encode(), 0.0, ""))
        said.append((at, both))
    path = tmp_path_factory.mktemp("three") / "a.pcapng"
    return record(path, said, (("aem", ""), (OWN, "")))


def hits(path: Path, expression: str, catalog: Catalog | None = None) -> list[tuple[float, int]]:
    recording = Recording(path, catalog or shipped())
    condition = SearchCondition(recording.formula_catalog, expression)
    return [(round(hit.peak or 0, 3), hit.rows) for hit in search(recording, condition).hits]


def test_moments_of_an_instrument_of_an_own_one_and_of_both_with_the_unit(three: Path) -> None:
    assert hits(three, "LAMBDA > 1.1 and FREQ > 1") == [(1.25, 10)]
    assert hits(three, "LAMBDA > 1.1") == [(1.25, 10)]
    assert hits(three, "PRESSURE > 125 and LAMBDA < 1") == [(139.0, 14)]
    assert hits(three, "FREQ > 1 and LAMBDA > 1.3") == []
    assert hits(three, "AFR > 14.7 * 1.2") == [(18.375, 10)]


def test_a_condition_on_what_is_not_there_says_so(three: Path) -> None:
    with pytest.raises(UsageError, match=r"^GPS_SPEED: not in this recording"):
        hits(three, "GPS_SPEED > 10 and LAMBDA > 1")
    with pytest.raises(UnknownParameter, match="PRESSURE"):
        hits(three, "PRESURE > 10")
    alone = record(three.with_name("alone.pcapng"), definitions=())
    with pytest.raises(UsageError, match=r"^LAMBDA: not in this recording"):
        hits(alone, "LAMBDA > 1.1")


def test_a_value_that_is_too_old_makes_the_condition_unknown(tmp_path: Path) -> None:
    said = [(0, [(0, b"\r\n", 0.0, "")]), (10, [(0, b"1.3\r\n", 0.0, "")])]
    recording = Recording(record(tmp_path / "a.pcapng", said, count=120), shipped())
    (hit,) = search(recording, SearchCondition(recording.formula_catalog, "LAMBDA > 1")).hits
    assert 0.5 < hit.end - hit.begin <= 1.0  # the definition's `stale`
    assert hits(recording.path, "LAMBDA < 1") == []


def test_a_derived_column_has_instruments_among_its_inputs(three: Path, catalog: Catalog) -> None:
    recording = Recording(three, catalog, names=["LEANER", "TWICE", "LAMBDA", "TWAT"])
    (rows,) = recording.rows()
    lean, both = rows.values["LEANER"], np.isfinite(rows.values["LAMBDA"])
    assert both.sum() > 30
    expected = rows.values["LAMBDA"] - rows.values["TWAT"] / 1000
    assert lean[both] == pytest.approx(expected[both])
    assert np.isnan(lean[~both]).all()
    assert rows.values["TWICE"][both] == pytest.approx(2 * expected[both])
    assert hits(three, "TWICE > 2", catalog) == [(pytest.approx(2.34, abs=0.1), 10)]
    every = [channel.name for channel in Recording(three, catalog).channels]
    assert "LEANER" in every
    assert "WAY" not in every  # no receiver is in the file
    assert Recording(three, catalog, names=["WAY"]).absent == ("WAY",)


def test_live_rows_are_searched_as_a_recordings(three: Path) -> None:
    recording = Recording(three, shipped(), names=["FREQ", "LAMBDA"])
    (rows,) = recording.rows()
    condition = SearchCondition(recording.formula_catalog, "LAMBDA > 1.1 and FREQ > 1")
    assert (condition.requires, condition.beside) == (("FREQ",), ("LAMBDA",))
    assert search_rows(rows, condition).hits == search(recording, condition).hits
    without = Rows(rows.times, {"FREQ": rows.values["FREQ"]})
    assert search_rows(without, condition).hits == []


def test_a_formula_with_an_unknown_channel_is_refused_with_the_nearest(tmp_path: Path) -> None:
    wrong = tmp_path / "wrong.toml"
    wrong.write_text('[derived.X]\ntext = "x"\nformula = "LAMBDDA - VALF"\n', encoding="utf-8")
    with pytest.raises(CatalogError, match=r"wrong.toml:3.*LAMBDDA.*the nearest is LAMBDA"):
        load(wrong)
