"""Any bytes at any time: nothing raises, nothing hangs, and time stays in order."""

from __future__ import annotations

from itertools import pairwise

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mikas.framing import encode
from mikas.virtual.build import build_bus
from mikas.virtual.bus import AdapterKind, Bus
from mikas.virtual.fault_injector import FaultInjector, LineFault
from mikas.virtual.quirks import ChecksumForm, EcuQuirks, LongList, StreamEnd, Unknown
from virtual_harness import EXCHANGES, make_bus

from .raw_tester import RawTester

REQUESTS = [bytes.fromhex(v["request"]) for v in EXCHANGES] + [
    b"\x71\x1a",
    b"\x7f\x1a\x29",
    b"\x82\x3f",
]
END = 30.0

sayings = st.binary(min_size=1, max_size=20) | st.sampled_from(REQUESTS).map(encode)
breaks = st.floats(0, 0.1)
moments = st.floats(0, 3)
scripts = st.lists(st.tuples(moments, sayings | breaks), max_size=12).map(
    lambda script: sorted(script, key=lambda act: act[0])
)
quirks = st.builds(
    EcuQuirks,
    turn_round=st.sampled_from([0.0, 0.002, 0.3]),
    max_list=st.sampled_from([1, 2, 255]),
    long_list=st.sampled_from(LongList),
    unknown=st.sampled_from(Unknown),
    raw_checksum=st.booleans(),
    accepts=st.sampled_from(ChecksumForm),
    inter_byte=st.sampled_from([0.0, 0.0, 0.01]),
    turn_round_spread=st.sampled_from([0.0, 0.001]),
    max_list_71=st.sampled_from([None, 1]),
    lacking=st.sampled_from([frozenset(), frozenset({0x1A})]),
    extra=st.sampled_from([(), ((0x1A, 3), (0x33, 1))]),
    stream_end=st.sampled_from(StreamEnd),
)
adapters = st.builds(
    AdapterKind,
    echo=st.booleans(),
    latency=st.sampled_from([0.0, 0.016]),
    supplied=st.sampled_from([True, True, True, False]),
)


def play(bus: Bus, script, chunks=()) -> RawTester:
    """Runs `script`, looking at the wire at `chunks` too."""
    tester = RawTester(bus)
    acts = sorted([*script, *((moment, None) for moment in chunks)], key=lambda act: act[0])
    for moment, act in acts:
        tester.listen(max(moment, tester.now))
        if isinstance(act, bytes):
            tester.say(act)
        elif act is not None:
            bus.send_break(act, tester.now)
    tester.listen(END)
    return tester


def a_bus(kind, adapter, seed) -> Bus:
    fault_injector = FaultInjector(dict.fromkeys(LineFault, 0.03), seed=seed)
    return make_bus(quirks=kind, adapter=adapter, fault_injector=fault_injector)


@settings(max_examples=150)
@given(scripts, quirks, adapters, st.integers(0, 9), st.lists(moments, max_size=20))
def test_any_bytes_at_any_time_are_answered_the_same_again(script, kind, adapter, seed, chunks):
    once = play(a_bus(kind, adapter, seed), script)
    for earlier, later in pairwise(once.times):
        assert earlier <= later
    assert all(0 <= time <= END for time in once.times)
    # The same again gives the same, however often anybody looks.
    again = play(a_bus(kind, adapter, seed), script, chunks)
    assert again.heard == once.heard
    assert again.bus.bytes_carried == once.bus.bytes_carried


@settings(max_examples=30)
@given(scripts, quirks)
def test_bytes_follow_each_other_no_faster_than_the_wire(script, kind):
    """From one talker: without an echo only the unit is heard."""
    heard = play(a_bus(kind, AdapterKind(echo=False), 0), script).times
    for earlier, later in pairwise(heard):
        assert later - earlier >= make_bus().byte_time - 1e-9


@settings(max_examples=8)
@given(
    scripts,
    st.sampled_from(["warm-idle", "key-off", "cranking-dip", "city"]),
    st.lists(moments, max_size=20),
)
def test_a_car_with_an_engine_answers_the_same_again_however_it_is_read(script, scenario, chunks):
    def bus():
        return build_bus({"scenario": scenario, "seed": "5", "damaged": "0.05"})

    once = play(bus(), script)
    assert play(bus(), script, chunks).heard == once.heard


@pytest.mark.parametrize("start", [0.0, 0.1, 1.7e9 + 0.1, 1763694000.123457])
@pytest.mark.parametrize("scenario", ["key-off", "cranking-dip", "city"])
def test_the_key_is_turned_at_its_times_at_any_start_of_the_clock(start, scenario):
    """At today's date a float has a quarter of a microsecond: the key must still be met, once."""
    turned = []
    bus = build_bus(
        {"scenario": scenario},
        start=start,
        watcher=lambda h: turned.append((h.kind, round(h.time - start, 3))),
    )
    bus.advance(start + 200)
    expected = []
    if scenario == "key-off":
        for lap in (0, 60, 120, 180):
            expected += [("power-off", lap + 20.0), ("power-on", lap + 35.0)]
        expected = [event for event in expected if event[1] <= 200]
    assert turned == expected


def test_the_key_is_met_at_moments_that_no_float_has(tmp_path):
    path = tmp_path / "odd.toml"
    path.write_text(
        "duration = 7.3\nafter_end = 'loop'\n[start]\nrunning = true\ncoolant = 80\n"
        "[timeline]\nkey = [[0, 1], [0.1, 0], [2.3, 1], [3.7, 0], [5.9, 1]]\n"
    )
    for start in (0.0, 1763694000.123457, 1.7e9 + 1 / 3):
        turned = []
        bus = build_bus(
            {"scenario": str(path)}, start=start, watcher=lambda h, log=turned: log.append(h.kind)
        )
        bus.advance(start + 73.0)
        assert turned[:4] == ["power-off", "power-on"] * 2
        assert len(turned) in (40, 41)  # ten laps, and perhaps the next one's begin
        assert turned[::2] == ["power-off"] * len(turned[::2])
