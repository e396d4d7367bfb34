"""Samples with what instruments give: derived channels and alarms, in a session as it is used."""

from __future__ import annotations

from pathlib import Path

import pytest

import mikas
from mikas.errors import UsageError
from mikas.sampling.events import AlarmChanged, Sampled

CITY = "sim:?clock=simulated&seed=3&scenario=city"
DERIVED = """
[derived.LEANER]
text = { en = "Leaner than asked", ru = "Беднее расчётного" }
formula = "LAMBDA - VALF"
decimals = 3
[derived.LEANER.limits]
warning_high = -9
[derived.WAY]
text = { en = "Way", ru = "Путь" }
formula = "GPS_SPEED / 3600"
accumulates = true
unit = "km"
[instrument.AFR.limits]
danger_high = 5
"""


@pytest.fixture
def mine(tmp_path: Path) -> Path:
    (tmp_path / "mine.toml").write_text(DERIVED, encoding="utf-8")
    return tmp_path / "mine.toml"


def test_a_derived_channel_of_both_has_values_live_and_the_same_recorded(
    tmp_path: Path, mine: Path
) -> None:
    path = tmp_path / "a.pcapng"
    names = ["FREQ", "LEANER", "WAY"]
    with mikas.session(
        CITY, names, record=path, duration=60, rate=5, catalogs=mine,
        instruments=("aem=sim:", "nmea=sim:"),
    ) as session:  # fmt: skip
        events = list(session.events())
    samples = [it for it in events if isinstance(it, Sampled)]
    assert "VALF" in samples[-1].fresh  # for the formula alone
    lean = [it for it in samples if "LEANER" in it.derived]
    assert len(lean) > 200
    for it in lean:
        expected = it.values["LAMBDA"] - it.values["VALF"]
        assert it.values["LEANER"] == pytest.approx(expected)
        assert list(it.derived["LEANER"].inputs) == ["LAMBDA", "VALF"]
    assert [it for it in samples if "LAMBDA" not in it.instruments and "LEANER" in it.derived] == []
    way = samples[-1].values["WAY"]
    table = mikas.open(path, names=["WAY", "GPS_SPEED"], catalogs=mine).to_pandas()
    assert way == pytest.approx(table["WAY"].max(), rel=0.02)
    assert way > 0.1
    alarms = {it.name: it for it in events if isinstance(it, AlarmChanged)}
    assert (alarms["AFR"].level, alarms["LEANER"].level) == ("danger", "warning")
    noted = {it.name for it in mikas.open(path).events if isinstance(it, AlarmChanged)}
    assert noted >= {"AFR", "LEANER"}


def test_an_alarm_of_an_instrument_by_the_last_sample_is_not_lost(
    tmp_path: Path, mine: Path
) -> None:
    def run(**more: object) -> list[AlarmChanged | Sampled]:
        with mikas.session(
            CITY, ["FREQ", "LEANER"], catalogs=mine, instruments="aem=sim:", **more
        ) as session:
            found = list(session.events())
        return [it for it in found if isinstance(it, AlarmChanged | Sampled)]

    events = run(count=60)
    first = next(at for at, it in enumerate(events) if getattr(it, "name", "") == "AFR")
    count = sum(isinstance(it, Sampled) for it in events[:first])
    path = tmp_path / "a.pcapng"
    alarms = [it.name for it in run(count=count, record=path) if isinstance(it, AlarmChanged)]
    assert {"AFR", "LEANER"} <= set(alarms)
    assert [it.name for it in mikas.open(path).events if isinstance(it, AlarmChanged)] == alarms


def test_a_meter_with_a_label_and_one_of_ones_own_are_described_for_a_formula(
    tmp_path: Path,
) -> None:
    mine = tmp_path / "mine.toml"
    mine.write_text(
        '[instrument.LAMBDA_LEFT]\ntext = "Left"\n[derived.X]\ntext = "X"\n'
        'formula = "LAMBDA_LEFT - LAMBDA"\n',
        encoding="utf-8",
    )
    with mikas.session(
        CITY, ["FREQ", "X"], duration=3, catalogs=mine, instruments=("left:aem=sim:", "aem=sim:")
    ) as session:
        found = [it.values["X"] for it in session if "X" in it.values]
    assert found
    assert all(abs(value) < 0.1 for value in found)


def test_without_the_instrument_the_derived_channel_is_refused(mine: Path) -> None:
    with pytest.raises(UsageError, match="LEANER needs LAMBDA, which no instrument") as refused:
        mikas.session(CITY, ["FREQ", "LEANER"], catalogs=mine)
    assert "нужен LAMBDA" in refused.value.text.ru
    with pytest.raises(UsageError, match="LEANER needs LAMBDA"):
        mikas.session(CITY, ["LEANER"], catalogs=mine, instruments="left:aem=sim:")
    with mikas.connect(CITY, catalogs=mine) as ecu:
        with pytest.raises(UsageError, match="LAMBDA comes from an instrument"):
            ecu.read("LEANER")
        assert ecu.read("FREQ")["FREQ"].value > 0


def test_what_instruments_alone_give_needs_a_parameter_of_the_unit(mine: Path) -> None:
    with pytest.raises(UsageError, match="name a parameter of the unit as well"):
        mikas.session(CITY, ["WAY"], catalogs=mine, instruments="nmea=sim:")


def test_the_alarm_of_a_formula_ends_with_the_instruments_values(mine: Path) -> None:
    from mikas.catalog import load
    from mikas.client.parameters.readings import decode
    from mikas.instruments.reading import InstrumentReading
    from mikas.sampling.beside import SamplesBeside
    from mikas.sampling.plan import select

    catalog = load(mine)
    beside = SamplesBeside([catalog.instruments["LAMBDA"]])
    selection = select(catalog, ["LEANER"])

    def seen(time: float, *, meter: bool) -> list[tuple[str, str]]:
        reading = decode(catalog.parameter("VALF"), b"\x80", time, "corrected")
        given = {"LAMBDA": InstrumentReading(catalog.instruments["LAMBDA"], 1.1, time)}
        sample = beside.completed(
            Sampled(time, {"VALF": reading}, {}), given if meter else {}, selection
        )
        assert ("LEANER" in sample.derived) == meter
        return [(it.name, it.level) for it in beside.alarms(sample)]

    assert seen(1.0, meter=True) == [("LEANER", "warning")]
    assert seen(2.0, meter=True) == []
    assert seen(3.0, meter=False) == [("LEANER", "none")]
    assert seen(4.0, meter=True) == [("LEANER", "warning")]
