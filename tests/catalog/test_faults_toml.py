"""Faults, models and errata: what is known, how well, and nothing beyond it."""

from __future__ import annotations

import re

import pytest

from mikas.catalog import INTERPRETATIONS, Confidence, Fault, shipped
from mikas.i18n import Text

CONFIRMED = {12, 17, 18, 21, 22}
REPORTED = {13, 14, 23, 24, 25, 26, 31, 32, 41, 51, 52, 195}
INJECTORS = {*range(131, 140), *range(141, 144)}
RELAYS = {*range(167, 170), *range(177, 180), *range(181, 184), *range(191, 197)}
ORDER_UNKNOWN = (INJECTORS | {*range(161, 167)} | RELAYS) - {195}
UNCONFIRMED = ORDER_UNKNOWN | {
    15, 16, 53, 54, 55, 61, 62, 63, 64, 65, 71, 72, 81, 82, 83, 84, 91, 92, 93, 94,
}  # fmt: skip


def in_both_languages(text: Text) -> bool:
    return bool(text.en and not re.search("[А-яЁё]", text.en) and re.search("[А-яЁё]", text.ru))


def test_the_faults_with_a_text_are_exactly_the_known_numbers() -> None:
    by_confidence = {
        confidence: {code for code, fault in shipped().faults.items()
                     if fault.confidence is confidence}
        for confidence in Confidence
    }  # fmt: skip
    assert by_confidence == {
        Confidence.CONFIRMED: CONFIRMED,
        Confidence.REPORTED: REPORTED,
        Confidence.UNCONFIRMED: UNCONFIRMED,
        Confidence.UNKNOWN: set(),
    }


def test_every_fault_is_complete() -> None:
    names = {parameter.name for parameter in shipped().parameters}
    for code, fault in shipped().faults.items():
        assert fault.code == code
        assert fault.known
        assert in_both_languages(fault.text)
        assert in_both_languages(fault.check)
        assert set(fault.parameters) <= names
        assert bool(fault.sources) == (fault.confidence is not Confidence.UNCONFIRMED)
        assert len(fault.sources) >= (2 if fault.confidence is Confidence.CONFIRMED else 0)


def test_a_fault_of_a_sensors_circuit_names_the_channels_that_may_be_substitutes() -> None:
    """Without `sensor`, a substitute value is rated as if it were measured."""
    of_sensors = {code for code, fault in shipped().faults.items() if "датчик" in fault.text.ru}
    assert len(of_sensors) > 10
    without = {code for code in of_sensors if not shipped().fault(code).sensor}
    assert without == {15, 16}, "these have no channel; any other names its channels in `sensor`"


@pytest.mark.parametrize("code", sorted(ORDER_UNKNOWN))
def test_where_the_order_is_unknown_the_text_says_so(code: int) -> None:
    text = shipped().fault(code).text
    assert "unconfirmed" in text.en
    assert "не подтвержд" in text.ru
    first, last = map(int, re.findall(r"(\d{3})–(\d{3})", text.en)[0])
    assert first <= code <= last
    assert {shipped().fault(other).text for other in range(first, last + 1)} - {
        shipped().fault(195).text
    } == {text}


def test_195_is_the_one_of_its_three_that_has_a_source() -> None:
    fault = shipped().fault(195)
    assert fault.sources == ("S6",)
    assert fault.text.ru.startswith("Цепь реле вентилятора охлаждения")
    assert "inferred" in fault.text.en
    for code in (194, 196):
        assert shipped().fault(code).text.en.startswith("Cooling fan relay circuit (which of")


def test_texts_of_faults_are_those_of_a_mechanic() -> None:
    assert shipped().fault(17).text == Text(
        "Air temperature signal low (short to ground)",
        "Низкий уровень сигнала датчика температуры воздуха, ДТВ (замыкание на массу)",
    )
    assert shipped().fault(83).text.en == "Knock retard at its limit, cylinder 3"
    assert shipped().fault(64).text.ru == "Ошибка чтения энергонезависимой памяти блока"
    assert "Injector 4" in shipped().fault(142).text.en


def test_12_is_no_fault() -> None:
    assert [code for code, fault in shipped().faults.items() if fault.informational] == [12]


def test_a_fault_in_json_names_what_it_is() -> None:
    fault, message = shipped().fault(13).as_json(), shipped().fault(12).as_json()
    assert fault["code"] == 13
    assert fault["text"] == shipped().fault(13).text._asdict()
    assert fault["check"] == shipped().fault(13).check._asdict()
    assert (fault["confidence"], fault["parameters"]) == ("reported", ["JAIR"])
    assert (fault["informational"], message["informational"]) == (False, True)


def test_every_other_number_has_no_text() -> None:
    for code in set(range(256)) - set(shipped().faults):
        assert shipped().fault(code) == Fault(code)
        assert not shipped().fault(code).known
        assert shipped().fault(code).text == Text("", "")
        assert shipped().fault(code).confidence is Confidence.UNKNOWN
    assert repr(shipped().fault(13)) == "<Fault 13: Air mass signal low (reported)>"
    assert repr(Fault(99)) == "<Fault 99: no text (unknown)>"


def test_both_models_are_known_and_any_other_is_shown_by_its_code() -> None:
    assert shipped().model(0x09).text == Text("Mikas 5.4", "Микас 5.4")
    assert shipped().model(0x0A).text == Text("Mikas 7.1", "Микас 7.1")
    assert [code for code in range(256) if shipped().model(code).known] == [0x09, 0x0A]
    unknown = shipped().model(0x0B)
    assert unknown.code == 0x0B
    assert unknown.text == Text("unknown model 0x0B", "неизвестная модель 0x0B")


def test_intake_is_marked_as_our_interpretation_of_the_air_temperature() -> None:
    (name,) = shipped().parameter("TAIR").errata
    reason = shipped().errata[name].reason
    assert "“intake” is our interpretation" in reason.en
    assert "«на впуске» — наше толкование" in reason.ru


def test_four_errata_are_selected_as_their_document_says() -> None:
    errata = shipped().errata
    assert list(errata) == ["E1", "E2", "E3", "E4"]
    assert [each.selected_by for each in errata.values()] == [
        "literal",
        "literal",
        "alternative",
        "",
    ]
    for name, erratum in errata.items():
        assert erratum.name == name
        assert erratum.source == f"§4, {name}"
        assert {erratum.selected_by} <= {*INTERPRETATIONS, ""}
        for text in (erratum.title, erratum.reason, erratum.default):
            assert in_both_languages(text)
        assert erratum.alternative.en
        assert erratum.alternative.ru
    assert [name for name, each in errata.items() if each.family.en] == ["E3"]
    assert in_both_languages(errata["E3"].family)


def test_parameters_and_units_speak_both_languages() -> None:
    for parameter in shipped().parameters:
        assert in_both_languages(parameter.text)
        for conversion in parameter.interpretations.values():
            assert conversion.unit == "" or conversion.unit in shipped().units
