"""`mikas read`, `write` and `params`: their JSON of docs/reference/cli.md, and their text."""

from __future__ import annotations

import re

import pytest
from cli_harness import is_hex

from mikas.catalog import shipped
from mikas.cli.failures import REFUSED, USAGE
from mikas.cli.render.values import reading_json, value_text
from mikas.testing.units import VirtualUnit
from mikas.virtual.cars import EngineCar
from mikas.virtual.model.engine import Engine
from protocol_codes import NAMES


def test_read_has_values_of_their_type_with_units(mikas):
    readings = mikas("read", "TWAT", "RXX", "0x3F:2", "--json").object["readings"]
    assert set(readings) == {"TWAT", "RXX", "0x3F:2"}
    assert readings["TWAT"]["unit"] == "°C"
    assert type(readings["TWAT"]["value"]) in (int, float)
    assert readings["RXX"]["value"] in (True, False)
    assert type(readings["RXX"]["value"]) is bool
    for reading in readings.values():
        assert set(reading) == {"value", "unit", "raw", "time"}
        assert is_hex(reading["raw"])
        assert type(reading["time"]) is float
    assert len(readings["0x3F:2"]["raw"]) == 4


def test_every_parameter_is_read_when_none_is_named(mikas):
    listed = {it["name"] for it in mikas("params", "--json").object["parameters"]}
    assert listed == {parameter.name for parameter in shipped().parameters}
    codes = EngineCar(Engine(), shipped()).codes  # the simulated engine may lack a shipped code
    simulated = {parameter.name for parameter in shipped().parameters if parameter.code in codes}
    assert set(mikas("read", "--json").object["readings"]) == simulated
    assert set(NAMES) <= simulated


def test_params_describes_each_parameter_without_a_port(mikas):
    ran = mikas("params", "--json", sim="&supplied=0")  # needs no port
    parameters = {it["name"]: it for it in ran.object["parameters"]}
    inj = parameters["INJ"]
    assert {"name", "code", "size", "unit", "formula", "text", "errata"} <= set(inj)
    assert (inj["code"], inj["size"], inj["unit"]) == ("3F", 2, "ms")
    assert set(inj["text"]) == {"en", "ru"}
    assert parameters["FREQ"]["errata"][0]["name"] == "E1"


def test_params_has_what_each_rests_on_and_the_readings_that_a_car_decides_on(mikas):
    parameters = {it["name"]: it for it in mikas("params", "--json").object["parameters"]}
    rcok = parameters["RCOK"]
    assert rcok["otherwise"] == [
        {"name": "alternative", "formula": "(b − 128)/256", "unit": ""},
        {"name": "family", "formula": "(b + 128)/256", "unit": ""},
    ]
    assert rcok["evidence"]["source"] == {"en": "letter; odd", "ru": "буква; странная"}
    assert rcok["evidence"]["seen"] == []
    assert parameters["FREQ"]["otherwise"] == []
    formulas = {row[0]: row[3] for row in (line.split("\t") for line in mikas("params").lines)}
    assert formulas["RCOK"] == (
        "(b − 128)/256 − 0.5; alternative: (b − 128)/256; family: (b + 128)/256"
    )
    chosen = mikas("params", "--interpretation", "family", "--lang", "ru").out
    assert "(b + 128)/256; буквально: (b − 128)/256 − 0.5; иначе: (b − 128)/256" in chosen


def test_read_has_the_readings_of_rcok_beside_each_other(mikas):
    read = mikas("read", "RCOK", "RCOD", "TWAT", "--json").object["readings"]
    raw = int(read["RCOK"]["raw"], 16)
    assert read["RCOK"]["value"] == (raw - 128) / 256 - 0.5
    assert read["RCOK"]["otherwise"] == {
        "alternative": (raw - 128) / 256,
        "family": (raw + 128) / 256,
    }
    assert list(read["RCOD"]["otherwise"]) == ["alternative"]
    assert "otherwise" not in read["TWAT"]
    row = next(line for line in mikas("read", "RCOK").lines if line.startswith("RCOK"))
    assert re.search(r"\tFuel correction factor; alternative -?0\.\d{3}; family \d\.\d{3}\t", row)
    row = mikas("read", "RCOK", "--interpretation", "family", "--lang", "ru").lines[1]
    assert re.search(r"топливоподачи; буквально -0,\d{3}; иначе -?0,\d{3}\t", row)


