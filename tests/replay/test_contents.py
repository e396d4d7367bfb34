"""What was not known of the recorded unit is not played: refusals (D10), holes, odd notes."""

from __future__ import annotations

from contextlib import closing, suppress
from itertools import islice
from math import isnan

import numpy as np
import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st
from replay_harness import RECEIVED, SENT, again, session, sim
from test_build import FEW, same

from mikas.catalog import shipped
from mikas.errors import CaptureError, MikasError
from mikas.framing import encode
from mikas.i18n import Text
from mikas.recording import CaptureWriter
from mikas.recording.annotations.events import note_of
from mikas.recording.capture.notes import Kind, Note
from mikas.recording.exchanges.columns.matcher import column_exchanges
from mikas.recording.recording import Recording
from mikas.replay import behaviour as replay_habits
from mikas.replay import load, playing
from mikas.replay.build import build
from mikas.sampling.events import Gap, LineState, StateChanged

THR = 0x20


def write(path, exchanges, notes=(), *, apart=0.1):
    """Exchanges of a request, its answer (None: there is none), and a pause behind it."""
    time = 0.0
    with CaptureWriter(path, url="a", overwrite=True) as writer:
        for note in notes:
            writer.note(note)
        for request, answer, *pause in exchanges:
            wire = encode(bytes.fromhex(request))
            writer.record(SENT, wire, time)
            writer.record(RECEIVED, wire, time + 0.005)
            if answer is not None:
                writer.record(RECEIVED, encode(bytes.fromhex(answer)), time + 0.01)
            time += pause[0] if pause else apart
    return time


def played(path, code=THR):
    """The data of a code; of a response that has two, the last one."""
    found = []
    for series in {id(place[0]): place[0] for place in load(path).places.get(code, [])}.values():
        place = series.layout.last.get(code)
        found += [series.datum(at, *place).hex() for at in range(len(series.times))]
    return sorted(found)


# Refusals


def test_a_parameter_that_was_refused_is_not_known(tmp_path):
    path = tmp_path / "a.pcapng"
    write(path, [("6129", "15"), ("6120", "01"), ("612020", "01"), ("6129", "15")])
    assert set(load(path).places) == {0x29}
    with session(again(path, loop=1), tmp_path) as ecu:
        assert ecu.raw(b"\x61\x20") == b"\x01"
        assert set(ecu.read()) == {"FREQ"}


@pytest.mark.parametrize(
    ("exchanges", "data"),
    [
        ([("6120", "14"), ("6120", "01"), ("6120", "15")], ["14", "01", "15"]),
        ([("6120", "14"), ("6120", "01")], ["14"]),
        ([("6120", "14"), ("6120", "01"), ("612020", "0101"), ("6120", "01")], "14 01 01 01"),
        ([("612029", "0115"), ("6120", "01")], ["01", "01"]),
        (
            [("6120", "14"), ("6120", "01"), ("612020", None), ("01", "0A"), ("6120", "01")],
            ["14", "01", "01"],
        ),
        ([("6120", "01"), ("612020", "01"), ("6120", "01"), ("6120", "15")], ["15"]),
    ],
)
def test_a_lone_01_counts_as_it_does_in_a_table(tmp_path, exchanges, data):
    path = tmp_path / "a.pcapng"
    write(path, exchanges)
    wanted = data.split() if isinstance(data, str) else data
    assert played(path) == sorted(wanted)


def test_the_last_value_is_not_repeated_while_the_parameter_was_refused(tmp_path):
    path = tmp_path / "a.pcapng"
    refusing = [("6120", "01"), ("612020", "01"), *[("6129", "16")] * 30]
    write(path, [*[("612029", "1415")] * 30, *refusing, *[("612029", "1617")] * 30])
    with session(again(path), tmp_path) as ecu:
        car, link = playing(ecu.tester.link), ecu.tester.link
        for position, answer in ((2.0, b"\x14"), (4.0, b"\x01"), (8.0, b"\x16")):
            car.seek(position, link.now())
            assert ecu.raw(b"\x61\x20") == answer
            assert ecu.raw(b"\x61\x29")


@pytest.mark.parametrize("method", ["single", "batch"])
def test_a_sampled_unit_that_refuses_does_so_again(tmp_path, method):
    path = tmp_path / "a.pcapng"
    names = ["FREQ", "TWAT", "RXX"]
    with session(sim(unknown="01"), tmp_path, path) as ecu:
        ecu.tester.link.link.bus.ecu.responder.car.size_of = {0x29: 1}.get  # it lacks the others
        with suppress(MikasError), closing(ecu.watch(*names, method=method)) as samples:
            wanted = [set(sample.readings) for sample in islice(samples, 40)]
        ecu.tester.wait(ecu.tester.link.now() + 0.1)
    assert set(load(path).places) == {0x29}
    same(path)
    with session(again(path), tmp_path) as ecu:
        with suppress(MikasError), closing(ecu.watch(*names, method=method)) as samples:
            replayed = [set(sample.readings) for sample in islice(samples, 5)]
        assert replayed[-1:] == wanted[:1]


