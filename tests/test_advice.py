"""Advice after an error: true for everybody, and with the words of each user interface."""

from __future__ import annotations

import inspect
import re
import subprocess
import sys

import pytest

from mikas import errors
from mikas.cli.advice import ADVICE as TERMINAL
from mikas.cli.advice import DOCTOR_ADVICE
from mikas.dashboard.errors import ADVICE as DASHBOARD
from mikas.errors import (
    DamagedResponse,
    EngineStopped,
    LineNotQuiet,
    MikasError,
    NoPortGiven,
    PortNotFound,
    UnknownParameter,
)
from mikas.i18n import Text

_TERMINAL = re.compile(r"`mikas |`?--[a-z]|run the command|повторите команду|replay:FILE\?")
_SCREEN = re.compile(r"\bscreen\b|экран")
CLASSES = [
    it for _, it in inspect.getmembers(errors, inspect.isclass) if issubclass(it, MikasError)
]
FIELDS = {
    "url": "x", "found": "none", "file": "f", "problem": "p", "seconds": 1.0, "damage": "d",
    "length": 1, "expected": 2, "got": 1, "asked": 2, "command": "02", "name": "N", "wanted": 1,
    "change": "c", "how": "", "space": "ram", "last": 255, "address": 1, "count": 1, "value": 1,
    "allowed": "a", "place": "p", "feature": "f", "extra": "e", "limit": 0.5, "chip": "CH340",
    "holder": Text("h", "h"), "rate": 98000, "baud": 9600, "most": 960,
    "total": "T", "service": Text("s", "s"), "said": Text("", ""),
}  # fmt: skip


def example(kind: type[MikasError]) -> MikasError:
    if kind in (
        errors.CaptureError, errors.DiskFull, errors.ExportError, errors.FleetError,
        errors.ForeignLogError,
    ):  # fmt: skip
        return kind("f", Text("p", "п"))
    if kind is errors.CatalogError:
        return kind("f", 1, Text("p", "п"))
    if kind is errors.FormulaError:
        return kind(Text("p", "п"))
    if kind is UnknownParameter:
        return UnknownParameter("N", ["M"])
    return kind(**{name: FIELDS[name] for name in kind.field_names() & FIELDS.keys()})


@pytest.mark.parametrize("kind", CLASSES)
def test_an_error_names_no_command_and_no_screen(kind) -> None:
    for language in example(kind).text:
        assert not _TERMINAL.search(language), language
        assert not _SCREEN.search(language), language


@pytest.mark.parametrize("kind", CLASSES)
def test_the_dashboard_names_nothing_to_type(kind) -> None:
    for language in DASHBOARD.text(example(kind)):
        assert not _TERMINAL.search(language), language
        assert "{" not in language


@pytest.mark.parametrize("kind", CLASSES)
def test_the_terminal_names_no_screen(kind) -> None:
    for language in TERMINAL.text(example(kind)):
        assert not _SCREEN.search(language), language
        assert "{" not in language


def test_the_terminal_names_its_commands() -> None:
    assert "`mikas ports`" in TERMINAL.text(PortNotFound(url="x", found="none")).en
    several = NoPortGiven(found="COM3, COM4", example="COM3")
    assert "--port COM3" in TERMINAL.text(several).en
    assert "--port COM3" in TERMINAL.text(several).ru


def test_a_subclass_has_its_own_advice_or_that_of_its_base() -> None:
    assert "`mikas doctor`" in TERMINAL.advice(DamagedResponse(damage="d")).en
    assert TERMINAL.advice(EngineStopped(seconds=2)) == EngineStopped.advice
    assert TERMINAL.advice(LineNotQuiet()) == LineNotQuiet.advice


def test_a_running_doctor_is_not_advised() -> None:
    assert "mikas doctor" not in DOCTOR_ADVICE.text(DamagedResponse(damage="d")).en
    assert "`mikas ports`" in DOCTOR_ADVICE.text(PortNotFound(url="x", found="none")).en


def test_both_paragraphs_tell_the_same_failure() -> None:
    error = NoPortGiven(found=Text("nothing", "ничего"), request=b"\x02", received=b"")
    text = DASHBOARD.text(error)
    assert text.en.startswith(error.reason.en + " (sent 02, received nothing). ")
    assert "Connection screen" in text.en
    assert "«Связь»" in text.ru


def test_other_advice_is_shown_everywhere() -> None:
    other = Text("Do that.", "Сделайте это.")
    assert DASHBOARD.advice(PortNotFound(url="x", found="", advice=other)) == other
    error = PortNotFound(url="x", found="")
    error.advice = other
    assert DASHBOARD.text(error).en.endswith("Do that.")
    assert TERMINAL.text(error).en.endswith("Do that.")
    assert DASHBOARD.advice(LineNotQuiet()) == LineNotQuiet.advice


def test_both_name_the_nearest_names() -> None:
    error = UnknownParameter("TWTA", ["TWAT"])
    assert "Did you mean TWAT?" in TERMINAL.text(error).en
    assert "Did you mean TWAT?" in DASHBOARD.text(error).en
    assert "Может быть" not in DASHBOARD.text(UnknownParameter("X")).ru


def test_a_program_in_one_folder_is_told_to_be_installed_with_python() -> None:
    """pip can't add anything to what PyInstaller has built (`sys.frozen`)."""
    code = """
import sys
sys.frozen = True
from mikas.errors import MissingExtra
for text in MissingExtra(feature="Dask", extra="dask").text:
    print(text)
"""
    said = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, encoding="utf-8", check=True
    ).stdout
    assert said.count('pipx install "mikas[dask]"') == 2
    assert "pip install" not in said.replace("pipx install", "")
