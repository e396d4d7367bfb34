"""Stalls between the tester and the wire: nothing is lost, and nothing passes meanwhile (D14)."""

from __future__ import annotations

from itertools import pairwise

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mikas.framing import encode
from mikas.virtual.build import build_bus
from mikas.virtual.bus import SHORTEST_STALL, Stalls
from virtual_harness import make_bus

from .raw_tester import BYTE, TURN, RawTester

seeds = st.integers(0, 2**32)
times = st.lists(st.floats(0, 0.5), max_size=200)


@given(seed=seeds, every=st.floats(0.05, 5), longest=st.floats(0.001, 3), pauses=times)
def test_bytes_pass_at_once_or_at_the_end_of_a_stall(seed, every, longest, pauses):
    stalls, now, passed = Stalls(every, longest, seed=seed), 0.0, []
    for pause in pauses:
        now += pause
        passed.append(stalls.passed(now))
        assert 0 <= passed[-1] - now <= longest
    assert passed == sorted(passed)


@settings(max_examples=20)
@given(seed=seeds)
def test_stalls_come_about_as_often_and_last_as_long_as_set(seed):
    stalls = Stalls(1.0, 0.18, seed=seed)
    late = [stalls.passed(at / 500) - at / 500 for at in range(100_000)]
    assert 170 * 0.18 * SHORTEST_STALL < stalls.total < 200 * 0.18
    lengths = [after for before, after in pairwise(late) if after and not before]
    assert min(lengths) > 0.18 * SHORTEST_STALL - 0.002
    assert max(lengths) <= 0.18


def test_by_default_there_are_no_stalls():
    assert Stalls().passed(5.0) == 5.0
    assert build_bus({}).adapter.stalls.every == 0


def test_a_stall_delays_the_request_and_holds_back_the_response():
    tester = RawTester(make_bus(stalls=Stalls(0.05, 0.18, seed=3)))
    answers = []
    for _ in range(50):
        start = tester.now
        answers.append(tester.ask(b"\x01"))
        ended = tester.times[-1] - start
        assert 6 * BYTE + TURN <= ended + 1e-9 <= 6 * BYTE + TURN + 2 * 0.18
    assert answers == [encode(b"\x0a")] * 50


@pytest.mark.parametrize("settings", [{"stall_every": "1"}, {"stall_every": "2", "stall_ms": "50"}])
def test_stalls_are_settings(settings):
    stalls = build_bus(settings).adapter.stalls
    assert stalls.every == float(settings["stall_every"])
    assert stalls.longest == pytest.approx(float(settings.get("stall_ms", 180)) / 1000)
