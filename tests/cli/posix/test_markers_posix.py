"""Markers from a terminal: lines typed while it is recorded; what follows is the shell's."""

from __future__ import annotations

import os
import pty
import select
import signal
import termios
import threading
from contextlib import contextmanager

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mikas.cli.markers import Marking, TypedLine
from mikas.link.base import Direction
from mikas.recording import CaptureReader
from mikas.recording.recorder import Recorder

pytestmark = pytest.mark.realtime

PATIENCE = 20


@contextmanager
def terminal():
    """What is behind a terminal, and what a program gets."""
    behind, front = pty.openpty()
    try:
        yield behind, front
    finally:
        os.close(behind)
        os.close(front)


@pytest.fixture
def recorder(tmp_path):
    recorder = Recorder()
    recorder.start(tmp_path / "a.pcapng", url="sim:")
    recorder.record(Direction.SENT, b"\x01\xff\x0d", 1.0)
    yield recorder
    recorder.stop()


class Told:
    """The sentences, and a way to wait for one."""

    def __init__(self) -> None:
        self.sentences: list[str] = []
        self.news = threading.Event()

    def __call__(self, sentence: str) -> None:
        self.sentences.append(sentence)
        self.news.set()


def waits_in(front: int) -> bytes:
    """What a shell would find there."""
    return os.read(front, 100) if select.select([front], [], [], PATIENCE)[0] else b""


@contextmanager
def marking(recorder: Recorder, front: int, on_typing=None):
    reported = Told()
    with Marking(recorder, reported, on_typing) as listening:
        listening.listen(front)
        yield reported


def test_a_line_is_a_marker_and_what_is_typed_after_the_end_is_not_ours(recorder):
    with terminal() as (behind, front):
        with marking(recorder, front) as reported:
            os.write(behind, "горка\n".encode())
            assert reported.news.wait(PATIENCE)
        os.write(behind, b"ls -l\n")
        assert waits_in(front) == b"ls -l\n"
    assert len(reported.sentences) == 1
    assert "горка" in reported.sentences[0]


def test_what_is_typed_after_ctrl_c_is_not_ours_while_the_recording_is_still_being_ended(recorder):
    with terminal() as (behind, front):
        with marking(recorder, front) as reported:
            with pytest.raises(KeyboardInterrupt):
                signal.raise_signal(signal.SIGINT)
            # A stream is being ended now, which may take a second.
            os.write(behind, b"ls -l\n")
            assert waits_in(front) == b"ls -l\n"
        assert not reported.sentences


def test_another_signal_does_not_end_it(recorder):
    was = signal.signal(signal.SIGUSR1, lambda *_: None)
    try:
        with terminal() as (behind, front), marking(recorder, front) as reported:
            os.kill(os.getpid(), signal.SIGUSR1)
            os.write(behind, b"\n")
            assert reported.news.wait(PATIENCE)
    finally:
        signal.signal(signal.SIGUSR1, was)
    assert len(reported.sentences) == 1


def test_a_terminal_that_goes_away_ends_the_listening_and_nothing_else(recorder):
    behind, front = pty.openpty()
    try:
        with marking(recorder, front) as reported:
            os.close(behind)
        assert not reported.sentences
    finally:
        os.close(front)
    assert signal.set_wakeup_fd(-1) == -1


def test_markers_are_in_the_recording(tmp_path, recorder):
    with terminal() as (behind, front), marking(recorder, front) as reported:
        os.write(behind, b"hill\n")
        assert reported.news.wait(PATIENCE)
    recorder.stop()
    labels = [n.data["label"] for n in CaptureReader(tmp_path / "a.pcapng").notes()
              if n.kind == "marker"]  # fmt: skip
    assert "hill" in labels


def echoes(front: int) -> bool:
    return bool(termios.tcgetattr(front)[3] & termios.ECHO)


def test_what_is_typed_stands_in_the_status_line_and_not_behind_it(recorder):
    typed: list[str] = []
    shown = threading.Event()

    def on_typing(text: str) -> None:
        typed.append(text)
        shown.set()

    with terminal() as (behind, front):
        with marking(recorder, front, on_typing) as reported:
            while echoes(front):  # until the thread listens
                assert not reported.sentences
            os.write(behind, b"hil")
            assert shown.wait(PATIENCE)
            assert typed[-1]
            assert "hil".startswith(typed[-1])
            modes = termios.tcgetattr(front)
            modes[3] |= termios.ECHO | termios.ICANON
            termios.tcsetattr(front, termios.TCSANOW, modes)  # a shell, after Ctrl-Z
            signal.raise_signal(signal.SIGCONT)
            while echoes(front):
                assert not reported.sentences
            os.write(behind, b"k\x7fl\n")
            assert reported.news.wait(PATIENCE)
        assert echoes(front), "the shell's terminal is as it was"
        assert not select.select([behind], [], [], 0)[0], "the terminal has written nothing itself"
    assert typed[-1] == ""
    assert "“hill”" in reported.sentences[0] or "«hill»" in reported.sentences[0]


def lines(data: bytes, *, bits: int) -> tuple[list[str], str]:
    line = TypedLine()
    parts = (data[at : at + bits] for at in range(0, len(data), bits))
    return [label for part in parts for label in line.feed(part)], line.text


def test_keys_edit_the_line_of_a_marker():
    assert lines("горка\x7f\x7fб\r".encode(), bits=1) == (["горб"], "")
    assert lines(b"long hill\x17way\n", bits=3) == (["long way"], "")
    assert lines(b"wrong\x15right", bits=100) == ([], "right")
    assert lines(b"a\x1b[Db\x1bOP\x1b[1;5Cc\x1bx\x04\n", bits=2) == (["abc"], "")


@given(st.binary(max_size=60), st.integers(1, 60))
def test_any_bytes_in_any_parts_are_the_same_clean_lines(data: bytes, bits: int):
    whole = lines(data, bits=1000)
    assert lines(data, bits=bits) == whole
    assert all(text.isprintable() for text in (*whole[0], whole[1]))
