"""`mikas sim --replay` and `--port replay:`: what a person types."""

from __future__ import annotations

import json
from pathlib import Path
from types import SimpleNamespace

import pytest

from mikas.cli.commands import sim
from mikas.cli.context import CommandContext
from mikas.cli.main import run
from mikas.recording import CaptureReader
from mikas.recording.capture.reader import Packet


@pytest.fixture
def capture(tmp_path, monkeypatch):
    for name in ("HOME", "XDG_CONFIG_HOME", "XDG_STATE_HOME", "APPDATA", "LOCALAPPDATA"):
        monkeypatch.setenv(name, str(tmp_path))
    monkeypatch.setenv("MIKAS_LANG", "en")
    path = tmp_path / "drive.pcapng"
    url = "sim:?clock=simulated&scenario=city&faults=13"
    words = ["read", "FREQ", "TWAT", "--port", url, "--capture", str(path)]
    assert run(words) == 0
    return path


@pytest.fixture
def served(monkeypatch):
    """What `mikas sim` would serve; nothing is."""
    found = SimpleNamespace(bus=None)

    def keep(of_run, bus, *_):
        found.bus = bus

    monkeypatch.setattr(sim, "_serve", keep)
    monkeypatch.setattr(sim.serve, "run", lambda _: None)
    return found


def test_a_recording_is_served_with_the_other_options(capture, served, capsys):
    words = ["sim", "--replay", str(capture), "--no-echo", "--line-fault", "lost=0.5"]
    assert run([*words, "--set", "seek=0.5", "--set", "speed=3"]) == 0
    car = served.bus.ecu.responder.car
    assert car.codes == (0x29, 0x1A)
    assert (car.position(), car.speed) == (0.5, 3)
    assert served.bus.adapter.kind.echo is False
    assert served.bus.fault_injector.rates
    assert "damaged" not in capsys.readouterr().err
    whole = capture.read_bytes()
    middle = len(whole) // 2
    capture.write_bytes(whole[:middle] + bytes(40) + whole[middle + 40 :])
    assert run(["sim", "--replay", str(capture)]) == 0
    assert "damaged places skipped" in capsys.readouterr().err


@pytest.mark.parametrize("more", [[], ["--json"], ["-v"], ["--lang", "ru"]])
def test_the_end_of_a_served_recording_is_reported_once(capture, served, capsys, more):
    """On the wire it is a silence like that of a key that was turned off."""
    assert run(["sim", "--replay", str(capture), *more]) == 0
    capsys.readouterr()
    served.bus.send(b"\x01\xff\x0d", 1.0)
    served.bus.advance(60.0)
    served.bus.send(b"\x01\xff\x0d", 61.0)
    served.bus.advance(90.0)
    out, err = capsys.readouterr()
    if more == ["--lang", "ru"]:
        assert err.count(f"Запись {capture} закончилась") == 1
        return
    assert err.count(f"The recording {capture} is over") == 1
    assert "loop=1" in err
    assert out.count('"event": "recording-over"') == (more == ["--json"])


def test_a_silence_in_the_middle_is_not_its_end(tmp_path, monkeypatch, served, capsys):
    for name in ("HOME", "XDG_CONFIG_HOME", "XDG_STATE_HOME"):
        monkeypatch.setenv(name, str(tmp_path))
    port = "sim:?clock=simulated&scenario=key-off"
    file = str(tmp_path / "key.pcapng")
    slowly = ["TWAT", "--method", "batch", "--rate", "4", "--duration", "50"]
    assert run(["log", "-o", file, *slowly, "--port", port]) == 0
    assert run(["sim", "--replay", file, "--lang", "en"]) == 0
    capsys.readouterr()
    for time, on in ((1.0, True), (30.0, False), (45.0, True), (90.0, False)):
        served.bus.send(b"\x01\xff\x0d", time)
        served.bus.advance(time + 0.1)
        assert served.bus.ecu.on == on
        assert ("is over" in capsys.readouterr().err) == (time == 90.0)


