"""Recordings, lists and reports have true dates when the computer's date is set meanwhile."""

from __future__ import annotations

from datetime import datetime

import pytest

YEARS = 4 * 365 * 86400.0
NIGHT = 43200.0


def set_date(idle, seconds):
    """Set the computer's date, and wait until that is noticed."""
    idle.cars.clock.set_by += seconds

    def noticed(_):
        found = clock_events(idle.get("/history", seconds=3600))
        return any(it["seconds"] == pytest.approx(seconds, abs=1) for it in found)

    idle.until(noticed)


def record(idle, name):
    idle.post("/recording/start", {"name": name})
    idle.until(lambda it: it["state"]["recording"]["samples"] > 3)


def listed(idle, name):
    return next(it for it in idle.get("/recordings")["recordings"] if it["id"] == name)


def clock_events(detail):
    return [it for it in detail["events"] if it["kind"] == "clock"]


@pytest.mark.parametrize("seconds", [YEARS, -NIGHT])
def test_a_date_that_is_set_while_recording_dates_that_recording_and_the_next_ones(idle, seconds):
    record(idle, "a")
    set_date(idle, seconds)
    idle.post("/recording/stop")
    now = idle.cars.clock.date()
    detail = idle.get("/recordings/a.pcapng")
    [change] = clock_events(detail)
    assert {"en", "ru"} == set(change["text"])
    assert change["slept"] is False
    assert detail["gaps"] == 0
    assert listed(idle, "a.pcapng")["clock"] == [change["text"]]
    for date in (listed(idle, "a.pcapng")["date"], detail["date"]):
        assert date == pytest.approx(now, abs=3600)
    record(idle, "b")
    idle.post("/recording/stop")
    idle.post("/connect", {"port": "sim:?scenario=warm-idle"})
    idle.sampling()
    record(idle, "c")
    idle.post("/recording/stop")
    for name in ("b.pcapng", "c.pcapng"):
        detail = idle.get(f"/recordings/{name}")
        assert clock_events(detail) == []
        assert detail["date"] == pytest.approx(now, abs=3600)


def test_a_recording_that_is_stopped_at_once_has_the_note(idle):
    record(idle, "a")
    idle.cars.clock.set_by = -YEARS
    idle.post("/recording/stop")
    [change] = clock_events(idle.get("/recordings/a.pcapng"))
    assert change["seconds"] == pytest.approx(-YEARS, abs=1)
    assert listed(idle, "a.pcapng")["date"] == pytest.approx(idle.cars.clock.date(), abs=3600)


def test_a_live_report_has_the_new_date_and_says_that_it_was_set(idle):
    set_date(idle, YEARS)
    page = idle.get("/report", lang="ru").text
    day = datetime.fromtimestamp(idle.cars.clock.date()).astimezone()
    assert f"{day:%d.%m.%Y}" in page
    assert "переведена вперёд" in page
