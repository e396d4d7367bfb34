"""Crafted notes and options of a recording: no reader of it fails, whatever they hold.

The raw bytes stay in the file; what a reader returns has passed through `mikas.cleaning`.
"""

from __future__ import annotations

import json
import tempfile
from itertools import product
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import mikas
from dashboard.recordings_rig import record
from mikas.catalog import shipped
from mikas.cleaning import clean_line, clean_text, is_in_calendar
from mikas.dashboard.api.errors import made_of
from mikas.dashboard.api.library.recordings import RecordingInfo
from mikas.recording import CaptureReader
from mikas.recording.annotations import fields
from mikas.recording.annotations.events import events_of, note_of
from mikas.recording.capture import blocks as pcapng
from mikas.recording.capture.notes import ENTERPRISE, LONGEST, TAG, Kind, block_of, read_block
from mikas.recording.export import export
from mikas.recording.inspect import Describer, decode, to_json
from mikas.recording.summary import summarise
from mikas.replay import replay_bus
from mikas.report.from_recording import find_in_recording
from mikas.report.page import render
from mikas.sampling.events import TextNote

KEYS = (
    "adapter", "baud", "before", "began", "better", "channel", "codes", "dropped", "echo", "en",
    "ended", "erased", "label", "level", "limit", "list", "method", "names", "passports", "port",
    "rates", "readings", "reason", "returned", "ru", "side", "state", "text", "time", "value",
    "version", "version_code",
)  # fmt: skip
TEXTS = ("\ud800", "\x1b]52;c;QQ==\a", "\x9b2J", "\u202e", "\r\n", "\0", "=1+1", "X" * 2000)
NUMBERS = (
    "1e999",
    "-1e999",
    "NaN",
    "1" + "0" * 4000,
    "18446744073709551617",
    "1e300",
    "-1",
    "9e11",
)
texts = st.sampled_from(TEXTS) | st.text(st.characters(exclude_categories=()), max_size=9)
# JSON texts: `json.dumps` writes neither 1e999 nor such integers.
scalars = (
    st.sampled_from((*NUMBERS, "true", "null", "0A", '"0A"'))
    | texts.map(json.dumps)
    | st.integers(-9, 300).map(str)
)


def objects(inner):
    return st.dictionaries(st.sampled_from(KEYS) | texts, inner, max_size=5).map(as_object)


def as_object(members):
    inside = ",".join(f"{json.dumps(key)}:{text}" for key, text in members.items())
    return f"{{{inside}}}"


def lists(inner):
    return st.lists(inner, max_size=4).map(lambda items: f"[{','.join(items)}]")


json_texts = st.recursive(scalars, lambda inner: lists(inner) | objects(inner), max_leaves=8)
notes = st.tuples(
    st.sampled_from([*Kind, "about"]), scalars | st.just("1"), objects(json_texts) | json_texts
)


def crafted(kind, time, data):
    content = f'{{"kind":"{kind}","time":{time},"data":{data}}}'
    return pcapng.encode(pcapng.Custom(ENTERPRISE, TAG + content.encode()))


def is_clean(value):
    """Whether JSON has clean texts only, as a response of the dashboard is encoded."""
    text = json.dumps(value, ensure_ascii=False, allow_nan=False)
    assert text.encode() is not None
    return clean_text(text) == text


def list_entry(path):
    summary = summarise(path, shipped())
    entry = made_of(
        RecordingInfo,
        summary,
        id="a.pcapng",
        bytes=1,
        open=False,
        reference=False,
        virtual=False,
    )
    return entry.model_dump(mode="json")


HEAD = pcapng.encode(pcapng.Section()) + pcapng.encode(pcapng.Interface())


@settings(max_examples=25)
@given(st.lists(notes, max_size=6))
def test_any_note_has_a_place_in_the_list_and_among_the_events(crafted_notes):
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "a.pcapng"
        path.write_bytes(HEAD + b"".join(crafted(*note) for note in crafted_notes))
        assert is_clean(list_entry(path))
        events = events_of(CaptureReader(path).notes(), shipped())
        assert is_clean([event.as_json() for event in events])
        assert all(is_in_calendar(abs(event.time)) for event in events)
        for event in events:
            assert event == events_of([note_of(event)], shipped())[0] or event.kind == "unit"


