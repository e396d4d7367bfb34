"""Nothing that a file, a unit or a device calls itself steers the terminal: one place writes."""

from __future__ import annotations

import ast
import io
import json
import logging
import re
import threading
import unicodedata
from pathlib import Path

import click
import pytest
from hypothesis import given
from hypothesis import strategies as st

import mikas
from mikas.cleaning import secrets_of, without
from mikas.cli.render import output, terminal
from mikas.cli.render.output import Output, StatusLine

# No half of a pair: pytest's workers can't send the log of it.
EVIL = "\x1b]52;c;QQ==\x07\x9b2J\x1b[2J\u202e\r\x08\x7fX"
ESCAPED = r"\x1b]52;c;QQ==\x07\x9b2J\x1b[2J\u202e\x0d\x08\x7fX"
any_text = st.text(st.characters(exclude_categories=()))
SOURCE = Path(mikas.__file__).parent


class Terminal(io.StringIO):
    encoding = "utf-8"

    def isatty(self):
        return True


WRITES = re.compile(
    r"sys\.(__)?std(out|err)(__)?|click\.(s?echo|secho|prompt|confirm|echo_via_pager)"
    r"|traceback\.print_\w+|logging\.(StreamHandler|basicConfig)|os\.system"
)
OBEYED = ("Cc", "Cs", "Zl", "Zp")


def steering(text):
    """The characters of `text` that a terminal obeys."""
    controls = {c for c in text if unicodedata.category(c) in OBEYED or c == "\u202e"}
    return controls - {"\n", "\t"}


def test_only_one_module_writes_to_stdout_and_stderr():
    """Others may ask whether a stream is a terminal. `print` is the linter's."""
    found = []
    for path in SOURCE.rglob("*.py"):
        if path == Path(terminal.__file__):
            continue
        text = path.read_text("utf-8")
        if not WRITES.search(text):
            continue
        tree = ast.parse(text)
        asked = {
            id(node.value)
            for node in ast.walk(tree)
            if isinstance(node, ast.Attribute) and node.attr == "isatty"
        }
        for node in ast.walk(tree):
            if isinstance(node, ast.Attribute) and id(node) not in asked:
                found += [f"{path}:{node.lineno}"] if WRITES.fullmatch(ast.unparse(node)) else []
    assert not found


@given(any_text)
def test_what_passes_an_escaping_stream_or_json_steers_nothing(text):
    stream = io.StringIO()
    assert terminal.EscapingStream(stream).write(text) == len(text)
    assert not steering(stream.getvalue())
    line = json.dumps({"a": text}, ensure_ascii=False)
    assert not steering(output.terminal_json(line))
    assert json.loads(output.terminal_json(line)) == json.loads(json.dumps({"a": text}))


@given(any_text, any_text)
def test_a_drawing_library_may_move_and_colour_and_no_more(one, other):
    stream = io.StringIO()
    drawn = f"{one}\x1b[1;31m{other}\x1b[0m\x1b[2K\r\x1b[1A\x1b[?25l\x1b]0;title\x07\x1b[5n\x1bc"
    terminal.drawing_stream(stream).write(drawn)
    rest = re.sub(r"\x1b\[[\d;]*[ABHK]|\x1b\[[\d;]*m|\x1b\[\?25l|\r", "", stream.getvalue())
    assert not steering(rest)


def test_all_ways_to_a_terminal_are_escaped(monkeypatch):
    """Notes, lines, JSON, tables, the redrawn line, the log, tracebacks of threads."""
    out, err = Terminal(), Terminal()
    monkeypatch.setattr("sys.stdout", out)
    monkeypatch.setattr("sys.stderr", err)
    monkeypatch.setattr("threading.excepthook", threading.__excepthook__)
    with terminal.escaping():
        shown = Output()
        shown.line(EVIL)
        shown.print_note(EVIL)
        shown.data({EVIL: EVIL})
        shown.table([EVIL], [[f"{EVIL}\n\tx"]])
        status = StatusLine(shown, lambda: EVIL)
        status.draw(1.0)
        status.print_notice(EVIL)
        with output.log_to_stderr():
            logging.getLogger("mikas.tester").debug("%s", EVIL)

        def fail():
            raise ValueError(EVIL)

        thread = threading.Thread(target=fail)
        thread.start()
        thread.join()
    assert not steering(re.sub(r"\x1b\[(?:\d+;?)*m", "", out.getvalue()))
    assert not steering(err.getvalue().replace(terminal.CLEAR_LINE, ""))
    assert out.getvalue().count(r"\x1b]52") >= 3
    assert err.getvalue().count(ESCAPED) >= 4


def test_the_streams_are_the_old_ones_afterwards(monkeypatch):
    out = Terminal()
    monkeypatch.setattr("sys.stdout", out)
    with terminal.escaping(), terminal.escaping():
        pass
    import sys

    assert sys.stdout is out


@pytest.mark.parametrize("hide", [str, lambda text: without(text, secrets_of("secret"))])
def test_to_click_the_streams_are_of_text(monkeypatch, hide):
    """It wrote `b''` before a help text, and the text as bytes."""
    out, err = io.StringIO(), io.StringIO()
    monkeypatch.setattr("sys.stdout", out)
    monkeypatch.setattr("sys.stderr", err)
    with terminal.escaping(hide):
        click.echo("помощь")
        click.echo("ошибка", err=True)
    assert (out.getvalue(), err.getvalue()) == ("помощь\n", "ошибка\n")
