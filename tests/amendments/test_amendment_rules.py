"""The rule of each question: which clauses an answer concerns, and whether the unit agrees."""

from __future__ import annotations

import pytest

from mikas.amendments import Amendment, clauses, parameters
from mikas.amendments.patch import changed_files
from mikas.catalog import shipped
from mikas.catalog.evidence import Agreement, evidence
from mikas.catalog.loading.loader import load_changed
from mikas.i18n import Text
from mikas.survey.concluding import QUESTIONS

AGREES, DIFFERS, SHOWS = Agreement
JUDGES = {**clauses.JUDGES, **parameters.JUDGES}
SIZES = {f"{each.code:02X}": each.size for each in shipped().parameters}


def judged(question, value):
    return list(JUDGES[question](value, shipped()))


def test_the_rules_are_of_questions_that_a_survey_has():
    assert set(JUDGES) <= set(QUESTIONS)
    assert set(QUESTIONS) - set(JUDGES) == {"moves", "writes"}
    assert not set(clauses.JUDGES) & set(parameters.JUDGES)


@pytest.mark.parametrize(
    ("question", "value", "of", "agreement"),
    [
        ("version", "0A", ("01",), AGREES),
        ("version", "3C", ("01",), SHOWS),
        ("echo", False, ("D1",), AGREES),
        ("turn_round", {"median": 0.3, "spread": 0.2}, ("D14",), SHOWS),
        ("turn_round", {"median": 0.3, "spread": 0.21}, ("D14",), DIFFERS),
        ("turn_round_running", {"median": 0.6, "spread": 0.0}, ("D14",), DIFFERS),
        ("inter_byte", 0.2, ("D14",), SHOWS),
        ("inter_byte", 0.21, ("D14",), DIFFERS),
        ("least_pause", 0.1, ("D14",), SHOWS),
        ("unknown", "01", ("D10",), SHOWS),
        ("unknown", "7F05", ("D10",), DIFFERS),
        ("counted_blocks", False, ("D7",), AGREES),
        ("counted_blocks", True, ("D7",), DIFFERS),
        ("max_block", {"23": 33}, ("23",), SHOWS),
        ("max_list_71", 3, ("D11",), SHOWS),
        ("bad_write", "01", ("D17",), AGREES),
        ("bad_write", "silent", ("D17",), DIFFERS),
        ("checksum_accepted", "stuffed", ("D3",), AGREES),
        ("checksum_accepted", "raw", ("D3",), DIFFERS),
        ("checksum_sent", "raw", ("D3",), SHOWS),
        ("stream_end", "break", ("D12",), SHOWS),
        ("stream_load", {"load": 0.4}, ("D16",), SHOWS),
        ("strokes", {"7F": 0.5, "80": None, "81": 0.42}, ("D15",), AGREES),
        ("strokes", {"7F": 0.5, "80": 1.0}, ("D15",), DIFFERS),
        ("count", 21, ("60",), SHOWS),
        ("faults", [13], ("02",), AGREES),
        ("freq", {"tachometer": None, "raw": 5, "by_hand": None}, ("E1", "FREQ"), AGREES),
        ("uacc_sign", {}, ("E2", "UACC"), AGREES),
        ("uacc_scale", {"formula": "b/10"}, ("E2", "UACC"), AGREES),
        ("uacc_scale", {"formula": "5.2+b/20"}, ("E2", "UACC"), DIFFERS),
        ("tair", 1, ("E4", "TAIR"), AGREES),
        ("tair", 2, ("E4", "TAIR"), DIFFERS),
        ("valf", {"raw": 128}, ("VALF",), AGREES),
    ],
)  # fmt: skip
def test_a_value_agrees_differs_or_settles(question, value, of, agreement):
    ((names, found, *_),) = judged(question, value)
    assert (names, found) == (of, agreement)
    assert all(evidence().basis_of(name) for name in names)


def test_commands_and_passports_are_judged_code_by_code():
    both = {"supported": ["01", "61"], "missing": ["71"]}
    assert [it[:2] for it in judged("commands", both)] == [
        (("01", "61"), AGREES), (("71",), DIFFERS),
    ]  # fmt: skip
    assert [it[:2] for it in judged("commands", {"supported": ["01"], "missing": []})] == [
        (("01",), AGREES)
    ]
    assert [it[:2] for it in judged("passports", {"51": 16, "52": 12, "53": None, "54": 16})] == [
        (("52",), DIFFERS), (("51", "54"), AGREES),
    ]  # fmt: skip


def test_a_fault_without_a_text_is_named():
    _, unknown = judged("faults", [13, 99, 250])
    assert unknown[:2] == (("02",), SHOWS)
    assert unknown.text.en == "faults without a text here: 99, 250"


