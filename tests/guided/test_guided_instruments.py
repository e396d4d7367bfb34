"""Tests of one's own that name an instrument's channel: loaded, measured, and said what is away."""

from __future__ import annotations

import pytest

from mikas.catalog import shipped
from mikas.catalog.loading.source import parse_source
from mikas.errors import CatalogError
from mikas.guided.definition import GuidedTest
from mikas.guided.engine import TestEngine
from mikas.guided.loading import from_source, load
from mikas.instruments.choosing import chosen_instruments
from mixture_by_meter import MIXTURE

CATALOG = shipped()
LEFT = CATALOG.with_beside(chosen_instruments(["left:aem=sim:"], CATALOG)[0].channels)


def mixture(text: str = MIXTURE, catalog=CATALOG) -> GuidedTest:
    return from_source(parse_source("mixture.toml", text.encode()), catalog, own=True)


def done(test: GuidedTest, catalog=CATALOG, **beside: float) -> TestEngine:
    engine = TestEngine(test, catalog)
    for at in range(20):
        engine.add_row(0.25 * at, {"FREQ": 850.0, **beside})
    return engine


def test_it_is_measured_with_its_unit_and_decides() -> None:
    test = mixture()
    assert ("FREQ" in test.channels, test.beside) == (True, ("LAMBDA",))
    assert "LAMBDA" not in test.channels
    result = done(test, LAMBDA=1.2).result
    assert result is not None
    (number,) = result.numbers
    assert (number.value, number.decimals) == (pytest.approx(1.2), 3)
    assert [each.rule for each in result.findings] == ["lean"]
    assert "1.200" in result.findings[0].text.en
    assert [curve.name for curve in result.curves] == ["LAMBDA", "FREQ"]


def test_what_is_away_is_said_and_nothing_is_decided() -> None:
    engine = done(mixture())
    progress = engine.progress()
    assert engine.result is None
    assert progress.lacking == ("LAMBDA",)
    assert any(each.name == "LAMBDA" and each.value is None for each in progress.unmet)


def test_a_labelled_meter_is_named_where_there_is_one() -> None:
    text = MIXTURE.replace("LAMBDA", "LAMBDA_LEFT")
    test = mixture(text, LEFT)
    assert test.beside == ("LAMBDA_LEFT",)
    assert done(test, LEFT, LAMBDA_LEFT=1.2).result is not None
    with pytest.raises(CatalogError, match="LAMBDA_LEFT, which does not exist"):
        mixture(text)


def test_the_users_folder_may_name_what_the_session_has(tmp_path) -> None:
    (tmp_path / "mixture.toml").write_text(MIXTURE.replace("LAMBDA", "LAMBDA_LEFT"), "utf-8")
    assert "mixture" in load(CATALOG, tmp_path, LEFT).tests
    without = load(CATALOG, tmp_path)
    assert "mixture" not in without.tests
    assert "LAMBDA_LEFT" in without.errors[0].text.en
