"""The shipped parameters against §4, row by row: every expected value is worked out by hand."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from mikas.catalog import Confidence, shipped
from mikas.i18n import Text
from protocol_codes import CODE_OF, CODES, NAMES, TWO_BYTES

# name, code, unit, Russian unit, formula, and raw bytes (as on the wire) with their values
LAW = [
    ("TWAT", 0x1A, "°C", "°C", "b − 40", {"00": -40, "28": 0, "7D": 85, "FF": 215}),
    ("FREQ", 0x29, "rpm", "об/мин", "b · 40", {"00": 0, "15": 840, "82": 5200, "FF": 10200}),
    ("FREQX", 0x2C, "rpm", "об/мин", "b · 10", {"00": 0, "55": 850, "FF": 2550}),
    ("UOZ", 0x26, "° crank", "° ПКВ", "s / 2", {"1B": 13.5, "7F": 63.5, "80": -64.0, "FF": -0.5}),
    ("UACC", 0x1E, "V", "В", "b / 10", {"00": 0.0, "7F": 12.7, "8E": 14.2, "FF": 25.5}),
    ("INJ", 0x3F, "ms", "мс", "w / 125", {"5802": 4.8, "0100": 0.008, "FFFF": 524.28}),
    ("JAIR", 0x21, "kg/h", "кг/ч", "w / 100", {"DC05": 15.0, "0100": 0.01, "FFFF": 655.35}),
    ("JQT", 0x40, "l/h", "л/ч", "w / 10", {"0D00": 1.3, "0D40": 1639.7, "FFFF": 6553.5}),
    ("DET", 0x08, "", "", "b & 0x40", {"40": True, "BF": False, "FF": True, "00": False}),
    ("RXX", 0x07, "", "", "b & 0x04", {"04": True, "FB": False}),
    ("BITPOW", 0x07, "", "", "b & 0x20", {"20": True, "DF": False}),
    ("RDET", 0x07, "", "", "b & 0x80", {"80": True, "7F": False}),
    ("VALF", 0x39, "", "", "0.5 + b/256", {"00": 0.5, "80": 1.0, "FF": 1.49609375}),
    ("THR", 0x20, "%", "%", "b", {"00": 0, "64": 100, "FF": 255}),
    ("RCOK", 0x42, "", "", "(b − 128)/256 − 0.5", {"00": -1.0, "80": -0.5, "FF": -0.00390625}),
    ("RCOD", 0x41, "", "", "(b − 128)/256 − 0.5", {"00": -1.0, "80": -0.5, "FF": -0.00390625}),
    ("UOZOC", 0x28, "° crank", "° ПКВ", "s / 2", {"00": 0.0, "FA": -3.0, "7F": 63.5}),
    ("SSM", 0x5B, "step", "шаг", "b", {"00": 0, "FF": 255}),
    ("FSM", 0x5C, "step", "шаг", "b", {"00": 0, "3C": 60}),
    ("MINERR", 0x72, "", "", "b", {"0D": 13, "C3": 195}),
    ("UGB", 0x59, "kg/h", "кг/ч", "w / 100", {"7805": 14.0, "FFFF": 655.35}),
    ("TAIR", 0x1C, "°C", "°C", "b − 40", {"00": -40, "3C": 20}),
    ("TWATI", 0x19, "°C", "°C", "b − 40", {"00": -40, "14": -20}),
]
# Shipped parameters of other sources: rows as above, each with its source as the catalog names it.
BEYOND_SECTION_4: list[tuple[tuple[str, int, str, str, str, dict[str, object]], str]] = []
ROWS = LAW + [row for row, _ in BEYOND_SECTION_4]
SOURCE_OF = dict.fromkeys(NAMES, "§4") | {row[0]: source for row, source in BEYOND_SECTION_4}


def test_the_fixed_set_is_the_table_of_the_document() -> None:
    """`protocol_codes`, which other tests compute with, against docs/protocol.md."""
    document = (Path(__file__).parents[2] / "docs" / "protocol.md").read_text(encoding="utf-8")
    row = r'^\| <a id="p-[a-z]+"></a>([A-Z]+) \| ([0-9A-F]{2}) \| ([12]) '
    rows = re.findall(row, document, re.MULTILINE)
    assert [(name, int(code, 16)) for name, code, _ in rows] == list(CODE_OF.items())
    assert {int(code, 16) for _, code, size in rows if size == "2"} == TWO_BYTES
    assert [(row[0], row[1]) for row in LAW] == list(CODE_OF.items())


def test_the_parameters_of_the_law_come_first_in_its_order() -> None:
    names = [parameter.name for parameter in shipped().parameters]
    assert names == [row[0] for row in ROWS]
    assert tuple(names[:23]) == NAMES


def test_section_4_has_21_distinct_codes_with_25_bytes() -> None:
    codes = shipped().codes[:21]
    assert codes == tuple((code, 2 if code in TWO_BYTES else 1) for code in CODES)
    assert sum(size for _, size in codes) == 25
    assert set(shipped().codes[21:]) == {
        (row[1], _size(row)) for row, _ in BEYOND_SECTION_4 if row[1] not in CODES
    }


def _size(row: tuple[str, int, str, str, str, dict[str, object]]) -> int:
    return len(bytes.fromhex(next(iter(row[5]))))


@pytest.mark.parametrize(
    ("name", "code", "unit", "unit_ru", "formula", "values"), ROWS, ids=SOURCE_OF
)
def test_a_parameter_has_the_code_unit_and_formula_of_its_row(
    name: str, code: int, unit: str, unit_ru: str, formula: str, values: dict[str, object]
) -> None:
    parameter = shipped().parameter(name)
    assert (parameter.code, parameter.unit) == (code, unit)
    assert parameter.unit_text == Text("steps" if unit == "step" else unit, unit_ru)
    assert parameter.formula() == formula
    for raw, value in values.items():
        assert parameter.size == len(bytes.fromhex(raw))
        got = parameter.decode(bytes.fromhex(raw))
        assert got == value
        assert type(got) is type(value)
        if not parameter.is_flag:
            assert parameter.encode(got) == bytes.fromhex(raw)


@pytest.mark.parametrize(
    ("name", "interpretation", "formula", "values"),
    [
        ("UACC", "literal", "s / 10", {"8E": -11.4, "7F": 12.7, "80": -12.8, "00": 0.0}),
        ("FREQ", "literal", "b · 40", {"FF": 10200}),
        ("FREQX", "literal", "b · 10", {"FF": 2550}),
        ("RCOK", "literal", "(b − 128)/256 − 0.5", {"00": -1.0, "80": -0.5, "FF": -0.00390625}),
        ("RCOK", "alternative", "(b − 128)/256", {"00": -0.5, "80": 0.0, "FF": 0.49609375}),
        ("RCOK", "family", "(b + 128)/256", {"00": 0.5, "80": 1.0, "FF": 1.49609375}),
        ("RCOD", "family", "(b − 128)/256 − 0.5", {"80": -0.5}),
        ("RCOD", "literal", "(b − 128)/256 − 0.5", {"00": -1.0, "80": -0.5, "FF": -0.00390625}),
        ("RCOD", "alternative", "(b − 128)/256", {"00": -0.5, "80": 0.0, "FF": 0.49609375}),
        ("TAIR", "literal", "b − 40", {"3C": 20}),
        ("TWAT", "alternative", "b − 40", {"7D": 85}),
    ],
)
def test_each_interpretation_has_its_formula_and_values(
    name: str, interpretation: str, formula: str, values: dict[str, float]
) -> None:
    parameter = shipped().parameter(name)
    assert parameter.formula(interpretation) == formula
    for raw, value in values.items():
        assert parameter.decode(bytes.fromhex(raw), interpretation) == value
        assert parameter.encode(value, interpretation) == bytes.fromhex(raw)


@pytest.mark.parametrize("name", ["FREQ", "FREQX"])
def test_e1_changes_the_unit_and_not_the_number(name: str) -> None:
    parameter = shipped().parameter(name)
    assert parameter.interpretation("corrected").unit == "rpm"
    assert parameter.interpretation("literal").unit == "1/s"
    assert parameter.interpretation("literal").unit_text == Text("1/s", "1/с")


def test_errata_concern_the_parameters_that_the_document_names() -> None:
    concerned = {each.name: each.errata for each in shipped().parameters if each.errata}
    assert concerned == {
        "FREQ": ("E1",),
        "FREQX": ("E1",),
        "UACC": ("E2",),
        "RCOK": ("E3",),
        "RCOD": ("E3",),
        "TAIR": ("E4",),
    }


def test_only_errata_make_interpretations_differ() -> None:
    for parameter in shipped().parameters:
        interpretations = parameter.interpretations
        assert (interpretations["literal"] != interpretations["corrected"]) == bool(
            {"E1", "E2"} & set(parameter.errata)
        )
        assert ("alternative" in interpretations) == ("E3" in parameter.errata)
        assert ("family" in interpretations) == (parameter.name == "RCOK")


def test_warm_idle_is_referenced_as_unconfirmed() -> None:
    given = {each.name: each.reference for each in shipped().parameters if each.reference}
    assert given == {
        "TWAT": (80, 95),
        "FREQ": (800, 900),
        "FREQX": (800, 900),
        "UOZ": (10, 16),
        "UACC": (13.5, 14.5),
        "INJ": (4, 5.5),
        "JAIR": (13, 16),
        "THR": (0, 0),
    }
    for parameter in shipped().parameters:
        known = Confidence.UNCONFIRMED if parameter.reference else Confidence.UNKNOWN
        assert parameter.reference_confidence is known


def test_every_range_says_what_it_is_and_lies_within_the_limits() -> None:
    for parameter in shipped().parameters:
        limits, span = parameter.limits(), parameter.range
        if parameter.is_flag:
            assert (limits, span, parameter.range_kind) == (None, None, "")
            continue
        assert limits is not None
        assert span is not None
        assert limits[0] <= span[0] < span[1] <= limits[1]
        assert parameter.range_kind == ("plausible" if parameter.plausible else "representable")


def test_every_row_has_its_source_and_confidence() -> None:
    for parameter in shipped().parameters:
        assert parameter.source == SOURCE_OF[parameter.name]
        assert parameter.confidence is Confidence.REPORTED or parameter.name not in NAMES
