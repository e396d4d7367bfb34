"""`mikas sim --replay` and `--port replay:`: what a person types."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import pytest

from mikas.cli.commands import sim
from mikas.cli.main import run
from mikas.cli.run import Run


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

    def keep(of_run, bus, clock, tcp):
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
    assert served.bus.disturbance.rates
    assert "damaged" not in capsys.readouterr().err
    whole = capture.read_bytes()
    middle = len(whole) // 2
    capture.write_bytes(whole[:middle] + bytes(40) + whole[middle + 40 :])
    assert run(["sim", "--replay", str(capture)]) == 0
    assert "damaged part(s) passed over" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "reason"),
    [
        (["--scenario", "city"], "--scenario and --replay exclude each other"),
        (["--model", "5.4"], "--model and --replay"),
        (["--faults", "13"], "--faults and --replay"),
        (["--set", "sped=2"], "there is speed"),
        (["--set", "seek=9999"], "behind the end"),
    ],
)
def test_what_contradicts_itself_is_refused(capture, served, capsys, words, reason):
    assert run(["sim", "--replay", str(capture), *words]) == 2
    assert reason in capsys.readouterr().err
    assert served.bus is None


def test_a_file_that_is_no_recording(capture, capsys, tmp_path):
    (tmp_path / "notes.txt").write_text("hello")
    assert run(["sim", "--replay", str(tmp_path / "notes.txt")]) == 2
    assert "not a capture" in capsys.readouterr().err
    assert run(["sim", "--replay", str(tmp_path / "nowhere")]) == 2
    assert run(["read", "FREQ", "--port", f"replay:{tmp_path / 'nowhere'}"]) == 2


def test_a_recording_as_a_port(capture, capsys):
    capsys.readouterr()
    port = f"replay:{capture}?clock=simulated"
    assert run(["read", "FREQ", "TWAT", "--json", "--port", port]) == 0
    assert '"FREQ"' in capsys.readouterr().out
    assert Path(capture).exists()
    assert Run().port is None
