"""The arrays with routine runs and the reference, exchange by exchange, build the same replay."""

from __future__ import annotations

import tempfile
from dataclasses import fields
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from replay_harness import METHODS, NAMES, RECEIVED, SENT, do, session, sim

from mikas.catalog import shipped
from mikas.errors import MikasError
from mikas.framing import encode
from mikas.recording import CaptureWriter
from mikas.recording.exchanges.columns.matcher import column_exchanges
from mikas.recording.exchanges.turns import quick_exchanges
from mikas.replay import behaviour as replay_habits
from mikas.replay import build as building
from mikas.replay.build import ReplayBuilder, build
from mikas.replay.model import ChangingValue, Series

FEW = 3  # delays that are enough, so that runs begin early


def plain(value):
    """`value` made of what can be compared."""
    if isinstance(value, Series):
        return (
            value.layout.places,
            value.times.tolist(),
            [value.datum(index, 0, value.size) for index in range(len(value.times))],
        )
    if isinstance(value, ChangingValue):
        return value.times.tolist(), value.values
    if isinstance(value, dict):
        return {key: plain(each) for key, each in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(each) for each in value]
    return value


def same(path):
    by_runs = build(column_exchanges(path, shipped().size_of), shipped())
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(building, "has_whole_numpy", lambda: False)
        one_by_one = build(quick_exchanges(path, shipped().size_of), shipped())
    for each in fields(one_by_one):
        name = each.name
        assert plain(getattr(by_runs, name)) == plain(getattr(one_by_one, name)), name


@pytest.fixture
def few(monkeypatch):
    monkeypatch.setattr(replay_habits, "_MOST_DELAYS", FEW)


steps = st.lists(
    st.tuples(
        st.sampled_from([*METHODS, "stroke0"]),
        st.lists(st.sampled_from(NAMES), min_size=1, max_size=4, unique=True),
        st.integers(1, 25),
        st.sampled_from([0.0, 0.3, 4.0]),
    ),
    min_size=1,
    max_size=4,
)
lines = st.sampled_from([{}, {"echo": 0}, {"lost": 0.02, "seed": 5}])


@settings(max_examples=15, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    steps, st.sampled_from([{}, {"echo": 0}, {"lost": 0.02, "seed": 5}]), st.booleans(), st.data()
)
def test_a_session_by_runs_is_the_same(few, wanted, how, joined, data):
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "a.pcapng"
        with session(sim(scenario="city", **how), folder, path, joined=joined, retries=5) as ecu:
            try:
                do(ecu, wanted)
                ecu.faults()
            except MikasError:
                pass  # the line was too bad; what was recorded up to there counts
        same(path)
        content = bytearray(path.read_bytes())
        for place in data.draw(st.lists(st.floats(0.1, 1), max_size=4)):
            content[min(len(content) - 1, int(place * len(content)))] ^= 0x11
        path.write_bytes(content)
        same(path)


def test_most_of_a_long_session_is_not_looked_at_one_by_one(few, tmp_path, monkeypatch):
    path = tmp_path / "a.pcapng"
    with session(sim(), tmp_path, path) as ecu:
        do(ecu, [("list", NAMES, 200, 0.0)])
    heard = []

    def counted(self, *response):
        heard.append(response)
        return hear(self, *response)

    hear = ReplayBuilder.take_response
    monkeypatch.setattr(ReplayBuilder, "take_response", counted)
    found = build(column_exchanges(path, shipped().size_of), shipped())
    assert found.frames > 200
    assert len(heard) < found.frames / 3


def test_two_ports_in_turns_keep_their_order_by_runs_too(tmp_path):
    from mikas.recording.capture import blocks as pcapng
    from mikas.recording.capture.reader import FLAGS

    blocks = [pcapng.Section(), pcapng.Interface(name="a", speed=9600)]
    blocks.append(pcapng.Interface(name="b", speed=9600))
    for number in range(40):
        port, wire = number % 2, encode(b"\x61\x1a")
        ticks = 1_000_000 + number * 50_000
        blocks.append(pcapng.EnhancedPacket(port, ticks, wire, FLAGS[SENT]))
        answer = wire + encode(bytes([100 + number]))
        blocks.append(pcapng.EnhancedPacket(port, ticks + 20_000, answer, FLAGS[RECEIVED]))
    path = tmp_path / "a.pcapng"
    path.write_bytes(b"".join(map(pcapng.encode, blocks)))
    same(path)


def test_a_clock_set_back_and_a_changed_list_are_the_same_by_runs(few, tmp_path):
    path = tmp_path / "a.pcapng"
    with CaptureWriter(path, url="a") as writer:
        time = 100.0

        def ask(request, answer):
            nonlocal time
            writer.record(SENT, encode(request), time)
            writer.record(RECEIVED, encode(request), time + 0.01)
            writer.record(RECEIVED, encode(answer), time + 0.02)
            time += 0.05

        for codes, size in ((b"\x1a\x29", 2), (b"\x1a", 1), (b"\x3f\x1a", 3)):
            ask(b"\x64" + codes, b"\x00")
            for number in range(20):
                ask(b"\x63", bytes([number + 2]) * size)
            time -= 30.0
            for number in range(20):
                ask(b"\x63", bytes([number + 60]) * (size if number != 11 else size + 1))
                if number == 11:
                    ask(b"\x01", b"\x0a")  # D13
    same(path)
    indexed = build(column_exchanges(path, shipped().size_of), shipped())
    assert indexed.frames == 3 * 42
