"""The words of a flag's lamp, of a value off its reference, and of what to check."""

from __future__ import annotations

import re
from dataclasses import replace

import pytest
from catalog_harness import ALSO_FREE, FREE, Write, assert_refused

from mikas.catalog import Confidence, Lamp, Level, Meaning, load, shipped
from mikas.i18n import Text

FLAG = f'[parameter.F]\ncode = {FREE}\nsize = 1\nmask = 1\ntext = "f"\n'
NUMBER = f'[parameter.N]\ncode = {ALSO_FREE}\nsize = 1\ntext = "n"\n'
LAMP = 'lamp = { on = "yes", off = "no" }\n'


def in_both_languages(text: Text) -> bool:
    return bool(text.en and not re.search("[А-яЁё]", text.en) and re.search("[А-яЁё]", text.ru))


# --- what is shipped


def test_every_flag_has_two_different_texts() -> None:
    for parameter in shipped().parameters:
        assert (parameter.lamp is not None) == parameter.is_flag, parameter.name
        if parameter.lamp:
            assert in_both_languages(parameter.lamp.on)
            assert in_both_languages(parameter.lamp.off)
            assert parameter.lamp.on != parameter.lamp.off


def test_every_reference_says_what_it_means_to_be_off_it() -> None:
    for parameter in shipped().parameters:
        assert (parameter.meaning is None) == (parameter.reference is None), parameter.name
        if parameter.meaning is None:
            continue
        assert parameter.reference is not None
        assert parameter.limits() is not None
        # What can't be lower than its reference needs no word for that.
        possible = parameter.limits()[0] < parameter.reference[0]
        assert in_both_languages(parameter.meaning.low) == possible
        assert in_both_languages(parameter.meaning.high)
        assert parameter.meaning.confidence is Confidence.UNCONFIRMED
        assert parameter.meaning.source == "own knowledge"


def test_what_to_check_is_never_surer_than_we_are() -> None:
    for fault in shipped().faults.values():
        assert fault.check_confidence is Confidence.UNCONFIRMED


# --- a person's own


def test_a_text_with_controls_is_cleaned(write: Write) -> None:
    text = r'"a\u001b]52;c;QQ==\u0007 \u202e\u009b"'
    entry = f"[parameter.F]\ncode = 0x33\nsize = 1\nunit = {text}\ntext = {text}\nerrata = []\n"
    parameter = load(write(entry)).parameter("F")
    for words in (*parameter.text, parameter.unit):
        assert words == "a\ufffd]52;c;QQ==\ufffd \ufffd\ufffd"


def test_a_lamp_is_added_and_changed_word_by_word(write: Write) -> None:
    catalog = load(write(FLAG + LAMP), write('[parameter.RXX]\nlamp.on.ru = "ХХ"\n'))
    assert catalog.parameter("F").lamp == Lamp(on=Text("yes", "yes"), off=Text("no", "no"))
    before = shipped().parameter("RXX").lamp
    assert before is not None
    bad = load(write('[parameter.RXX]\nlamp.trouble = "danger"\n')).parameter("RXX").lamp
    assert bad == replace(before, trouble=Level.DANGER)
    assert catalog.parameter("RXX").lamp == Lamp(Text(before.on.en, "ХХ"), before.off)


def test_a_meaning_is_added_and_changed_with_its_source(write: Write) -> None:
    catalog = load(
        write(NUMBER + '[parameter.N.meaning]\nlow = "check it"\nconfidence = "reported"\n'),
        write('[parameter.TWAT.meaning]\nhigh = "hot"\nsource = "me"\n'),
    )
    own = Meaning(Text("check it", "check it"), Text("", ""), "own1.toml", Confidence.REPORTED)
    assert catalog.parameter("N").meaning == own
    changed, before = catalog.parameter("TWAT").meaning, shipped().parameter("TWAT").meaning
    assert changed is not None
    assert before is not None
    assert (changed.high, changed.low, changed.source) == (Text("hot", "hot"), before.low, "me")
    unnamed = load(write('[parameter.TWAT.meaning]\nlow.en = "cold"\n')).parameter("TWAT").meaning
    assert unnamed == Meaning(
        Text("cold", before.low.ru), before.high, "own3.toml", Confidence.UNCONFIRMED
    )


def test_no_words_are_none(write: Write) -> None:
    catalog = load(write(FLAG + NUMBER + '[fault.99]\ntext = "f"\n'))
    assert catalog.parameter("F").lamp is None
    assert catalog.parameter("N").meaning is None
    assert catalog.fault(99).check_confidence is Confidence.UNKNOWN
    assert catalog.fault(98).check_confidence is Confidence.UNKNOWN


def test_what_to_check_has_its_own_confidence(write: Write) -> None:
    fault = load(write('[fault.13]\ncheck_confidence = "confirmed"\n')).fault(13)
    assert (fault.check_confidence, fault.confidence) == (
        Confidence.CONFIRMED,
        Confidence.REPORTED,
    )


def test_a_number_made_of_a_flag_has_no_lamp_any_more(write: Write) -> None:
    catalog = load(write(FLAG + LAMP), write("[parameter.F]\nmask = 0\n"))
    assert catalog.parameter("F").lamp is None
    assert not catalog.parameter("F").is_flag


def test_a_flag_made_of_a_number_has_no_meaning_any_more(write: Write) -> None:
    numbered = write(NUMBER + 'meaning = { low = "l" }\n')
    assert load(numbered, write("[parameter.N]\nmask = 1\n")).parameter("N").meaning is None


@pytest.mark.parametrize(
    ("text", "line", "problem"),
    [
        (NUMBER + LAMP, 5, "`parameter.N.lamp` makes sense for a flag only"),
        (FLAG + 'meaning.low = "l"\n', 6, "`parameter.F.meaning` makes no sense for a flag"),
        (FLAG + 'lamp = { on = "yes" }\n', 6, "`parameter.F.lamp` has no `off`"),
        (FLAG + 'lamp.on = "yes"\nlamp.off.en = "no"\n', 7, "`parameter.F.lamp.off` has no `ru`"),
        (NUMBER + 'meaning.low.ru = "l"\n', 5, "`parameter.N.meaning.low` has no `en`"),
        (NUMBER + 'meaning.lower = "l"\n', 5, "unknown key `lower`; the nearest is `low`"),
        (NUMBER + 'meaning.confidence = "sure"\n', 5, "must be one of"),
        ('[fault.99]\ntext = "f"\ncheck_confidence = 1\n', 3, "must be one of"),
    ],
)
def test_a_wrong_text_is_refused_with_its_line(
    write: Write, text: str, line: int, problem: str
) -> None:
    assert_refused(write(text), line, problem)
