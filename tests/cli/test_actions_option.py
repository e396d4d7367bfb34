"""`--actions FILE.toml`: marks, the end of a recording, the bell; mistakes before the port."""

from __future__ import annotations

import io
import sys

import pytest
from cli_harness import is_russian

import mikas as library
from mikas.cli.render import terminal
from mikas.sampling.events import Marker

HOT = """
[action.runs]
when = "FREQ > 100"
for = 1
mark = "engine runs at {FREQ}"
sound = true
"""


@pytest.fixture
def actions(tmp_path):
    def write(text):
        (tmp_path / "actions.toml").write_text(text, "utf-8")
        return ("--actions", "actions.toml")

    return write


def test_log_marks_the_moment_in_the_recording(mikas, tmp_path, actions):
    ran = mikas("log", "-o", "a.pcapng", "TWAT", "--duration", "4", *actions(HOT))
    assert ran.status == 0
    assert "◆ runs: FREQ > 100, for 1." in ran.err
    recording = library.open(tmp_path / "a.pcapng")
    (marker,) = [event for event in recording.events if isinstance(event, Marker)]
    assert marker.label.startswith("engine runs at 8")
    assert "FREQ" in recording.to_pandas().columns  # sampled for the condition alone


def test_an_action_ends_the_recording(mikas, tmp_path, actions):
    rule = '[action.enough]\nwhen = "FREQ > 100"\nfor = 2\nrecord = "stop"\n'
    ran = mikas("log", "-o", "a.pcapng", "FREQ", "--duration", "600", *actions(rule))
    assert ran.status == 0
    assert "An action ends the recording." in ran.err
    times = library.open(tmp_path / "a.pcapng").to_pandas().index
    assert 2 <= times[-1] - times[0] < 10


def test_watch_shows_the_moment_and_says_what_it_can_not_do(mikas, actions):
    ran = mikas("--lang", "ru", "watch", "FREQ", "--duration", "3", *actions(HOT))
    assert ran.status == 0
    assert "Действие runs: эта команда не выполняет mark." in ran.err
    assert "◆ runs: FREQ > 100, уже 1," in ran.err
    is_russian(ran.err, names=("runs", "mark"))


def test_a_capture_of_watch_has_the_marker(mikas, tmp_path, actions):
    options = ("--duration", "3", "--capture", "w.pcapng", *actions(HOT))
    assert mikas("watch", "FREQ", *options).status == 0
    events = library.open(tmp_path / "w.pcapng").events
    assert any(isinstance(event, Marker) for event in events)


def test_json_lines_stay_as_they_are(mikas, actions):
    ran = mikas("watch", "FREQ", "--duration", "3", "--json", *actions(HOT))
    assert ran.status == 0
    assert all(set(line) == {"schema", "time", "values", "gap"} for line in ran.objects)


@pytest.mark.parametrize("command", [("watch", "FREQ"), ("log", "-o", "a.pcapng")])
def test_a_mistake_names_file_and_line_before_the_port_is_opened(mikas, tmp_path, actions, command):
    options = actions('[action.a]\nwhen = "TWOT > 1"\nsound = true\n')
    ran = mikas(*command, *options, "--port", "/dev/nowhere")
    assert ran.status == 2
    assert "actions.toml:2" in ran.err
    assert not (tmp_path / "a.pcapng").exists()
    assert mikas(*command, "--actions", "none.toml").status == 2


def test_a_webhook_elsewhere_is_refused(mikas, actions):
    rule = '[action.a]\nwhen = "FREQ > 1"\nwebhook = "http://10.1.2.3/"\n'
    ran = mikas("watch", "FREQ", *actions(rule))
    assert ran.status == 2
    assert "10.1.2.3 is not this computer" in ran.err


def test_names_that_are_given_stay_as_they_are_and_nothing_is_read_twice(mikas, actions):
    rule = '[action.a]\nwhen = "FREQ > 100 and TWAT > 1"\nmark = "m"\n'
    ran = mikas("watch", "FREQ/2", "UACC", "--count", "4", "--json", *actions(rule))
    names = {name for line in ran.objects for name in line["values"]}
    assert names == {"FREQ", "UACC", "TWAT"}


class Screen(io.StringIO):
    def isatty(self):
        return True


def test_the_bell_rings_on_a_terminal_only(monkeypatch):
    for stream, heard in ((Screen(), "\a"), (io.StringIO(), "")):
        monkeypatch.setattr(sys, "stderr", stream)
        terminal.ring()
        assert stream.getvalue() == heard
        with terminal.escaping():
            terminal.ring()
        assert stream.getvalue() == heard * 2


def test_a_labelled_meters_channel_is_a_mistake_without_that_meter(mikas, actions):
    options = actions('[action.a]\nwhen = "LAMBDA_LEFT > 1.1 and FREQ > 1"\nsound = true\n')
    for meter in ((), ("--instrument", "right:aem=sim:")):
        ran = mikas("watch", "FREQ", "--duration", "2", *options, *meter)
        assert ran.status == 2
        assert "actions.toml:2" in ran.err
        assert "LAMBDA_LEFT" in ran.err
    left = ("--instrument", "left:aem=sim:")
    assert mikas("watch", "FREQ", "--duration", "2", *options, *left).status == 0
