"""Sentences on a terminal: lines of whole words, commands and secrets in one piece."""

from __future__ import annotations

import io
import os

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mikas.cli.render import terminal
from mikas.cli.render.output import Output
from mikas.cli.render.wrapping import NARROWEST, filled, fitted


class Terminal(io.StringIO):
    encoding = "utf-8"

    def isatty(self):
        return True


@pytest.fixture
def narrow(monkeypatch):
    """Makes stderr a terminal of 30 columns."""

    def make():
        stream = Terminal()
        monkeypatch.setattr("sys.stderr", stream)
        monkeypatch.setattr("shutil.get_terminal_size", lambda: os.terminal_size((30, 24)))
        return stream

    return make


@given(st.text(st.sampled_from("ab-—` .")), st.integers(NARROWEST, 40))
def test_the_words_stay_as_they_are_and_a_line_is_within_the_width(text, width):
    lines = filled(text, width)
    assert " ".join(lines).split() == text.split()
    for line in lines:
        assert len(line) <= width or " " not in line.strip() or "`" in line or "—" in line


def test_a_command_in_backticks_and_an_option_are_not_divided():
    lines = filled("A list of all: `mikas params --json`, and --inter-byte", 30)
    assert lines == ["A list of all:", "`mikas params --json`, and", "--inter-byte"]
    assert filled("привет, мир и труд — это май", 20) == ["привет, мир и труд —", "это май"]


def test_lines_that_fit_and_indents_are_kept():
    text = "First\n  a second one that is too wide\n\tlast"
    assert list(fitted(text, 24)) == ["First", "  a second one that is", "  too wide", "\tlast"]


def test_a_note_is_wrapped_on_a_terminal_only(narrow, monkeypatch):
    sentence = "There is no port /dev/ttyUSB0. Is the adapter plugged in?"
    shown = narrow()
    Output().print_note(sentence)
    assert shown.getvalue() == "There is no port /dev/ttyUSB0.\nIs the adapter plugged in?\n"
    plain = io.StringIO()
    monkeypatch.setattr("sys.stderr", plain)
    Output().print_note(sentence)
    assert plain.getvalue() == f"{sentence}\n"


def test_a_secret_is_hidden_before_it_is_divided(narrow):
    def hide(text):
        return text.replace("two words of a secret", "…")

    shown = narrow()
    with terminal.escaping(hide):
        terminal.write_note("The broker refused the password two words of a secret.")
    assert "secret" not in shown.getvalue()
    assert "two" not in shown.getvalue()


def test_an_error_is_wrapped_on_a_terminal(narrow, mikas):
    shown = narrow()
    assert mikas("nosuch").status == 2
    lines = shown.getvalue().splitlines()
    assert len(lines) > 3
    assert max(map(len, lines)) <= 30