FIELDS = {
    "unit": ("version_code", "passports", "adapter", "baud", "echo"),
    "catalog": ("version",),
    "plan": ("method", "names", "every"),
    "note": ("text",),
    "marker": ("label",),
    "gap": ("began", "ended", "reason"),
    "state": ("state", "text", "reason"),
    "adapter": ("port", "before"),
    "alarm": ("channel", "level", "before", "better", "side", "value", "limit", "text"),
    "learnt": ("methods", "rates", "method", "dropped", "returned"),
    "faults": ("readings",),
    "about": ("text",),
    "clock": ("seconds", "slept", "before", "after"),
}
LISTS = ("passports", "names", "every", "readings")
NEEDED = {
    "unit": {"version_code": '"0A"'},
    "alarm": {"channel": '"TWAT"', "level": '"danger"'},
    "adapter": {"port": '"p"'},
    "learnt": {"method": '"list"'},
    "state": {"state": '"no-port"'},
}


@pytest.fixture(scope="module")
def hostile(tmp_path_factory):
    """A good recording, and after it every field of every note with every bad value."""
    path = record(tmp_path_factory.mktemp("hostile") / "\x1b[2J=1+1.pcapng", count=4)
    words = ("".join(TEXTS[:-2]), *TEXTS[-2:])
    values = [*map(json.dumps, words), *NUMBERS, "true", "[]", "{}"]
    with path.open("ab") as file:
        for kind, names in FIELDS.items():
            for name, value in product(names, values):
                pair = f'{{"en":{value},"ru":{value},"time":{value},"codes":[{value}]}}'
                for form in (value, f"[{value},{pair}]" if name in LISTS else pair):
                    data = NEEDED.get(kind, {}) | {name: form}
                    file.write(crafted(kind, 1, as_object(data)))
        file.write(crafted("note", 1, as_object({"text": json.dumps("X" * 200_000)})))
    return path


def test_a_hostile_recording_is_listed_and_opened_with_clean_texts(hostile):
    before = hostile.read_bytes()
    assert is_clean(entry := list_entry(hostile))
    assert len(entry["note"]) <= fields.LONGEST_COMMENT
    recording = mikas.open(hostile)
    events = [event.as_json() for event in recording.events]
    assert len(events) > 300
    assert is_clean(events)
    assert is_clean(recording.about)
    assert "\x1b" not in recording.about["recording"]
    rows, _ = recording.window(-1e300, 1e300)
    assert len(rows.times)
    assert is_clean(
        [to_json(item) for item in decode(CaptureReader(hostile), lambda: Describer(shipped()))]
    )
    assert hostile.read_bytes() == before


def test_a_hostile_recording_is_reported_with_clean_texts(hostile):
    page = render(find_in_recording(mikas.open(hostile)), "ru")
    assert clean_text(page) == page


@pytest.mark.parametrize("suffix", [".csv", ".msl", ".mlg", ".mf4", ".parquet"])
def test_a_hostile_recording_is_exported_to_each_format(hostile, tmp_path, suffix):
    recording, out = mikas.open(hostile), tmp_path / f"out{suffix}"
    export(out, recording.channels, recording.rows(), events=recording.events,
           about=recording.about)  # fmt: skip
    if suffix in (".csv", ".msl"):
        text = out.read_text("utf-8")
        assert clean_text(text) == text


def test_a_hostile_recording_is_replayed(hostile):
    bus = replay_bus(hostile, {}, catalog=shipped())
    assert all(
        clean_line(piece) == piece for piece in bus.ecu.responder.car.recorded.passports[0].values
    )


def test_the_texts_of_ports_and_programs_are_clean_and_of_one_line():
    words = "a\x1b]0;x\a\u202e\r\nb\ud800"
    blocks = [
        pcapng.Section(hardware=words, application=words),
        pcapng.Interface(name=words, description=words, speed=2**63),
        pcapng.EnhancedPacket(0, 0, b"\r", flags=pcapng.INBOUND, comment=words),
    ]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "a.pcapng"
        path.write_bytes(b"".join(map(pcapng.encode, blocks)))
        [packet] = CaptureReader(path)
    source = packet.source
    for text in (source.url, source.description, source.application, source.hardware):
        assert clean_line(text) == text
        assert "\x1b" not in text
    assert clean_text(packet.comment) == packet.comment
    assert source.baud == 0


def test_a_text_of_many_options_is_joined_once():
    """A block of a hundred thousand comments is not copied a hundred thousand times."""
    option = b"\1\0\4\0abcd"
    head = pcapng.encode(pcapng.EnhancedPacket(0, 0, b""))[8:-4]
    block = pcapng.parse(pcapng.ENHANCED, head + option * 100_000, "<")
    assert isinstance(block, pcapng.EnhancedPacket)
    assert len(block.comment) == 0xFFFF


def test_a_note_longer_than_any_that_this_program_writes_is_left_out():
    block = block_of(note_of(TextNote(1.0, "Ж" * fields.LONGEST_TEXT)))
    assert read_block(block) is not None
    assert read_block(pcapng.Custom(ENTERPRISE, block.data + b" " * LONGEST)) is None
