"""Messages have true dates, whatever the computer's date does meanwhile; `clock` says it."""

from __future__ import annotations

import pytest
from publication_harness import TOPICS, Published, content, publication

from mikas.i18n import Text
from mikas.sampling.events import AlarmChanged, ClockChanged, FaultReading, Gap
from sampling.computer_harness import BEGAN, NIGHT, YEARS, Computer


def published(computer: Computer, seconds: float = 10.0, **options: object) -> Published:
    return Published.of(iter(computer.run(seconds)), publication("FREQ", "TWAT", **options))


@pytest.fixture(scope="module")
def steady() -> Published:
    return published(Computer(), samples=True, each=True)


@pytest.mark.parametrize("seconds", [YEARS, NIGHT, -NIGHT])
def test_values_have_the_new_date_after_it_was_set_and_none_is_missing(steady, seconds):
    computer = Computer()
    computer.at(4.0, lambda: computer.jump(seconds))
    found = published(computer, samples=True, each=True)
    [change] = [it for it in found.under("event") if it["kind"] == "clock"]
    assert change["seconds"] == pytest.approx(seconds, abs=0.01)
    assert (change["slept"], set(change["text"])) == (False, {"en", "ru"})
    assert change["time"] == pytest.approx(change["after"], abs=6)
    for topic in ("values", "samples"):
        rows, expected = found.under(topic), steady.under(topic)
        assert [it.get("values") for it in rows] == [it.get("values") for it in expected]
        assert [it.get("ages") for it in rows] == [it.get("ages") for it in expected]
    times = [row[0] for it in found.under("samples") for row in it["samples"]]
    moved = [row[0] + seconds for it in steady.under("samples") for row in it["samples"]]
    at = next(at for at, time in enumerate(times) if abs(time - moved[at]) < 1)
    assert times[at:] == pytest.approx(moved[at:], abs=0.01)
    assert times[:at] == pytest.approx([time - seconds for time in moved[:at]], abs=0.01)
    assert times[at] == pytest.approx(BEGAN + 8 + seconds, abs=2)  # judged after some seconds
    assert len({it["session"] for it in found.under("samples")}) == 1
    assert abs(found.under("values")[-1]["time"] - BEGAN - 10 - seconds) < 1.5
    last = [it for it in found.messages if it.topic == TOPICS.value("FREQ")][-1]
    assert last.time == pytest.approx(BEGAN + 10 + seconds, abs=1.5)


def test_what_the_broker_keeps_is_sent_again_with_the_new_date():
    made = publication("FREQ")
    events = [*Computer().run(3.0)]
    events += [
        FaultReading(BEGAN + 3, (13,)),
        AlarmChanged(BEGAN + 3, "FREQ", "warn", "none", "high", 950.0, 900.0, Text("x", "y")),
        ClockChanged(BEGAN + 9, YEARS, slept=False, before=BEGAN + 4, after=BEGAN + 4 + YEARS),
    ]
    found = Published.of(iter(events), made)
    kept = {it.topic.rpartition("/")[2]: content(it) for it in found.steps[-1][1] if it.retain}
    assert set(kept) == {"state", "unit", "faults", "alarms"}
    before = {name: found.under(name)[-2] for name in kept}
    for name in ("state", "unit", "faults"):
        assert kept[name] == before[name] | {"time": before[name]["time"] + YEARS}
    assert kept["alarms"]["alarms"][0]["since"] == BEGAN + 3 + YEARS


def test_a_sleep_is_said_and_moves_no_time():
    computer = Computer()
    computer.silent(4.0, 7.0)
    computer.at(5.5, lambda: computer.jump(NIGHT))
    found = published(computer, 13.0)
    [change] = [it for it in found.under("event") if it["kind"] == "clock"]
    assert change["slept"]
    gap = [it for it in found.under("event") if it["kind"] == "gap"][-1]
    assert gap["ended"] - gap["began"] == pytest.approx(NIGHT + 3, abs=5)
    assert found.under("values")[-1]["time"] == pytest.approx(BEGAN + 13 + NIGHT, abs=6)


def test_a_gap_after_the_date_was_set_has_the_new_date():
    made = publication("FREQ")
    changed = ClockChanged(BEGAN, NIGHT, slept=False, before=BEGAN, after=BEGAN + NIGHT)
    gap = Gap(BEGAN + 9, BEGAN + 5, BEGAN + 9)
    sample = Computer().run(3.0)[-1]
    found = Published.of(iter([changed, gap, sample]), made)
    [said] = [it for it in found.under("event") if it["kind"] == "gap"]
    assert (said["began"], said["ended"]) == (BEGAN + 5 + NIGHT, BEGAN + 9 + NIGHT)
