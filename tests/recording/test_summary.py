"""What a recording is, for a list; what its notes tell. Whatever the file, an answer."""

from __future__ import annotations

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

import mikas
from capture_writing_harness import appending, coalescing
from mikas.catalog import shipped
from mikas.i18n import Text
from mikas.recording import CaptureWriter, Note
from mikas.recording import summary as summaries
from mikas.recording.annotations.events import comment_note, events_of, note_of, unit_of
from mikas.recording.capture import notes as file_index
from mikas.recording.capture.writer import append_note
from mikas.recording.summary import summarise
from mikas.sampling.events import (
    Gap,
    LineState,
    Marker,
    MethodChosen,
    ParameterDropped,
    ParameterReturned,
    StateChanged,
    TextNote,
)
from protocol_codes import NAMES
from session_header_harness import write_session_header

PORT = "sim:?clock=simulated&faults=13,53"
WHY = Text("no answer", "нет ответа")
PASSPORT = ("MIKAS", None, "", "", "", "", "", "")


def record(path, *, count=60, erase=False):
    with (
        appending(path, url=PORT) as writer,
        coalescing(writer) as sink,
        mikas.connect(PORT, sink=sink, journal=path.parent / "journal") as ecu,
    ):
        write_session_header(
            sink, 0.5, version_code=10, passports=PASSPORT, catalog_version="1", adapter="cable"
        )
        ecu.faults()
        for _ in ecu.watch(*NAMES, method="list", count=count):
            pass
        sink.note(note_of(Marker(2.0, "hill")))
        sink.note(note_of(Gap(1.0, 1.0, 1.5, WHY)))
        if erase:
            ecu.erase_faults()
            ecu.faults()
    return path


def test_a_summary_has_size_length_unit_and_counts(tmp_path):
    path = record(tmp_path / "a.pcapng")
    it = summarise(path)
    assert it.problem is None
    assert it.bytes == path.stat().st_size
    assert it.date is None  # a simulated clock
    assert it.model == Text("Mikas 7.1", "Микас 7.1")
    assert it.passport == PASSPORT
    assert it.samples_exact
    assert 60 <= it.samples <= 62
    assert 2 < it.length < 6
    assert it.rate == pytest.approx(it.samples / (it.length - 0.5))
    assert (it.gaps, it.markers, it.faults, it.note, it.recordings) == (1, 1, (13, 53), "", 1)


@pytest.mark.parametrize(("began", "ended"), [(-30.0, 1.5), (1.0, 90.0), (-30.0, -20.0)])
def test_only_the_part_of_a_gap_in_the_recording_is_no_time_of_its_rate(tmp_path, began, ended):
    """It may have begun before the recording, and end after its last packet."""
    path = record(tmp_path / "a.pcapng")
    append_note(path, note_of(Gap(began, began, ended, WHY)))
    first, length = summarise(path).first, summarise(path).length
    inside = max(0.0, min(ended, first + length) - max(began, first)) + 0.5
    assert summarise(path).rate == pytest.approx(summarise(path).samples / (length - inside))


def test_the_last_answer_about_faults_counts(tmp_path):
    assert summarise(record(tmp_path / "a.pcapng", count=1, erase=True)).faults == ()


def test_faults_that_were_not_read_are_not_known(tmp_path):
    path = tmp_path / "a.pcapng"
    with CaptureWriter(path, url=PORT) as sink, mikas.connect(PORT, sink=sink) as ecu:
        ecu.read("FREQ")
    assert summarise(path).faults is None


def test_a_persons_words_are_added_and_the_wire_stays(tmp_path):
    path = record(tmp_path / "a.pcapng", count=5)
    before = path.read_bytes()
    for words in ("холодный пуск", "cold start, then hot"):
        append_note(path, comment_note(9.0, words))
        assert summarise(path).note == words
    assert path.read_bytes().startswith(before)
    assert summarise(path).samples == summarise(record(tmp_path / "b.pcapng", count=5)).samples
    assert mikas.open(path).problems == ()


def test_sessions_in_one_file_are_added_up(tmp_path):
    path = record(tmp_path / "a.pcapng", count=20)
    once = summarise(path)
    record(path, count=20)
    both = summarise(path)
    assert both.recordings == 2
    assert both.length == pytest.approx(2 * once.length)
    assert (both.samples, both.markers) == (2 * once.samples, 2 * once.markers)


def test_samples_of_a_long_file_are_estimated_and_marked_as_estimated(tmp_path, monkeypatch):
    path = record(tmp_path / "a.pcapng", count=400)
    counted = summarise(path)
    monkeypatch.setattr(summaries, "_COUNTED", 1000)
    monkeypatch.setattr(summaries, "_PIECE", 3000)
    estimated = summarise(path)
    assert not estimated.samples_exact
    assert estimated.samples == pytest.approx(counted.samples, rel=0.05)
    assert estimated.faults == counted.faults


def test_what_stands_astride_two_windows_is_found(tmp_path, monkeypatch):
    path = record(tmp_path / "a.pcapng", count=30)
    whole = summarise(path)
    for window in (64, 256, 1028):
        monkeypatch.setattr(file_index, "_WINDOW", window)
        assert summarise(path) == whole


@pytest.mark.parametrize(
    ("content", "reason"),
    [
        (b"", "empty"),
        (b"Time,TWAT\n", "not a recording"),
        (bytes.fromhex("d4c3b2a1") + bytes(40), "old pcap"),
    ],
)
def test_a_file_that_is_no_recording_says_why(tmp_path, content, reason):
    path = tmp_path / "a.pcapng"
    path.write_bytes(content)
    it = summarise(path)
    assert reason in it.problem.en
    assert it.bytes == len(content)
    assert it.samples is None


