"""`mikas.cleaning`: text and numbers from files, catalogs, units and other computers."""

import json
import re
import unicodedata
from datetime import UTC, datetime
from math import inf, nan
from xml.etree import ElementTree as ET

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mikas.cleaning import (
    _UNSAFE,
    LATEST,
    clean_json,
    clean_line,
    clean_text,
    is_in_calendar,
    spreadsheet_text,
    terminal_text,
)

any_text = st.text(st.characters(exclude_categories=()))


@given(any_text)
def test_clean_text_fits_utf8_xml_and_a_screen(text: str):
    clean = clean_text(text)
    assert clean.encode() is not None
    ET.fromstring(f"<a>{clean.replace('&', '').replace('<', '')}</a>")
    assert not {c for c in clean if unicodedata.category(c) in ("Cc", "Cs")} - {"\n", "\t"}
    assert clean_text(clean) == clean
    assert len(clean_line(clean).splitlines()) <= 1


@given(any_text)
def test_terminal_text_has_no_control_and_loses_nothing(text: str):
    safe = terminal_text(text)
    assert all(c in "\n\t" or unicodedata.category(c) not in ("Cc", "Cs") for c in safe)
    assert safe.isascii() or safe.encode()
    assert terminal_text(safe) == safe


@pytest.mark.parametrize(
    ("text", "clean", "escaped"),
    [
        ("Волга №7 — 90 °C", "Волга №7 — 90 °C", "Волга №7 — 90 °C"),
        ("a\x1b]52;c;QQ==\x07b", "a\ufffd]52;c;QQ==\ufffdb", "a\\x1b]52;c;QQ==\\x07b"),
        ("1\r\n2\r3", "1\n2\ufffd3", "1\\x0d\n2\\x0d3"),
        ("\x9b2J", "\ufffd2J", "\\x9b2J"),
        ("a\u202egpj.exe", "a\ufffdgpj.exe", "a\\u202egpj.exe"),
        ("\ud800", "\ufffd", "\\ud800"),
    ],
)
def test_known_texts_are_cleaned_and_escaped_as_expected(text: str, clean: str, escaped: str):
    assert clean_text(text) == clean
    assert terminal_text(text) == escaped


def test_what_python_calls_printable_is_safe():
    printable = "".join(filter(str.isprintable, map(chr, range(0x110000))))
    assert not _UNSAFE.search(printable)


def test_limit_counts_characters():
    assert clean_text("abc", 2) == "ab"


@given(st.recursive(st.none() | st.booleans() | st.floats() | st.integers() | any_text,
                    lambda inner: st.lists(inner) | st.dictionaries(any_text, inner)))  # fmt: skip
def test_clean_json_is_json_that_every_reader_takes(value: object):
    try:
        clean = clean_json(value)
    except ValueError:
        return
    json.dumps(clean, allow_nan=False, ensure_ascii=False).encode()


@pytest.mark.parametrize("number", [inf, -inf, nan, 10**30, -(10**30)])
def test_clean_json_refuses(number: float):
    with pytest.raises(ValueError, match=r"number|integer"):
        clean_json({"a": [number]})


def test_the_calendar_goes_from_1970_to_9999():
    assert is_in_calendar(0)
    assert datetime.fromtimestamp(LATEST, UTC).year == 9999
    assert datetime.fromtimestamp(LATEST).astimezone()
    assert not any(map(is_in_calendar, (nan, inf, -1, LATEST + 1, 2.0**64)))


SIGNS = ("=", "+", "-", "@", "＝", "＋", "－", "＠")


@pytest.mark.parametrize("sign", SIGNS)
@pytest.mark.parametrize(
    "before", ["", " ", "\t", "\r", "\n", '"', "'", ' "', "\u200b", "a;", "a\t"]
)
def test_a_text_that_a_spreadsheet_takes_for_a_formula_begins_with_an_apostrophe(
    sign, before
) -> None:
    cell = spreadsheet_text(f"{before}{sign}cmd|' /C calc'!A0")
    assert cell != f"{before}{sign}cmd|' /C calc'!A0"
    for piece in re.split("[;\t\r\n]", cell):
        assert not re.match(rf"[\s\"\u200b]*[{''.join(map(re.escape, SIGNS))}]", piece)


@pytest.mark.parametrize(
    "plain",
    ["-5", "+5,25", "-1.5e-3", "-", "a-b", "Волга = 3110", "ГАЗ-3110", "", "1;-5", "=", " -5 "],
)
def test_a_number_and_a_plain_text_stay_as_they_are_in_a_table(plain) -> None:
    assert spreadsheet_text(plain) == plain
