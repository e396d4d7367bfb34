"""The end of a program that an icon has started: the page's button, and ten minutes without it."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import pytest
from websockets.exceptions import ConnectionClosed

from dashboard.rig import ME, OTHER, rig
from mikas.dashboard.dashboard import Dashboard
from mikas.dashboard.errors import Busy
from mikas.dashboard.program import AWAY, Ending
from mikas.dashboard.security.control import Client
from mikas.dashboard.settings import Settings

VIEWER = Client("viewer", "Viewer", may_control=False)


@pytest.fixture
def program(tmp_path):
    """A program on its icon; `now` is the clock, `ended` how often it was ended."""
    it = SimpleNamespace(now=0.0, ended=0)
    settings = Settings(tmp_path / "recordings", state=tmp_path / "state", desktop=True)
    it.dashboard = Dashboard(settings, clock=lambda: it.now)
    it.ending = Ending(it.dashboard)
    it.ending.attach(lambda: setattr(it, "ended", it.ended + 1))
    return it


def pass_time(program, seconds):
    for _ in range(int(seconds)):
        program.now += 1
        program.ending.check()


def test_a_program_that_nobody_opens_ends(program):
    pass_time(program, AWAY - 1)
    assert not program.ended
    pass_time(program, 1)
    assert program.ended == 1


def test_the_time_counts_from_the_last_page(program):
    program.dashboard.control.socket_opened(VIEWER, "page")
    pass_time(program, 3 * AWAY)
    program.dashboard.control.socket_closed(VIEWER, "page")
    pass_time(program, AWAY - 1)
    assert not program.ended
    pass_time(program, 1)
    assert program.ended


@pytest.mark.parametrize("busy", ["recording", "dump"])
def test_a_recording_and_a_dump_keep_it(program, busy, monkeypatch):
    if busy == "recording":
        monkeypatch.setattr(type(program.dashboard.recorder), "file_name", "a.pcapng")
    else:
        program.dashboard.dump_jobs.jobs["a"] = SimpleNamespace(phase="running")
    pass_time(program, 3 * AWAY)
    assert not program.ended
    if busy == "recording":
        monkeypatch.setattr(type(program.dashboard.recorder), "file_name", None)
    else:
        program.dashboard.dump_jobs.jobs["a"].phase = "done"
    pass_time(program, AWAY)
    assert program.ended


def test_a_program_in_a_terminal_does_not_end_by_itself(program):
    program.dashboard.settings = replace(program.dashboard.settings, desktop=False)
    pass_time(program, 3 * AWAY)
    assert not program.ended
    with pytest.raises(Busy):
        program.ending.end_program()


def test_the_button_of_a_program_in_a_terminal_is_refused(shared_off):
    assert shared_off.get("/about")["desktop"] is False
    error = shared_off.post("/end", status=409)
    assert "Ctrl-C" in error["en"]
    assert "Ctrl-C" in error["ru"]


def test_the_button_ends_it_and_keeps_the_recording(tmp_path):
    with rig(tmp_path, "sim:?scenario=warm-idle", desktop=True) as it:
        it.sampling()
        assert it.get("/about")["desktop"] is True
        it.post("/recording/start", {"name": "a"})
        it.until(lambda m: ((m.get("state") or {}).get("recording") or {"samples": 0})["samples"])
        with it.live() as watching:
            assert it.post("/end")["desktop"] is True
            with pytest.raises(ConnectionClosed):
                watching.until(lambda _: False)
    assert it.dashboard.recorder.last.path == tmp_path / "recordings" / "a.pcapng"
    assert it.dashboard.recorder.last.failure is None


def test_only_this_computer_ends_it(tmp_path):
    with rig(tmp_path, None, desktop=True, lan=True, lan_control=True, hosts=("garage",)) as it:
        host = {"Host": f"garage:{it.port}", "Authorization": f"Bearer {it.access.token}"}
        assert it.post("/end", status=403, headers={**OTHER, **host})["code"] == "OnlyHere"
        assert it.client.post("/api/end").status_code == 400  # without an id
        assert it.get("/about", headers=ME)["desktop"] is True