def test_a_missing_file_or_a_folder_is_summed_up_as_a_problem(tmp_path):
    assert "no such file" in summarise(tmp_path / "none.pcapng").problem.en
    assert "folder" in summarise(tmp_path).problem.en


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    return record(tmp_path_factory.mktemp("whole") / "a.pcapng", count=15).read_bytes()


@given(st.data())
def test_any_damage_is_survived(whole, tmp_path_factory, data):
    path = tmp_path_factory.mktemp("cut") / "a.pcapng"
    cut = data.draw(st.integers(0, len(whole)))
    content = bytearray(whole[:cut] if data.draw(st.booleans()) else whole)
    for place in data.draw(st.lists(st.floats(0, 0.9999), max_size=6)):
        if content:
            content[int(place * len(content))] ^= data.draw(st.integers(1, 255))
    path.write_bytes(content)
    it = summarise(path)
    assert it.bytes == len(content)
    if it.problem is None:
        it = mikas.open(path)
        assert isinstance(it.events, tuple)
        assert it.about["recording"] == "a.pcapng"


# What the notes tell


def test_a_recording_names_its_unit_and_its_events(tmp_path):
    recording = mikas.open(record(tmp_path / "a.pcapng", count=5))
    assert recording.unit.adapter == "cable"
    assert recording.about["unit"] == "Mikas 7.1"
    assert recording.about["passport"] == "MIKAS"
    assert [event.kind for event in recording.events] == ["unit", "marker", "gap"]
    _, marker, gap = recording.events
    assert marker == Marker(2.0, "hill")
    assert gap == Gap(1.0, 1.0, 1.5, WHY)
    assert gap.as_json() == {
        "kind": "gap",
        "time": 1.0,
        "began": 1.0,
        "ended": 1.5,
        "reason": {"en": "no answer", "ru": "нет ответа"},
    }


def test_events_are_made_of_each_kind_of_note():
    notes = [
        note_of(StateChanged(1.0, LineState.ECHO_ONLY, reason=WHY)),
        note_of(TextNote(2.0, "words")),
        note_of(MethodChosen(3.0, "list", {"list": 29.5})),
        note_of(ParameterDropped(4.0, "TAIR")),
        note_of(ParameterReturned(4.5, "TAIR")),
        Note("unit", 5.0, {"version_code": 9}),
        Note("unit", 6.0, {"version_code": 9}),
        Note("unit", 7.0, {"version_code": 10}),
        Note("later", 8.0, {}),
    ]
    events = [event.as_json() for event in events_of(notes, shipped())]
    assert [event["kind"] for event in events] == [
        "state", "note", "method", "dropped", "returned", "unit", "unit",
    ]  # fmt: skip
    assert events[0]["state"] == "echo-only"
    assert events[2]["rates"] == {"list": 29.5}
    assert events[3]["name"] == events[4]["name"] == "TAIR"
    assert [event["another"] for event in events[5:]] == [False, True]


def units(*pieces: str | None, another: list[bool | None] | None = None) -> list[Note]:
    """Notes of a unit whose second piece of the passport is each of `pieces`."""
    notes = []
    for time, (piece, said) in enumerate(zip(pieces, another or [None] * 9, strict=False)):
        data = {"version_code": "0A", "passports": ["A", piece, "C", *["D"] * 5]}
        if said is not None:
            data["another"] = said
        notes.append(Note("unit", float(time), data))
    return notes


def test_a_piece_that_was_lost_at_first_makes_no_other_unit():
    notes = units(None, "B", None, "B")
    (event,) = events_of(notes, shipped())
    assert not event.another
    assert unit_of(notes, shipped()).passport == ("A", "B", "C", *["D"] * 5)


def test_all_pieces_known_of_a_unit_show_another():
    events = events_of(units("B", None, "X"), shipped())
    assert [event.another for event in events] == [False, True]
    events = events_of(units(None, "B", "X"), shipped())
    assert [event.another for event in events] == [False, True]


def test_whether_a_unit_is_another_is_read_from_its_note():
    events = events_of(units("B", "B", "B", another=[False, True, False]), shipped())
    assert [(event.time, event.another) for event in events] == [(0.0, False), (1.0, True)]
    (event,) = events_of(units("B", "X", another=[False, False]), shipped())
    assert not event.another


def test_the_first_unit_of_a_joined_recording_is_compared_with_the_one_before():
    first, second = units("B", "X", another=[False, False])
    events = events_of([first, replace(second, recording=1)], shipped())
    assert [event.another for event in events] == [False, True]
    events = events_of([first, replace(first, recording=1)], shipped())
    assert [event.another for event in events] == [False, False]


values = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=4), inner),
    max_leaves=4,
)
keys = st.sampled_from(
    ["text", "label", "began", "ended", "reason", "state", "channel", "level", "value", "limit",
     "method", "rates", "dropped", "returned", "version_code", "passports", "names", "version",
     "baud", "echo"]
)  # fmt: skip
kinds = st.sampled_from(
    ["unit", "plan", "catalog", "note", "marker", "gap", "state", "alarm", "learnt", "x"]
)


@given(st.lists(st.builds(Note, kinds, st.floats(0, 9), st.dictionaries(keys, values)), max_size=5))
def test_events_are_made_of_any_note(notes):
    unit_of(notes, shipped())
    for event in events_of(notes, shipped()):
        assert event.as_json()["kind"] == event.kind
