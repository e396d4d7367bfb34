"""Notes in a capture: written between the packets, found again, no hindrance to anybody else."""

from __future__ import annotations

import io
import json
import os
import shutil
import struct
import subprocess
import sys
import tempfile
from math import inf, nan
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from capture_writing_harness import appending
from mikas.catalog import shipped
from mikas.client import Limits, Passport
from mikas.client.cars import CarDetails
from mikas.errors import CaptureError
from mikas.i18n import Text
from mikas.link.base import Direction
from mikas.recording import CaptureReader, CaptureWriter, Kind, Note
from mikas.recording.annotations.events import car_note, catalog_note, faults_note, note_of, unit_of
from mikas.recording.capture import blocks as pcapng
from mikas.recording.capture import notes as blocks
from mikas.recording.capture.notes import index
from mikas.recording.capture.reader import Packet
from mikas.sampling.alarms import Alarms
from mikas.sampling.events import (
    AdapterMoved,
    ClockChanged,
    FaultReading,
    Gap,
    LineState,
    Marker,
    ParameterDropped,
    PlanChanged,
    StateChanged,
    TextNote,
    UnitFound,
)
from mikas.sampling.plan import Plan, PlannedParameter
from session_header_harness import write_session_header

SENT, RECEIVED = Direction.SENT, Direction.RECEIVED

texts = st.text(st.characters(exclude_categories=["Cs", "Cc", "Cf", "Zl", "Zp", "Cn"]), max_size=20)
values = st.recursive(
    st.none()
    | st.booleans()
    | st.integers(-(2**60), 2**60)
    | st.floats(allow_nan=False, allow_infinity=False)
    | texts,
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(texts, inner, max_size=3),
    max_leaves=6,
)
times = st.floats(-1e9, 4e9)
noted = st.builds(
    Note, st.sampled_from(Kind) | texts, times, st.dictionaries(texts, values, max_size=4)
)


def notes(path):
    return list(CaptureReader(path).notes())


def packets(path):
    items = list(CaptureReader(path))
    assert all(isinstance(item, Packet) for item in items)
    return [(item.direction, item.data, item.time) for item in items]


def write_blocks(path, *blocks, order="<"):
    path.write_bytes(b"".join(pcapng.encode(block, order) for block in blocks))


@given(st.lists(noted | st.binary(min_size=1, max_size=9), max_size=8))
def test_notes_and_packets_are_both_read_back_and_do_not_see_each_other(items):
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "line.pcapng"
        with CaptureWriter(path, url="sim:") as writer:
            for item in items:
                if isinstance(item, Note):
                    writer.note(item)
                else:
                    writer.record(RECEIVED, item, 1.0)
        assert notes(path) == [item for item in items if isinstance(item, Note)]
        kept = [(RECEIVED, item, 1.0) for item in items if isinstance(item, bytes)]
        assert packets(path) == kept


def test_the_enterprise_number_is_the_one_for_documentation_and_editors_may_copy_the_block(path):
    with CaptureWriter(path, url="sim:") as writer:
        writer.note(note_of(Marker(2.5, "hill")))
    found = next(CaptureReader(path).notes())
    block = path.read_bytes()[found.offset :]
    kind, length, enterprise = struct.unpack_from("<III", block)
    assert (kind, enterprise) == (0x0BAD, 32473)
    assert block[12:20] == b"mikas/1\n"
    assert struct.unpack_from("<I", block, length - 4) == (length,)
    content = json.loads(block[20 : length - 4].rstrip(b"\0"))
    assert content == {"kind": "marker", "time": 2.5, "data": {"label": "hill"}}


def test_each_kind_of_note_holds_what_is_documented():
    parameters = [shipped().parameter(name) for name in ("FREQ", "TWAT")]
    plan = Plan((PlannedParameter(parameters[0]), PlannedParameter(parameters[1], 10)), "list")
    [alarm] = Alarms(shipped()).update({"TWAT": 150.0}, 7.0)
    passport = Passport(("A", None), ())
    why = Text("silence", "тишина")
    made = [
        note_of(UnitFound(1, 10, passport, adapter="FT232", echo=True)),
        catalog_note(1, "2.1"),
        note_of(PlanChanged(1, plan)),
        note_of(TextNote(2, "гора")),
        note_of(Marker(3)),
        note_of(Gap(4.0, 4.0, 6.0, why)),
        note_of(StateChanged(5.0, LineState.ECHO_ONLY, reason=why)),
        note_of(AdapterMoved(5.5, "/dev/ttyUSB1", "/dev/ttyUSB0")),
        note_of(ClockChanged(6.0, -3600.0, slept=False, before=7200.0, after=3600.0)),
        note_of(alarm),
        note_of(ParameterDropped(8.0, "TAIR", Limits(max_list=8, refused=[0x99]))),
        faults_note(9.0, [FaultReading(7.0, (13, 53)), FaultReading(8.5, (), erased=True)]),
        note_of(FaultReading(9.5, (13,))),
        car_note(10.0, CarDetails("Волга", "А123ВС", 154_000, "Гараж")),
        Note(Kind.TEST, 11.0, {"outcome": "pass"}),  # more in tests/guided
    ]
    assert {note.kind for note in made} == set(Kind)
    data = {note.kind: note.data for note in made}
    assert data[Kind.FAULTS]["readings"][0] == {"time": 7.0, "codes": [13, 53], "erased": False}
    assert data[Kind.UNIT]["passports"] == ["A", None]
    assert data[Kind.UNIT]["baud"] == 9600
    assert data[Kind.PLAN]["names"] == ["FREQ", "TWAT"]
    assert data[Kind.PLAN]["every"] == [1, 10]
    assert (data[Kind.PLAN]["method"], data[Kind.PLAN]["reading"]) == ("list", "corrected")
    assert data[Kind.GAP] == {
        "began": 4.0,
        "ended": 6.0,
        "reason": {"en": "silence", "ru": "тишина"},
    }
    assert data[Kind.STATE]["state"] == "echo-only"
    assert data[Kind.CLOCK] == {
        "seconds": -3600.0,
        "slept": False,
        "before": 7200.0,
        "after": 3600.0,
    }
    assert data[Kind.ALARM]["channel"] == "TWAT"
    assert data[Kind.ALARM]["value"] == 150.0
    assert data[Kind.LEARNT]["refused"] == [0x99]
    assert data[Kind.FAULTS_READ] == {"codes": [13], "erased": False}
    for note in made:  # each survives the way through the file
        assert blocks.read_block(blocks.block_of(note)) == note


