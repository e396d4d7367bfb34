"""Names of files: what the program makes of any text, and what it takes from a folder."""

from __future__ import annotations

import unicodedata

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mikas.cleaning import clean_line
from mikas.dashboard.library.folder import file_stem, is_file_name

SUFFIX = ".pcapng"
PARTS = st.sampled_from(
    [*"aZ9 ./\\:*?\"<>|-~\0\n\t\x7f\x9b¹²³éж", ".pcapng", "CON", "nul", "COM", "LPT¹", "CONIN$",
     "\ud800", "\u202e", "\u2066", "\u200b", "\u200d", "\ufeff", "\u2028", "e\u0301",
     "😀", "👩\u200d🔧", "\ufffd", "\u3000"]
)  # fmt: skip
DEVICES = {"CON", "PRN", "AUX", "NUL", "CONIN$", "CONOUT$"} | {
    f"{port}{digit}" for port in ("COM", "LPT") for digit in "0123456789¹²³"
}


@pytest.mark.parametrize(
    ("name", "kept"),
    [("../../etc/passwd", "etc passwd"), ("a/b\\c:d", "a b c d"), ("CON", "CON-"), (" . ", ""),
     ("x.pcapng", "x"), ("\x00\n", ""), (None, ""), ("ж" * 300, "ж" * 100), ("😀" * 100, "😀" * 50),
     ("a\u009b2J\u202eb", "a 2J b"), ("COM¹", "COM¹-"), ("NUL.txt", "NUL-.txt"),
     ("con .x", "con- .x"), ("lpt3.pcapng", "lpt3-"), ("..", ""), ("a. .", "a"),
     (".hidden", "hidden"), ("--help", "help"), ("~/x", "x"), ("cafe\u0301", "café"),
     ("\u200b", ""), ("a\u200bb", "ab"), ("\u200d", ""),
     ("COMMON", "COMMON"), ("Drive 5, a-b (2)", "Drive 5, a-b (2)"), ("a-b.c", "a-b.c"),
     ("a\tb\n c", "a b c"), ("\ud800x", "x"), ("Поездка №3", "Поездка №3")],
)  # fmt: skip
def test_a_name_can_not_lead_elsewhere(name: str | None, kept: str) -> None:
    assert file_stem(name, SUFFIX) == kept


@settings(max_examples=100)
@given(st.lists(PARTS, max_size=40).map("".join) | st.text(max_size=300))
def test_any_text_is_a_file_on_every_system_or_nothing(text: str) -> None:
    stem = file_stem(text, SUFFIX)
    if not stem:
        return
    assert stem == stem.strip(" .")
    assert stem[0] not in "-~"
    assert clean_line(stem) == stem == unicodedata.normalize("NFC", stem)
    assert not set(stem) & set('/\\:*?"<>|\0')
    assert stem.partition(".")[0].rstrip().upper() not in DEVICES
    assert len(f"{stem} (99999){SUFFIX}.part".encode()) < 255
    for name in (f"{stem}{SUFFIX}", f"{stem} (2){SUFFIX}"):
        assert is_file_name(name, SUFFIX)
    assert file_stem(f"{stem}{SUFFIX}", SUFFIX) == stem


@pytest.mark.parametrize(
    "name",
    ["a", ".pcapng", ".a.pcapng", "a/b.pcapng", "..\\b.pcapng", "a\x9b.pcapng", "a\u202e.pcapng",
     "a\ud800.pcapng", "a\nb.pcapng", "C:a.pcapng", "a" * 240 + ".pcapng", "\0.pcapng", ""],
)  # fmt: skip
def test_a_name_that_leads_elsewhere_or_can_not_be_a_file_is_refused(name: str) -> None:
    assert not is_file_name(name, SUFFIX)
