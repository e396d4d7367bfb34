"""Gaps: when one begins and ends, its reason, and how long values may stay away."""

from __future__ import annotations

from mikas.errors import EchoOnly, NoResponse
from mikas.i18n import Text
from mikas.sampling.events import CycleFailed, Gap, LineState, Sampled, StateChanged
from mikas.sampling.gaps import Arrivals, GapTracker, Silence

LOST = NoResponse(seconds=0.5)
PAUSE, OTHER = Text("a plan", "план"), Text("a port", "порт")


def sampling():
    tracker = GapTracker()
    assert tracker.gaps_of(StateChanged(0.0, LineState.SAMPLING)) == []
    return tracker


def sample(tracker, *times):
    return [gap for time in times for gap in tracker.gaps_of(Sampled(time, {}, {}))]


def test_a_gap_reaches_from_the_last_values_to_the_next():
    tracker = sampling()
    assert sample(tracker, 1.0, 1.1) == []
    assert tracker.gaps_of(CycleFailed(1.5, LOST)) == [Gap(1.1, 1.1, None, LOST.reason)]
    assert tracker.gaps_of(CycleFailed(2.0, LOST)) == []
    assert sample(tracker, 3.0) == [Gap(3.0, 1.1, 3.0, LOST.reason)]
    assert tracker.open is None


def test_a_broken_state_is_a_better_reason_than_a_failed_cycle():
    tracker = sampling()
    sample(tracker, 1.0)
    tracker.gaps_of(CycleFailed(1.5, LOST))
    tracker.gaps_of(StateChanged(2.0, LineState.ECHO_ONLY, EchoOnly()))
    assert tracker.open.reason == EchoOnly().reason
    tracker.gaps_of(StateChanged(2.5, LineState.NO_PORT))
    (gap,) = sample(tracker, 9.0)
    assert gap == Gap(9.0, 1.0, 9.0, LineState.NO_PORT.text)


def test_a_broken_line_begins_a_gap_only_after_values():
    tracker = GapTracker()
    assert tracker.gaps_of(StateChanged(1.0, LineState.NO_PORT)) == []
    tracker.gaps_of(StateChanged(2.0, LineState.SAMPLING))
    (gap,) = tracker.gaps_of(StateChanged(3.0, LineState.NO_PORT))
    assert (gap.began, gap.ended) == (3.0, None)


def test_a_clock_that_runs_back_makes_no_gap_of_less_than_nothing():
    tracker = sampling()
    sample(tracker, 100.0)
    tracker.gaps_of(CycleFailed(50.0, LOST))
    (gap,) = sample(tracker, 20.0)
    assert (gap.began, gap.ended) == (50.0, 50.0)


def test_a_pause_is_a_gap_if_it_is_longer_than_usual_and_its_first_reason_counts():
    tracker = sampling()
    sample(tracker, 1.0, 1.1)
    tracker.pause(PAUSE)
    assert sample(tracker, 1.9) == []
    tracker.pause(PAUSE)
    tracker.pause(OTHER)
    assert sample(tracker, 9.0) == [Gap(9.0, 1.9, 9.0, PAUSE)]


def test_a_disconnection_ends_a_gap_and_is_one_itself():
    tracker = sampling()
    sample(tracker, 1.0)
    tracker.gaps_of(CycleFailed(2.0, LOST))
    assert tracker.disconnect(5.0, OTHER) == [Gap(5.0, 1.0, 5.0, LOST.reason)]
    assert tracker.silence(1e6) is None
    assert sample(tracker, 5.1) == [Gap(5.1, 5.0, 5.1, OTHER)]


def test_silence_begins_after_three_usual_steps_and_a_second_at_least():
    arrivals = Arrivals()
    arrivals.add(0.0)
    assert arrivals.silence(99.0) == Silence()
    arrivals.add(0.1)
    assert arrivals.silence(1.0) == Silence()
    assert arrivals.silence(1.6) == Silence(1.5)
    assert arrivals.silence(2.1) == Silence(2.0, gone=True)
    arrivals.interrupt()
    assert arrivals.silence(99.0) == Silence()
    for time in (100.0, 105.0):
        arrivals.add(time)
    assert not arrivals.silence(119.0).seconds
    assert arrivals.silence(120.0).seconds == 15.0