def test_the_head_of_each_session_in_a_file_is_found(path):
    plan = Plan((PlannedParameter(shipped().parameter("FREQ")),), "stream")
    for session in range(2):
        with appending(path, url="sim:") as writer:
            write_session_header(
                writer,
                float(session),
                version_code=9 + session,
                passports=("П",) * 8,
                catalog_version="1",
                plan=plan if session else None,
            )
            writer.record(SENT, b"\x01\xff\x0d", 5.0)
            writer.note(catalog_note(9.0, "2"))
    found = notes(path)
    assert {note.recording for note in found} == {0, 1}
    first, second = (
        unit_of((note for note in found if note.recording == number), shipped())
        for number in range(2)
    )
    assert (first.version_code, second.version_code) == (9, 10)
    assert (first.method, first.names) == (None, ())
    assert second.method == "stream"
    assert second.catalog == "1"  # the head is what was written first
    assert unit_of([], shipped()) is None


def test_foreign_and_damaged_notes_are_passed_over(path):
    good = note_of(TextNote(1.0, "kept"))
    later = Note("weather", 2.0, {"rain": True})  # of a version to come
    tagged = [
        b"not json",
        b"[]",
        b'{"kind":1,"time":0,"data":{}}',
        b'{"kind":"note","time":NaN,"data":{}}',
        b'{"kind":"note","time":0,"data":7}',
        b'{"kind":"note"}',
        b'{"kind":"note","time":"nan","data":{}}',
        b'{"kind":"note","time":1e999,"data":{}}',
        b'{"kind":"gap","time":0,"data":{"began":1%s}}' % (b"0" * 400),
        b'{"kind":"faults","time":0,"data":{"readings":[{"time":1e999,"codes":[13]}]}}',
        b"\xff\xfe",
        b"[" * 100_000,
        b"",
    ]
    write_blocks(
        path,
        pcapng.Section(),
        pcapng.Interface(),
        pcapng.Custom(32473, b"somebody else's documentation"),
        pcapng.Custom(1, blocks.block_of(good).data),
        pcapng.Custom(blocks.ENTERPRISE, blocks.block_of(good).data, private=True),
        *(pcapng.Custom(blocks.ENTERPRISE, blocks.TAG + data) for data in tagged),
        blocks.block_of(good),
        blocks.block_of(later),
    )
    assert notes(path) == [good, later]
    assert [type(note.kind) for note in notes(path)] == [Kind, str]
    assert list(CaptureReader(path)) == []


def test_half_a_surrogate_pair_which_no_screen_shows_is_replaced():
    data = blocks.TAG + rb'{"kind":"marker","time":0,"data":{"label":"a\udcff \ud83d\ude97"}}'
    note = blocks.read_block(pcapng.Custom(blocks.ENTERPRISE, data))
    assert note == note_of(Marker(0.0, "a� 🚗"))


def test_notes_are_read_in_both_byte_orders_and_not_from_another_version(path):
    here, there = note_of(TextNote(1.0, "here")), note_of(TextNote(2.0, "there"))
    own = (pcapng.Section(), pcapng.Interface(), blocks.block_of(here))
    other = (pcapng.Section(version=(2, 0)), blocks.block_of(there))
    big, small = [b"".join(pcapng.encode(it, order) for it in own) for order in "><"]
    path.write_bytes(big + b"".join(map(pcapng.encode, other)) + small)
    assert notes(path) == [here, here]
    assert [note.recording for note in notes(path)] == [0, 2]


