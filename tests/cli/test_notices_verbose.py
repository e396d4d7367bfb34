"""What `watch` and `log` say of why: the method that was taken, and what does not come."""

from __future__ import annotations

from itertools import pairwise

import pytest
from cli_harness import is_russian

from mikas.recording import CaptureReader


def test_while_methods_are_tried_no_plan_is_printed_as_the_choice(mikas):
    measuring = mikas("watch", "TWAT", "--count", "20", "-v").err
    assert "Testing sampling methods (about 1 s each)" in measuring
    assert "Plan: " not in measuring
    reported = mikas("watch", "TWAT", "--count", "900", "-v").err
    assert (
        reported.index("Testing")
        < reported.index("Method: stream (")
        < reported.index("Plan: stream, ")
    )
    assert reported.count("Plan: ") == 1
    assert "Testing" not in mikas("watch", "TWAT", "--count", "5", "-v", "--method", "list").err
    is_russian(mikas("watch", "TWAT", "--count", "20", "-v", "--relearn", "--lang", "ru").err)


def test_the_reason_for_a_slower_method_is_printed(mikas):
    assert "requested" not in mikas("watch", "TWAT", "--count", "900", "-v").err  # it is learnt
    reported = mikas("watch", "TWAT", "--count", "5", "--rate", "10", "-v").err
    assert "Method: batch (" in reported
    assert "): enough for the requested 10, with the least load on the unit." in reported
    argv = ("watch", "TWAT", "--count", "5", "--rate", "2.5", "-v", "--lang", "ru")
    assert "для заданных 2,5 достаточно" in mikas(*argv).err


@pytest.fixture
def standing(tmp_path):
    """The ignition is on, the engine stands."""
    scenario = 'name = "standing"\nduration = 100\n[start]\nrunning = false\n[timeline]\nkey = 1\n'
    (tmp_path / "standing.toml").write_text(scenario)
    return "&scenario=standing.toml"


def test_the_reason_for_no_strokes_is_printed_and_recorded_and_does_not_delay_the_end(
    mikas, standing, tmp_path
):
    argv = ("FREQ", "--method", "stroke0", "--duration", "20", "--json")
    ran = mikas("log", "-o", "a.pcapng", *argv, sim=standing)
    assert ran.status == 0
    why = {
        "en": "No stroke for 2 s: the engine is not turning",
        "ru": "Тактов нет 2 с: двигатель не вращается",
    }
    first, *gaps = ran.objects
    assert first["values"] == {"FREQ": 0}  # before the faults were read; no stroke is needed for it
    assert gaps
    assert all(line["reason"] == why and line["gap"] for line in gaps)
    times = [line["time"] for line in ran.objects]
    assert times[0] < 5
    assert max(later - before for before, later in pairwise(times)) < 4
    assert 17 < times[-1] - times[0] < 23
    assert ran.err.count(why["en"]) == 1
    assert "comes only while the engine turns: start it" in ran.err
    (gap,) = (note for note in CaptureReader(tmp_path / "a.pcapng").notes() if note.kind == "gap")
    assert gap.data["reason"] == why
    russian = mikas("watch", "FREQ", "--method", "stroke0", "--duration", "8", "--lang", "ru")
    assert f"{why['ru']}. Поток по тактам идёт, только пока двигатель вращается" in russian.err
    is_russian(russian.err)


def test_the_reason_of_a_gap_gives_the_length_of_the_wait(mikas, tmp_path):
    """The unit is off so shortly that it is there again when it is asked why it is silent."""
    dip = 'name = "dip"\nduration = 30\n[timeline]\nkey = [[0, 1], [18, 0], [18.5, 1]]\n'
    (tmp_path / "dip.toml").write_text(dip)
    argv = ("FREQ", "TWAT", "--method", "stream", "--duration", "25", "--json")
    ran = mikas("log", "-o", "a.pcapng", *argv, sim="&scenario=dip.toml")
    (gap,) = (note for note in CaptureReader(tmp_path / "a.pcapng").notes() if note.kind == "gap")
    assert gap.data["reason"]["en"] == "The ECU did not answer within 0.5 s"
    (line,) = (line for line in ran.objects if line["gap"])
    assert line["reason"] == gap.data["reason"]
    assert "reason" not in ran.objects[0]
