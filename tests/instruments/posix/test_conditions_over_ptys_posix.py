"""An action, a derived channel and a search that name a λ meter on a real pty, beside the unit."""

from __future__ import annotations

from pathlib import Path

import pytest

import mikas
from instruments.posix.test_instruments_posix import ptys, until
from mikas.catalog import load
from mikas.conditions import ConditionWatch, Fired, read_actions
from mikas.recording.search import SearchCondition, search

pytestmark = [pytest.mark.realtime, pytest.mark.posix]
DERIVED = '[derived.LEANER]\ntext = "Leaner"\nformula = "LAMBDA - FREQ / 10000"\ndecimals = 3\n'
LEAN = '[action.lean]\nwhen = "LAMBDA > 1.1 and FREQ > 100"\nsound = true\n'


def test_a_rule_acts_on_the_meter_and_not_on_what_it_said_before_it_was_pulled_out(
    tmp_path: Path,
) -> None:
    path, mine = tmp_path / "a.pcapng", tmp_path / "mine.toml"
    mine.write_text(DERIVED, encoding="utf-8")
    catalog = load(mine)
    (rule,) = read_actions("actions.toml", LEAN, catalog).rules
    watch, fired = ConditionWatch([rule], catalog), list[Fired]()
    with ptys(2) as (meter, receiver):
        instruments = [f"aem={meter.path}", f"nmea={receiver.path}"]
        session = mikas.session(
            "sim:?seed=1", ["FREQ", "LEANER"], record=path, instruments=instruments, rate=50,
            catalogs=mine,
        )  # fmt: skip
        with session:
            begun = next(session)
            until(session, lambda it: it.time > begun.time + 0.3)  # both are open
            meter.write(b"\r\n1.000\r\n")
            rich = until(session, lambda it: "LAMBDA" in it.values)
            assert watch.follow(rich) == ()
            assert rich.values["LEANER"] == pytest.approx(1 - rich.values["FREQ"] / 10000)
            meter.write(b"1.250\r\n")
            lean = until(session, lambda it: it.values.get("LAMBDA") == 1.25)
            fired += watch.follow(lean)
            assert [it.values["LAMBDA"] for it in fired] == [1.25]
            meter.close()
            gone = until(session, lambda it: "LAMBDA" not in it.values)
            assert "LEANER" not in gone.values
            assert watch.follow(gone) == ()
            assert watch.values(rule).keys() == {"FREQ"}
            until(session, lambda it: it.time > gone.time + 0.5)
    recording = mikas.open(path)
    condition = SearchCondition(recording.formula_catalog, "LAMBDA > 1.1 and FREQ > 100")
    (hit,) = search(recording, condition).hits
    assert hit.peak == 1.25
    assert hit.end <= gone.time + 1e-6  # the file has microseconds
