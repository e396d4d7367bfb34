"""Advice in two wordings: for a terminal, and for the dashboard, which has no commands to type."""

from __future__ import annotations

import inspect
import re

import pytest

from mikas import errors
from mikas.errors import LineNotQuiet, MikasError, NoPortGiven, PortNotFound, UnknownParameter
from mikas.i18n import Text

_TERMINAL = re.compile(r"`mikas |`?--[a-z]|run the command|повторите команду|replay:FILE\?")
CLASSES = [
    it for _, it in inspect.getmembers(errors, inspect.isclass) if issubclass(it, MikasError)
]


@pytest.mark.parametrize("kind", CLASSES)
def test_the_dashboard_names_nothing_to_type(kind) -> None:
    advice = kind.advice_on_screen or kind.advice
    for language in advice:
        assert not _TERMINAL.search(language), language


def test_the_terminal_keeps_its_words() -> None:
    assert "`mikas ports`" in PortNotFound(url="x", found="none").text.en


def test_both_paragraphs_tell_the_same_failure() -> None:
    error = NoPortGiven(found=Text("nothing", "ничего"), request=b"\x02", received=b"")
    assert error.gui_text.en.startswith(error.reason.en + " (sent 02, received nothing). ")
    assert "Cable screen" in error.gui_text.en
    assert "«Связь»" in error.gui_text.ru


def test_other_advice_is_shown_everywhere() -> None:
    other = Text("Do that.", "Сделайте это.")
    assert PortNotFound(url="x", found="", advice=other).gui_advice == other
    error = PortNotFound(url="x", found="")
    error.advice = other
    assert error.gui_text.en.endswith("Do that.")
    assert LineNotQuiet().gui_advice == LineNotQuiet.advice


def test_the_nearest_names_are_told_on_both() -> None:
    error = UnknownParameter("TWTA", ["TWAT"])
    assert "Did you mean TWAT?" in error.text.en
    assert "Did you mean TWAT?" in error.gui_text.en
    assert "Может быть" not in UnknownParameter("X").gui_text.ru