@given(st.binary(min_size=1, max_size=200), st.integers(0, 2000))
def test_damage_costs_only_the_notes_that_it_hits(damage, place):
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "line.pcapng"
        made = [note_of(TextNote(float(number), f"note {number}")) for number in range(20)]
        with CaptureWriter(path, url="sim:") as writer:
            for note in made:
                writer.note(note)
                writer.record(RECEIVED, b"abc", note.time)
        spans = [(note.offset, note) for note in CaptureReader(path).notes()]
        whole = bytearray(path.read_bytes())
        at = 300 + place % (len(whole) - 300)  # not the section's header: that names the format
        whole[at : at + len(damage)] = damage[: len(whole) - at]
        path.write_bytes(whole)
        read = notes(path)
        hit = [note for offset, note in spans if offset < at + len(damage) and at < offset + 120]
        spared = [note for note in made if note not in hit]
        assert [note for note in read if note in spared] == spared
        assert len(read) <= len(made)


def test_a_note_that_lies_across_the_windows_of_the_search_is_found():
    for shift in range(-40, 40, 4):
        section = pcapng.encode(pcapng.Section())
        room = (1 << 20) - 64 + shift - len(section) - 32
        filler = pcapng.encode(pcapng.EnhancedPacket(0, 0, bytes(room)))
        assert len(filler) == room + 32
        note = note_of(TextNote(1.0, "seam"))
        file = io.BytesIO(section + filler + pcapng.encode(blocks.block_of(note)) * 2)
        assert index(file).notes == [note, note]


@pytest.mark.parametrize("value", [nan, inf, b"bytes", object()])
def test_what_json_can_not_hold_is_refused_and_nothing_is_written(path, value):
    with CaptureWriter(path, url="sim:") as writer:
        before = path.stat().st_size
        with pytest.raises((ValueError, TypeError)):
            writer.note(Note("note", 0.0, {"x": value}))
        with pytest.raises(ValueError, match="JSON compliant"):
            writer.note(Note("note", nan))
        with pytest.raises(ValueError, match="too long"):
            writer.note(note_of(TextNote(0.0, "x" * blocks.LONGEST)))
        assert path.stat().st_size == before


def test_after_the_end_there_is_no_note(path):
    with CaptureWriter(path, url="sim:") as writer:
        pass
    with pytest.raises(CaptureError, match="over"):
        writer.note(note_of(Marker(0.0)))


KILLED = """
import itertools, sys
from mikas.recording import CaptureWriter
from mikas.recording.annotations.events import note_of
from mikas.sampling.events import Marker

writer = CaptureWriter(sys.argv[1], url="sim:")
for number in itertools.count(1):
    writer.note(note_of(Marker(number / 8, str(number))))
    print(number, flush=True)
"""


def test_a_note_is_safe_once_it_is_written(path):
    with subprocess.Popen(
        [sys.executable, "-c", KILLED, str(path)], stdout=subprocess.PIPE
    ) as program:
        try:
            for _ in range(100):
                program.stdout.readline()
        finally:
            program.kill()
        reported = 100 + program.stdout.read().count(b"\n")
    found = notes(path)
    assert len(found) >= reported
    assert [note.data["label"] for note in found] == [str(k) for k in range(1, len(found) + 1)]


tshark = pytest.mark.skipif(
    shutil.which("tshark") is None and not os.environ.get("MIKAS_REQUIRE_TSHARK"),
    reason="tshark is not installed",
)


@tshark
def test_tshark_passes_over_them_cleanly(path):
    with CaptureWriter(path, url="sim:") as writer:
        write_session_header(
            writer, 0.0, version_code=10, passports=("МИКАС",) * 8, catalog_version="1"
        )
        writer.record(SENT, b"\x01\xff\x0d", 0.0)
        writer.note(note_of(Marker(0.005, "между")))
        writer.record(RECEIVED, b"\x0a\xf6\x0d", 0.01)
    fields = ("-e", "frame.time_epoch", "-e", "data.data")
    shown = run("tshark", "-r", path, "-T", "fields", *fields, home=path.parent)
    lines = [line.split("\t") for line in shown.splitlines()]
    # Wireshark 4 lists a custom block as a line of its own, which has no time; older ones do not.
    timed = [line for line in lines if line[0]]
    assert timed == [["0.000000000", "01ff0d"], ["0.010000000", "0af60d"]]
    assert len(lines) in (2, 5)


@tshark
def test_an_editor_of_captures_keeps_them(path, tmp_path):
    copy = tmp_path / "copy.pcapng"
    made = [note_of(Marker(0.005, "x" * length)) for length in range(4)]
    with CaptureWriter(path, url="sim:") as writer:
        for note in made:
            writer.record(RECEIVED, b"\x0a\xf6\x0d", 0.01)
            writer.note(note)
    run("editcap", path, copy)
    assert notes(copy) == made
    assert len(packets(copy)) == 4


def run(*command, home=None):
    own = None if home is None else {**os.environ, "HOME": str(home)}  # without its user's plugins
    done = subprocess.run(command, env=own, check=True, capture_output=True, encoding="utf-8")
    for word in ("cut short", "corrupt", "damaged", "malformed"):
        assert word not in done.stderr.lower()
    return done.stdout
