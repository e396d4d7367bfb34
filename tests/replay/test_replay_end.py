"""A recording played to its end is reported as such, without a wait for the ignition."""

from __future__ import annotations

from contextlib import closing

import pytest
from replay_harness import again, begun, do, session, sim

from mikas.catalog import shipped
from mikas.cli.language import set_language
from mikas.cli.main import run
from mikas.client.connecting import ConnectionOptions
from mikas.errors import EchoOnly, RecordingOver
from mikas.link import open_link
from mikas.link.reconnecting import ReconnectingPort
from mikas.link.virtual import VirtualLink
from mikas.recording import CaptureReader
from mikas.recording.recording import Recording
from mikas.replay import load, playing, replay_bus
from mikas.sampling.acquisition import Acquisition
from mikas.sampling.events import CycleFailed, Sampled, StateChanged


@pytest.fixture
def drive(tmp_path):
    path = tmp_path / "drive.pcapng"
    with session(sim(scenario="city"), tmp_path, path) as ecu:
        do(ecu, [("batch", ["TWAT", "FREQ"], 100, 0)])
    return path


@pytest.fixture
def mikas(tmp_path, monkeypatch, capsys):
    """A command line; status, stdout, stderr."""
    for name in ("HOME", "XDG_CONFIG_HOME", "XDG_STATE_HOME", "APPDATA", "LOCALAPPDATA"):
        monkeypatch.setenv(name, str(tmp_path))
    monkeypatch.setenv("MIKAS_LANG", "en")
    monkeypatch.chdir(tmp_path)

    def ran(*argv: str) -> tuple[int, str, str]:
        capsys.readouterr()
        status = run(list(argv))
        return (status, *capsys.readouterr())

    yield ran
    set_language("en")


def test_the_port_says_that_the_recording_is_over(drive):
    with open_link(again(drive)) as link:
        link.write(b"\x01\xff\x0d")  # it begins with the first request
        end = link.now() + load(drive).duration
        while link.now() < end:
            link.read(end)
        with pytest.raises(RecordingOver) as raised:
            link.read(end + 1)
        assert raised.value.fields["file"] == str(drive)
        assert "drive.pcapng is over" in str(raised.value)
        with pytest.raises(RecordingOver):
            link.write(b"\x01\xff\x0d")
        car = playing(link)
        assert car.position() == car.duration
        car.seek(0.0)
        link.write(b"\x01\xff\x0d")
        assert link.read(link.now() + 1).data


@pytest.mark.parametrize("setting", [{"loop": 1}, {"speed": 0}])
def test_one_that_goes_round_or_is_held_is_never_over(drive, setting, tmp_path):
    with session(again(drive, **setting), tmp_path) as ecu:
        ecu.tester.wait(ecu.tester.link.now() + 10 * load(drive).duration)
        assert ecu.read("TWAT")


def test_in_real_time_too_reading_on_says_that_the_recording_is_over(drive):
    seek = load(drive).duration - 0.02
    with open_link(f"replay:{drive}?seek={seek:.3f}") as link:
        link.write(b"\x01\xff\x0d")
        with pytest.raises(RecordingOver):
            read_on(link)


def read_on(link):
    while True:
        link.read(link.now() + 60)


def test_on_a_wire_it_is_silence_and_nothing_else(drive):
    """What `sim --replay` serves is a wire: it has no words."""
    link = VirtualLink(begun(replay_bus(drive)))
    link.read(load(drive).duration + 1)
    with session_on(link) as ecu, pytest.raises(EchoOnly):
        ecu.tester.connect()


def session_on(link):
    return ConnectionOptions().create_ecu(link)


@pytest.mark.parametrize("method", ["batch", "list", "stream", "auto"])
def test_sampling_ends_with_it(drive, tmp_path, method):
    made = Acquisition(
        ReconnectingPort(again(drive)),
        ConnectionOptions(state=tmp_path).create_ecu,
        shipped(),
        ["TWAT", "FREQ"],
        method=method,
    )
    reported = []
    with closing(made.run()) as events, pytest.raises(RecordingOver):
        reported.extend(events)
    assert [event for event in reported if isinstance(event, Sampled)]
    assert not [event for event in reported if isinstance(event, CycleFailed)]
    assert len([event for event in reported if isinstance(event, StateChanged)]) == 2
    waiting = made.call(lambda ecu: ecu.faults())
    assert isinstance(waiting.exception(0), RecordingOver)


@pytest.mark.parametrize("method", ["batch", "stream", "auto"])
def test_watch_ends_with_it_and_says_so(mikas, drive, method):
    argv = ("watch", "TWAT", "--port", again(drive), "--method", method)
    status, out, err = mikas(*argv, "--json")
    assert status == 0
    assert out.count('"gap": false') == len(out.splitlines()) > 50
    assert err.splitlines() == [f"The recording {drive} is over."]
    status, out, err = mikas(*argv, "--lang", "ru")
    assert (status, err) == (0, f"Запись {drive} закончилась.\n")
    assert "–" not in out


def test_a_count_that_ends_before_it_says_nothing(mikas, drive):
    status, out, err = mikas("watch", "TWAT", "--port", again(drive), "--count", "3", "--json")
    assert (status, len(out.splitlines()), err) == (0, 3, "")


def test_log_ends_with_it_and_its_file_has_no_gap(mikas, drive, tmp_path):
    argv = ("log", "-o", "a.pcapng", "TWAT", "--method", "batch")
    status, _, err = mikas(*argv, "--port", again(drive))
    assert status == 0
    over, last = err.splitlines()
    assert over == f"The recording {drive} is over."
    assert " 0 gaps, 0 line errors" in last
    file = tmp_path / "a.pcapng"
    assert not [note for note in CaptureReader(file).notes() if note.kind == "gap"]
    assert sum(len(rows.times) for rows in Recording(file, shipped()).rows()) > 50


@pytest.mark.parametrize("name", ["watch", "log"])
def test_a_recording_that_ends_before_the_first_byte_is_an_error(mikas, drive, tmp_path, name):
    seek = load(drive).duration - 0.001
    argv = (name, *(("-o", "a.pcapng") if name == "log" else ()), "TWAT")
    status, out, err = mikas(*argv, "--port", again(drive, seek=f"{seek:.4f}"))
    assert (status, out) == (3, "")
    assert "is over" in err
    assert "seek" in err
    assert not (tmp_path / "a.pcapng").exists()


def test_the_ignition_that_was_off_in_the_middle_of_it_is_still_waited_out(mikas, tmp_path):
    slowly = ("TWAT", "--method", "batch", "--rate", "4")
    log = ("log", "-o", "key.pcapng", *slowly, "--duration", "50")
    assert mikas(*log, "--port", sim(scenario="key-off"))[0] == 0
    port = again(tmp_path / "key.pcapng")
    status, _, err = mikas("watch", *slowly, "--port", port, "--json")
    assert status == 0
    off, back, over = err.splitlines()
    assert "ignition off?" in off
    assert back.startswith("Back after 1")
    assert over.endswith("is over.")


def test_a_report_is_of_the_samples_received(mikas, tmp_path):
    assert mikas("log", "-o", "all.pcapng", "--count", "99", "--port", sim())[0] == 0
    argv = ("report", "-o", "a.html", "--duration", "600", "--port", again("all.pcapng"))
    status, _, err = mikas(*argv)
    assert status == 0, err
    assert "The recording all.pcapng is over." in err
    assert (tmp_path / "a.html").exists()
