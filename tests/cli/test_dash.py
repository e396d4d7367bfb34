"""`dash` as it is started: what the terminal says while the page is not looked at yet."""

from __future__ import annotations

import sys

import pytest

from mikas.cli.main import desktop_main, run
from mikas.client.connecting import STATE_VARIABLE
from mikas.dashboard.settings import VirtualCars
from mikas.errors import RecordingOver
from mikas.replay import playing


@pytest.fixture
def started(monkeypatch, tmp_path, capsys):
    """Starts it, without serving; stdout, stderr."""
    for name in ("HOME", "XDG_CONFIG_HOME", "XDG_STATE_HOME", "APPDATA", "LOCALAPPDATA"):
        monkeypatch.setenv(name, str(tmp_path))
    monkeypatch.delenv("MIKAS_PORT", raising=False)
    monkeypatch.setenv("MIKAS_LANG", "en")
    monkeypatch.setattr("mikas.dashboard.server.serve", lambda app, own, *, ready, tls: ready())

    def start(*argv: str) -> tuple[str, str]:
        capsys.readouterr()
        assert run(["dash", "--no-browser", "--record", str(tmp_path), *argv]) == 0
        reported = capsys.readouterr()
        return reported.out, reported.err

    return start


def test_a_missing_port_is_reported_and_waited_for(started):
    out, err = started("--port", "/dev/nosuch7")
    assert len(out.splitlines()) == 1
    assert "There is no port /dev/nosuch7 yet; the page connects as soon as it appears." in err
    assert "Порта /dev/nosuch7 пока нет" in started("--port", "/dev/nosuch7", "--lang", "ru")[1]


@pytest.mark.parametrize("argv", [(), ("--port", "sim:"), ("--port", "socket://127.0.0.1:9")])
def test_other_ports_get_no_notice(started, argv):
    assert started(*argv)[1] == "Ctrl-C ends it.\n"


def test_a_recording_that_is_over_plays_again_when_it_is_connected_to_again(tmp_path):
    file = str(tmp_path / "a.pcapng")
    assert run(["read", "TWAT", "--port", "sim:?clock=simulated", "--capture", file]) == 0
    cars = VirtualCars()
    for _ in range(2):
        with cars.open(f"replay:{file}") as link:
            car = playing(link)
            assert car is not None
            assert car.position(link.now()) == 0
            car.seek(car.duration, link.now())
            with pytest.raises(RecordingOver):
                link.write(b"\x01\xff\x0d")


def test_a_port_that_is_there_needs_no_notice(started, tmp_path):
    (tmp_path / "ttyUSB0").touch()
    assert started("--port", str(tmp_path / "ttyUSB0"))[1] == "Ctrl-C ends it.\n"


def test_it_connects_with_the_options_of_the_command_line(started, monkeypatch):
    apps = []
    monkeypatch.setattr(
        "mikas.dashboard.server.serve", lambda app, own, *, ready, tls: apps.append(app)
    )
    started("--checksum", "raw", "--strict", "--inter-byte", "0.5", "--timeout", "1")
    options = apps[0].state.dashboard.settings.connection
    assert (options.raw_checksum, options.strict) == (True, True)
    assert (options.inter_byte_timeout, options.timeout) == (0.5, 1)


def test_a_damaged_file_of_the_users_is_reported(started, tmp_path, monkeypatch):
    monkeypatch.setenv(STATE_VARIABLE, str(tmp_path / "state"))
    (tmp_path / "state").mkdir()
    (tmp_path / "state" / "presets.json").write_text("[[", "utf-8")
    err = started()[1]
    assert "presets.json: the content is damaged, nothing of it is used" in err
    assert "keeps it as presets.json.broken" in err


def test_without_a_console_the_icon_starts_the_same(monkeypatch):
    """A Windows program without a console has no streams to write to."""
    started = []

    def run(argv):
        sys.stdout.write("unheard")
        sys.stderr.write("unheard")
        started.append(argv)
        sys.stdout.close()
        sys.stderr.close()
        return 0

    monkeypatch.setattr("mikas.cli.main.run", run)
    monkeypatch.setattr("sys.argv", ["mikas-dashboard", "--lan"])
    monkeypatch.setattr("sys.stdout", None)
    monkeypatch.setattr("sys.stderr", None)
    with pytest.raises(SystemExit):
        desktop_main()
    assert started == [["dash", "--desktop", "--lan"]]
