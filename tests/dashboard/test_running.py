"""Which dashboard runs: found by the next one, and no longer once it has ended."""

from __future__ import annotations

import json
import threading

import pytest

from mikas.dashboard.running import RunningDashboard, starting


@pytest.fixture
def running(shared_off):
    return RunningDashboard(shared_off.port, shared_off.access.instance)


def test_a_running_one_is_found_until_it_ends(running, tmp_path):
    folder = tmp_path / "state"
    assert RunningDashboard.find(folder) is None
    with running.kept(folder):
        assert RunningDashboard.find(folder) == running
        assert running.url == f"http://127.0.0.1:{running.port}/"
        assert (folder / "dashboard.json").stat().st_mode & 0o77 == 0
    assert RunningDashboard.find(folder) is None
    assert not (folder / "dashboard.json").exists()


def test_one_that_was_killed_is_not_found(running, tmp_path):
    # Its port is another program's by now, or silent.
    for left in (RunningDashboard(running.port, "0" * 16), RunningDashboard(1, running.instance)):
        (tmp_path / "dashboard.json").write_text(
            json.dumps({"port": left.port, "instance": left.instance})
        )
        assert RunningDashboard.find(tmp_path) is None


def test_the_file_of_another_one_stays(running, tmp_path):
    with running.kept(tmp_path):
        later = RunningDashboard(running.port, "1" * 16)
        with later.kept(tmp_path):
            pass
        assert not (tmp_path / "dashboard.json").exists()
        with later.kept(tmp_path), running.kept(tmp_path):
            assert RunningDashboard.find(tmp_path) == running


@pytest.mark.parametrize(
    "text", ["", "{", "[]", "null", '{"port": 0, "instance": ""}', '{"port": 99999, "instance": 1}',
             '{"port": "x", "instance": 1}', '{"port": null, "instance": 1}', '{"port": 1e999}'],
)  # fmt: skip
def test_a_damaged_file_is_none(tmp_path, text):
    (tmp_path / "dashboard.json").write_text(text)
    assert RunningDashboard.find(tmp_path) is None


def test_a_folder_that_cannot_be_written_is_no_error(running, tmp_path):
    file = tmp_path / "file"
    file.touch()
    with starting(file / "state"), running.kept(file / "state"):
        assert RunningDashboard.find(file / "state") is None


def test_of_two_starts_one_waits_for_the_other(tmp_path):
    order, waiting = [], threading.Event()

    def second():
        waiting.set()
        with starting(tmp_path):
            order.append("second")

    thread = threading.Thread(target=second)
    with starting(tmp_path):
        thread.start()
        assert waiting.wait(60)
        order.append("first")
    thread.join(60)
    assert order == ["first", "second"]


def test_an_error_while_starting_is_its_own(tmp_path):
    with pytest.raises(OSError, match="mine"), starting(tmp_path):
        raise OSError("mine")