def test_the_codes_of_a_unit_are_compared_with_section_4():
    sizes = {code: size for code, size in SIZES.items() if code != "5B"}
    sizes |= {"1A": 2, "33": 1, "34": 1, "35": 2}
    fits, other, absent, beyond = judged("codes", {"sizes": sizes, "unclear": ["5C"]})
    assert "TWATI" in fits.of
    assert not {"TWAT", "SSM"} & set(fits.of)
    assert (fits.agreement, other.of, other.agreement) == (AGREES, ("TWAT",), DIFFERS)
    assert other.text.en == "61 gives bytes of it: 2"
    assert (absent.of, absent.agreement) == (("SSM",), SHOWS)
    assert (beyond.of, beyond.text.en) == (("61",), "codes beyond §4, by bytes: 1: 33 34; 2: 35")
    del sizes["5C"]
    (_, _, absent, _) = judged("codes", {"sizes": sizes, "unclear": ["5C"]})
    assert absent.of == ("SSM",), "an unclear code is not absent"


def test_a_unit_that_gives_no_code_says_nothing():
    assert judged("codes", {"sizes": {}, "unclear": []}) == []
    assert [it.of for it in judged("codes", {"sizes": SIZES, "unclear": []})] == [
        tuple(each.name for each in shipped().parameters)
    ]


def after(question, value):
    """Returns the catalog after the amendments of an answer."""
    found = [
        Amendment(it.of, it.agreement, it.text or Text("seen", "видели"), it.changes)
        for it in judged(question, value)
    ]
    texts = changed_files(found, "0A, survey 3f2a90c1")
    return load_changed({name: text for name, text in texts.items() if name != "evidence.toml"})


@pytest.mark.parametrize("raw", range(108, 149, 10))
def test_neutral_bytes_at_warm_idle_propose_family_for_rcok_and_alternative_for_rcod(raw):
    value = {code: {"raw": raw, "neutral": True} for code in ("42", "41")}
    assert [it[:2] for it in judged("fuel_factors", value)] == [
        (("RCOK", "E3"), DIFFERS), (("RCOD", "E3"), DIFFERS),
    ]  # fmt: skip
    catalog, before = after("fuel_factors", value), shipped()
    for each in range(256):
        data = bytes([each])
        rcok, rcod = (catalog.parameter(name) for name in ("RCOK", "RCOD"))
        assert rcok.decode(data) == rcok.decode(data, "family") == (each + 128) / 256
        assert rcod.decode(data) == rcod.decode(data, "alternative") == (each - 128) / 256
        for parameter in (rcok, rcod):
            letter = before.parameter(parameter.name).decode(data)
            assert parameter.decode(data, "literal") == letter
        assert rcok.decode(data, "alternative") == (each - 128) / 256
    erratum = catalog.errata["E3"]
    assert erratum.default.en == "RCOK: (b + 128)/256. RCOD: (b − 128)/256."
    assert (erratum.selected_by, erratum.alternative.ru) == (
        "literal", "Буква источника: (b − 128)/256 − 0,5.",
    )  # fmt: skip


def test_one_neutral_byte_changes_that_parameter_alone():
    value = {"42": {"raw": 60, "neutral": False}, "41": {"raw": 128, "neutral": True}}
    (rcod,) = judged("fuel_factors", value)
    assert rcod.of == ("RCOD", "E3")
    assert rcod.text.en == (
        "raw 80 at warm idle, where little is corrected: literal −0.500, alternative 0.000"
    )
    catalog = after("fuel_factors", value)
    assert catalog.parameter("RCOK") == shipped().parameter("RCOK")
    assert catalog.parameter("RCOD").decode(b"\x80") == 0
    assert catalog.errata["E3"].default.ru == ("RCOK: (b − 128)/256 − 0,5. RCOD: (b − 128)/256.")


def test_bytes_that_are_neutral_by_the_letter_confirm_it():
    value = {code: {"raw": 250, "neutral": False} for code in ("42", "41")}
    assert [(it.of[0], it.agreement, it.changes) for it in judged("fuel_factors", value)] == [
        ("RCOK", AGREES, ()), ("RCOD", AGREES, ()),
    ]  # fmt: skip
    assert judged("fuel_factors", {"42": {"raw": 230, "neutral": False}}) == []


def test_a_voltmeter_confirms_uacc_or_changes_its_formula():
    assert after("uacc_scale", {"formula": "b/10"}).parameter("UACC").confidence == "confirmed"
    changed = after("uacc_scale", {"formula": "5.2+b/20"})
    uacc = changed.parameter("UACC")
    assert uacc.decode(bytes([136])) == 12.0
    assert uacc.decode(bytes([136]), "literal") == -12.0
    assert uacc.confidence == "reported"
    assert changed.errata["E2"].default.ru.startswith("b/20 + 5,2")


@pytest.mark.parametrize(
    ("tachometer", "by_hand", "confidence"),
    [(850.0, None, "confirmed"), (None, 210, "confirmed"), (None, None, "reported")],
)
def test_the_starter_alone_confirms_no_factor_of_freq(tachometer, by_hand, confidence):
    value = {"unit": "min-1", "tachometer": tachometer, "raw": 21, "by_hand": by_hand}
    assert after("freq", value).parameter("FREQ").confidence == confidence