@pytest.mark.parametrize(
    ("words", "reason"),
    [
        (["--scenario", "city"], "--scenario can't be used with --replay"),
        (["--model", "5.4"], "--model can't be used with --replay"),
        (["--faults", "13"], "--faults can't be used with --replay"),
        (["--set", "sped=2"], "Did you mean speed?"),
        (["--set", "seek=9999"], "behind the end"),
    ],
)
def test_what_contradicts_itself_is_refused(capture, served, capsys, words, reason):
    assert run(["sim", "--replay", str(capture), *words]) == 2
    assert reason in capsys.readouterr().err
    assert served.bus is None


def test_a_file_that_is_no_recording_is_refused(capture, capsys, tmp_path):
    (tmp_path / "notes.txt").write_text("hello")
    assert run(["sim", "--replay", str(tmp_path / "notes.txt")]) == 2
    assert "not a recording" in capsys.readouterr().err
    assert run(["sim", "--replay", str(tmp_path / "nowhere")]) == 2
    assert run(["read", "FREQ", "--port", f"replay:{tmp_path / 'nowhere'}"]) == 2


def test_a_command_that_was_not_recorded_does_not_count_as_refused(capture, capsys):
    assert run(["faults", "--port", f"replay:{capture}?clock=simulated&loop=1"]) == 5
    err = capsys.readouterr().err
    assert "A recording answers only the requests that it contains" in err
    assert "Not every unit has every command" not in err


def test_info_of_a_recording_is_quick_and_says_what_a_recording_cannot_tell(
    capture, capsys, tmp_path
):
    """A unit that is silent to 02 does not know it; the unit of a recording without 02 may."""
    port = f"replay:{capture}?clock=simulated&loop=1"
    capsys.readouterr()
    wire = tmp_path / "wire.pcapng"
    assert run(["info", "--json", "--port", port, "--capture", str(wire)]) == 0
    reported = json.loads(capsys.readouterr().out)
    assert reported["supported"]["CREADP (61)"] is True
    assert [known for known in reported["supported"].values() if known is False] == []
    assert list(reported["supported"].values()).count(None) > 15
    assert reported["program_passport"] == [None] * 3
    packets = [packet for packet in CaptureReader(wire) if isinstance(packet, Packet)]
    assert packets[-1].time - packets[0].time < 1
    assert run(["info", "--port", port]) == 0
    out = capsys.readouterr().out
    assert "not in the recording" in out
    assert "does not know" not in out
    assert run(["info", "--port", port, "--lang", "ru"]) == 0
    assert "в записи нет" in capsys.readouterr().out


def test_info_of_a_recording_names_the_commands_that_its_unit_refused(
    tmp_path, monkeypatch, capsys
):
    for name in ("HOME", "XDG_CONFIG_HOME", "XDG_STATE_HOME"):
        monkeypatch.setenv(name, str(tmp_path))
    file = str(tmp_path / "info.pcapng")
    live = "sim:?clock=simulated&missing=stream,sfr"
    assert run(["info", "--json", "--port", live, "--capture", file]) == 0
    unit = json.loads(capsys.readouterr().out)
    assert run(["info", "--json", "--port", f"replay:{file}?clock=simulated"]) == 0
    replayed = json.loads(capsys.readouterr().out)
    assert replayed["supported"] == unit["supported"]
    assert False in unit["supported"].values()
    assert replayed["program_passport"] == unit["program_passport"]


def test_a_recording_can_be_a_port(capture, capsys):
    capsys.readouterr()
    port = f"replay:{capture}?clock=simulated"
    assert run(["read", "FREQ", "TWAT", "--json", "--port", port]) == 0
    assert '"FREQ"' in capsys.readouterr().out
    assert Path(capture).exists()
    assert CommandContext().port is None
