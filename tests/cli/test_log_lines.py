"""The log on stderr, for `-vv`."""

from __future__ import annotations

import io
import logging
import sys

import pytest

from mikas.cli.render.output import log_to_stderr


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


@pytest.mark.parametrize(("stream", "start"), [(io.StringIO, ""), (Terminal, "\r\x1b[K")])
def test_a_record_is_a_line_and_clears_the_progress_before_it(monkeypatch, stream, start):
    written = stream()
    monkeypatch.setattr(sys, "stderr", written)
    with log_to_stderr():
        logging.getLogger("mikas.tester").debug("%s %s", ">", "02 FD 0D")
    line = written.getvalue()
    assert line.startswith(start)
    assert line.endswith(" mikas.tester: > 02 FD 0D\n")


def test_afterwards_the_library_is_silent_again(capsys):
    with log_to_stderr():
        pass
    logging.getLogger("mikas.tester").debug("frame")
    assert capsys.readouterr().err == ""
    assert not logging.getLogger("mikas.tester").isEnabledFor(logging.DEBUG)


def test_a_closed_stderr_ends_nothing(monkeypatch):
    closed = io.StringIO()
    closed.close()
    monkeypatch.setattr(sys, "stderr", closed)
    monkeypatch.setattr(logging, "raiseExceptions", False)
    with log_to_stderr():
        logging.getLogger("mikas.tester").debug("frame")


def test_vv_shows_frames_and_states(mikas):
    err = mikas("-vv", "watch", "TWAT", "--count", "3", "--method", "batch").err
    assert "mikas.tester: > 61 1A 85 0D" in err
    assert "mikas.sampling: " in err
    assert "mikas.tester" not in mikas("-v", "read", "TWAT").err
