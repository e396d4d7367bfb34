"""`read` of derived channels: their parameters in few requests, their values, what is missing."""

from __future__ import annotations

import asyncio
from math import isnan

import pytest
from client_harness import bench, ecu_on

from mikas.catalog import load
from mikas.client import AsyncEcu, DerivedValue, Reading
from mikas.client.parameters.derived import DerivedChannels
from mikas.errors import NeedsSamples, NotSupported, UnknownParameter
from virtual_harness import DATA

INJ, FREQ, JAIR, TWAT = 0x3F, 0x29, 0x32, 0x1A
OWN = """
[derived.COST]
formula = "FUEL_USED * 55"
text = "petrol burnt, in roubles"
[derived.TWICE]
formula = "2 * TWAT"
text = "twice"
"""


def test_a_derived_channel_takes_one_request_and_is_computed_as_in_samples():
    it = bench()
    ecu = ecu_on(it)
    values = ecu.read("TWAT", "fuel_flow", "DUTY")
    assert list(values) == ["TWAT", "FUEL_FLOW", "DUTY"]
    assert it.requests() == [bytes([0x61, TWAT, FREQ, INJ])]
    flow = values["FUEL_FLOW"]
    assert isinstance(flow, DerivedValue)
    readings = ecu.parameters.read(["FREQ", "INJ"])
    sampled = DerivedChannels(ecu.catalog, ["FUEL_FLOW"]).update(readings, flow.time)["FUEL_FLOW"]
    assert flow.value == sampled.value > 0
    assert (flow.unit, flow.raw, flow.interpretation) == ("l/h", b"", "corrected")
    assert flow.inputs["FREQ"].value == readings["FREQ"].value
    assert flow.time == values["TWAT"].time
    assert flow.channel is ecu.catalog.derived["FUEL_FLOW"]
    assert flow.shown.ru == f"{flow.value:.1f}".replace(".", ",") + " л/ч"


def test_its_parameters_are_not_listed_unless_they_were_named():
    it = bench()
    ecu = ecu_on(it)
    assert list(ecu.read("FUEL_FLOW")) == ["FUEL_FLOW"]
    assert list(ecu.read("FUEL_FLOW", "INJ")) == ["FUEL_FLOW", "INJ"]
    assert it.requests()[-1] == bytes([0x61, INJ, FREQ])


def test_a_unit_of_short_lists_is_asked_no_more_often_than_for_the_parameters():
    it = bench(max_list=2)
    ecu = ecu_on(it)
    ecu.read("INJ", "FREQ", "JAIR")
    it.forget()
    assert len(ecu.read("FUEL_FLOW", "AIR_STROKE", "DUTY")) == 3
    assert len(it.requests()) == 2


def test_a_formula_without_a_result_is_a_value_that_has_none():
    values = ecu_on(bench(DATA | {FREQ: b"\x00"})).read("AIR_STROKE", "FILLING", "FREQ")
    for name in ("AIR_STROKE", "FILLING"):
        value = values[name]
        assert isinstance(value, DerivedValue)
        assert isnan(value.value)
        assert not value.has_value
        assert (str(value), value.shown.en) == (f"{name} no value", "no value")
        assert value.inputs["FREQ"].value == 0
    assert isinstance(values["FREQ"], Reading)


def test_a_parameter_that_the_unit_lacks_is_named():
    data = {code: raw for code, raw in DATA.items() if code != INJ}
    ecu = ecu_on(bench(data))
    with pytest.raises(NotSupported, match=r"INJ \(61 3F\), needed for FUEL_FLOW"):
        ecu.read("TWAT", "FUEL_FLOW")
    assert ecu.read("AIR_STROKE")["AIR_STROKE"].value > 0
    data = {code: raw for code, raw in data.items() if code != FREQ}
    with pytest.raises(NotSupported) as caught:
        ecu_on(bench(data)).read("FUEL_FLOW")
    assert "parameters FREQ (61 29), INJ (61 3F), needed for FUEL_FLOW" in str(caught.value)
    assert "нужны для FUEL_FLOW" in caught.value.text.ru


def test_what_adds_up_over_time_is_refused_before_anything_is_sent(tmp_path):
    own = tmp_path / "own.toml"
    own.write_text(OWN)
    it = bench()
    ecu = ecu_on(it)
    ecu.use_catalog(load(own))
    for name in ("FUEL_USED", "COST"):
        with pytest.raises(NeedsSamples) as caught:
            ecu.read("TWAT", name)
        assert name in str(caught.value)
        assert "FUEL_USED is added up from sample to sample" in str(caught.value)
    assert not it.requests()
    assert ecu.read("TWICE")["TWICE"].value == 2 * ecu.read("TWAT")["TWAT"].value


def test_all_parameters_are_read_without_the_derived_ones():
    assert "FUEL_FLOW" not in ecu_on(bench()).read()


def test_a_name_that_is_almost_one_is_answered_with_it():
    with pytest.raises(UnknownParameter, match="FUEL_FLOW"):
        ecu_on(bench()).read("FUEL_FLO")


def test_formulas_use_corrected_values_whatever_is_shown():
    literal = ecu_on(bench(), interpretation="literal").read("DUTY", "INJ")
    corrected = ecu_on(bench()).read("DUTY", "INJ")
    assert literal["DUTY"].value == corrected["DUTY"].value


def test_the_async_unit_reads_them_too():
    async def read():
        async with AsyncEcu(ecu_on(bench())) as ecu:
            return await ecu.read("FUEL_FLOW", "TWAT")

    values = asyncio.run(read())
    assert values["FUEL_FLOW"].value == ecu_on(bench()).read("FUEL_FLOW")["FUEL_FLOW"].value


@pytest.mark.parametrize(
    "use",
    [
        lambda ecu: next(ecu.watch("FUEL_FLOW")),
        lambda ecu: ecu.set_list("fuel_flow"),
        lambda ecu: ecu.write_parameter("FUEL_FLOW", 1),
    ],
    ids=["watch", "list", "write"],
)
def test_where_only_parameters_are_taken_a_derived_channel_is_said_to_be_one(use):
    it = bench()
    with pytest.raises(UnknownParameter, match=r"derived channel, computed from FUEL_STROKE, FREQ"):
        use(ecu_on(it))
    assert it.requests() == []


def test_one_is_shown_on_a_line():
    value = ecu_on(bench()).read("FUEL_FLOW")["FUEL_FLOW"]
    assert repr(value).startswith("<DerivedValue FUEL_FLOW ")
    assert len(repr(value)) < 100