def test_a_write_reports_value_and_bytes_before_and_after(mikas):
    ran = mikas("write", "UOZ", "10", "--yes", "--json").object
    assert set(ran) == {"schema", "name", "before", "after", "raw_before", "raw_after"}
    assert (ran["name"], ran["after"], ran["raw_after"]) == ("UOZ", 10, "14")
    assert is_hex(ran["raw_before"])


def test_read_in_text_has_a_line_a_parameter_in_the_language(mikas):
    ran = mikas("read", "TWAT", "RXX")
    assert [line.split("\t")[0] for line in ran.lines] == ["name", "TWAT", "RXX"]
    assert mikas("read", "UACC", "--lang", "ru").lines[1].split("\t")[1].startswith("14,")
    assert "80 … 95" in ran.out


def test_a_parameter_write_shows_values(mikas):
    ran = mikas("write", "UOZ", "-5,5", "--yes")
    assert "after:  -5.5 ° crank (F5)" in ran.err
    assert "keeps this value when it loses its supply is unknown" in ran.err
    assert ran.out.endswith("→ -5.5 ° crank\n")
    assert mikas.journal[-1]["after"] == "F5"
    ran = mikas("write", "INJ", "--raw", "5802", "--yes", "--lang", "ru")
    assert ran.status in (0, 5)
    assert "будет: 4,80 мс (58 02)" in ran.err


@pytest.mark.parametrize(
    "argv",
    [
        ["read"],
        ["write", "UOZ", "5", "--yes"],
        ["scan"],
        ["list", "set", "FREQ", "--yes"],
        ["list", "read", "FREQ"],
        ["info", "--quick"],
        ["mem", "read", "ram", "40", "8"],
        ["mem", "verify", "ram", "8.bin", "--from", "40"],
        ["mem", "restore", "ram", "8.bin", "--ignore-manifest", "--from", "40", "--yes"],
    ],
    ids=" ".join,
)
def test_what_was_learnt_is_forgotten(mikas, argv, tmp_path):
    (tmp_path / "8.bin").write_bytes(bytes(8))
    mikas("read", sim="&max_list=5")
    assert mikas("info", "--json", "--quick", sim="").object["limits"]["max_list"] == 5
    assert mikas(*argv, "--relearn").status in (0, REFUSED)
    assert mikas("info", "--json", "--quick").object["limits"]["max_list"] == 64


def test_read_computes_a_derived_channel_beside_the_parameters(mikas):
    readings = mikas("read", "FUEL_FLOW", "FREQ", "--json").object["readings"]
    flow = readings["FUEL_FLOW"]
    assert set(flow) == {"value", "unit", "raw", "time", "inputs"}
    assert (flow["unit"], flow["raw"]) == ("l/h", None)
    assert flow["inputs"]["FREQ"] == readings["FREQ"]["value"]
    assert flow["value"] > 0
    ran = mikas("read", "FUEL_FLOW", "TWAT")
    assert [line.split("\t")[0] for line in ran.lines] == ["name", "FUEL_FLOW", "TWAT"]
    assert "л/ч" in mikas("read", "FUEL_FLOW", "--lang", "ru").lines[1]


def test_a_channel_that_adds_up_is_refused_with_the_command_that_does_it(mikas):
    ran = mikas("read", "FUEL_USED", sim="&supplied=0")  # needs no answer
    assert ran.status == USAGE
    assert "`mikas watch FUEL_USED`" in ran.err
    error = mikas("read", "FUEL_USED", "--json").object["error"]
    assert error["code"] == "NeedsSamples"


def test_a_formula_without_a_result_is_null_in_json_and_a_dash_in_a_table():
    with VirtualUnit() as unit, unit.connect() as ecu:
        unit.set("FREQ", 0)
        value = ecu.read("AIR_STROKE")["AIR_STROKE"]
    shown = reading_json(value)
    assert shown["value"] is None
    assert shown["inputs"]["FREQ"] == 0
    assert value_text(value) == "–"