answers = st.sampled_from(["01", "01", "02", "0101", "0201", None])
exchange = st.one_of(
    st.tuples(st.sampled_from(["6120", "6107", "6129", "613F"]), answers),
    st.tuples(st.sampled_from(["612020", "612029", "610707"]), answers),
    st.tuples(st.sampled_from(["6420", "63", "7120"]), st.sampled_from(["00", "01", "05"])),
)
some = st.lists(exchange, min_size=1, max_size=3)
repeated = st.tuples(some, st.integers(1, 8)).map(lambda it: it[0] * it[1])


@settings(max_examples=40, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.lists(repeated, min_size=1, max_size=12))
@example([[("6120", "02"), ("6107", it)] * 2 for it in ("0101", "01")])
def test_by_runs_the_contents_are_the_same(monkeypatch, tmp_path_factory, drawn):
    monkeypatch.setattr(replay_habits, "_MOST_DELAYS", FEW)
    path = tmp_path_factory.mktemp("doubt") / "a.pcapng"
    write(path, [it for group in drawn for it in group], apart=0.03)
    same(path)


reads = exchange.filter(lambda it: it[0][:2] == "61")


@settings(max_examples=60)
@given(st.lists(reads, min_size=1, max_size=30))
@example([("612020", "01"), ("6120", "01"), ("6120", "01")])
def test_what_is_played_is_what_a_table_shows(tmp_path_factory, exchanges):
    path = tmp_path_factory.mktemp("doubt") / "a.pcapng"
    write(path, exchanges)
    shown = [
        f"{int(value):02x}"
        for rows in Recording(path, shipped()).rows()
        for value in rows.values.get("THR", np.empty(0)).tolist()
        if not isnan(value)
    ]
    try:
        reported = played(path)
    except CaptureError:  # no answer at all
        reported = []
    assert sorted(shown) == reported


# Holes


def steady(path, notes=(), *, hole=20.0):
    """Two seconds of readings, a hole, and two seconds again."""
    value = iter(range(2, 250))
    first = [("6120", f"{next(value):02x}") for _ in range(40)]
    first[-1] = (*first[-1], hole)
    return write(path, [*first, *[("6120", f"{next(value):02x}") for _ in range(40)]], notes,
                 apart=0.05)  # fmt: skip


GAP = note_of(Gap(1.95, 1.95, 21.95, Text("unplugged", "вынут")))
NO_PORT = note_of(StateChanged(2.5, LineState.NO_PORT))


@pytest.mark.parametrize("notes", [[], [GAP], [NO_PORT]])
def test_no_old_value_is_played_where_nothing_was_recorded(tmp_path, notes):
    path = tmp_path / "a.pcapng"
    steady(path, notes)
    recorded = load(path)
    [(begin, end)] = recorded.holes
    assert 1.95 < begin < 2.1
    assert 21.8 < end < 21.96
    assert recorded.silences == []
    with session(again(path), tmp_path, timeout=0.1) as ecu:
        car, link = playing(ecu.tester.link), ecu.tester.link
        car.seek(1.5, link.now())
        ecu.set_list("THR")
        ecu.tester.wait(link.now() + 5)
        with pytest.raises(MikasError):
            ecu.read("THR")
        ecu.tester.wait(link.now() + 17 - 1.5)
        assert ecu.read_list()["THR"].raw > b"\x29"  # it had its supply: it has not forgotten


@pytest.mark.parametrize(
    "notes",
    [
        [note_of(Gap(2.0, 2.0, 2.9, Text("a", "b")))],
        [note_of(StateChanged(2.5, LineState.NO_PORT))],
    ],
)
def test_a_short_hole_is_one_if_there_is_a_note_of_it(tmp_path, notes):
    path = tmp_path / "a.pcapng"
    steady(path, hole=1.0)
    assert load(path).holes == []
    steady(path, notes, hole=1.0)
    assert len(load(path).holes) == 1


def test_a_slow_recording_has_no_holes(tmp_path):
    path = tmp_path / "a.pcapng"
    write(path, [("6120", "14")] * 60, apart=10.0)
    assert load(path).holes == []


def test_a_hole_among_what_is_taken_by_runs_is_found(tmp_path, monkeypatch):
    monkeypatch.setattr(replay_habits, "_MOST_DELAYS", FEW)
    path = tmp_path / "a.pcapng"
    steady(path)
    same(path)
    assert len(build(column_exchanges(path, shipped().size_of), shipped()).holes) == 1


# Odd notes


@pytest.mark.parametrize("passports", [5, True, "abc", {"a": 1}, 1.5, [5, None, [], "ok"]])
def test_a_unit_note_with_odd_passports_is_passed_over(tmp_path, passports):
    path = tmp_path / "a.pcapng"
    note = Note(Kind.UNIT, 0.0, {"version_code": 9, "passports": passports})
    write(path, [("6129", "15")], [note])
    recorded = load(path)
    assert recorded.version.values == [9]
    assert recorded.problems == (not isinstance(passports, list))
    assert [it.values for it in recorded.passports[:3]] == [[], [], []]


@pytest.mark.parametrize("data", [{"began": "x"}, {"began": 1e308, "ended": -1e308}, {}])
def test_an_odd_note_of_a_gap_is_passed_over(tmp_path, data):
    path = tmp_path / "a.pcapng"
    steady(path, [Note(Kind.GAP, 0.0, data)])
    assert len(load(path).holes) == 1
