"""Recordings whose packets have other times than their notes: `editcap -t`, and what is not one."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import mikas
from merged_harness import MICRO, needs_wireshark, ran, record, shifted
from mikas.i18n import Text
from mikas.link.base import Direction
from mikas.recording import CaptureWriter
from mikas.recording.annotations.events import comment_note, comment_of, note_of
from mikas.recording.capture import blocks as pcapng
from mikas.recording.capture.reader import CaptureReader, Packet, Problem
from mikas.recording.capture.scan import RawBlock, scan
from mikas.recording.capture.writer import append_note
from mikas.sampling.events import ClockChanged, Gap, Marker, StateChanged

ONE = "A111AA52"
WHY = Text("silence", "тишина")


@pytest.fixture(scope="module")
def drive(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return make(tmp_path_factory.mktemp("drive"), "drive")


def make(folder: Path, name: str, *extra: ClockChanged, begun: float = 1000.0) -> Path:
    """Record a drive with states, a gap and a marker between its packets, a comment behind them."""
    plain, path = folder / f"{name}-plain.pcapng", folder / f"{name}.pcapng"
    record(plain, ONE, count=100, head=False)
    with CaptureWriter(path, url="/dev/ttyUSB0") as sink:
        for number, packet in enumerate(packets(plain)):
            time = packet.time + begun + number // 30
            sink.record(packet.direction, packet.data, time)
            if number % 90 == 0:
                sink.note(note_of(StateChanged(time + 0.001, "sampling")))
            if number == 200:
                sink.note(note_of(Gap(time - 3.0, time - 3.0, time, WHY)))
                sink.note(note_of(Marker(time + 0.002, "hill")))
                for event in extra:
                    sink.note(note_of(replace(event, time=time)))
    append_note(path, comment_note(begun, "mine"))
    return path


def packets(path: Path) -> list[Packet]:
    return [it for it in CaptureReader(path) if isinstance(it, Packet)]


def shift(path: Path, out: Path, seconds: float) -> Path:
    """Do what `editcap -t` does."""
    data = b""
    with path.open("rb") as file:
        for item in scan(file):
            assert isinstance(item, RawBlock)
            block = pcapng.parse(item.kind, item.body, item.order)
            assert block is not None
            if isinstance(block, pcapng.EnhancedPacket):
                block = replace(block, ticks=block.ticks + round(seconds * MICRO))
            data += pcapng.encode(block, item.order)
    out.write_bytes(data)
    return out


def edited(path: Path, out: Path, seconds: float) -> Path:
    ran("editcap", "-t", seconds, path, out)
    return out


def values(path: Path) -> list[tuple[float, object]]:
    return list(mikas.open(path).to_pandas()["FREQ"].dropna().items())


def moments(path: Path) -> list[tuple[float, object]]:
    """Return the times of the notes of moments, and those in them."""
    return [
        (time, type(it).__name__)
        for it in mikas.open(path).events
        for time in [it.time, *([it.began] if isinstance(it, Gap) else [])]
    ]


def problems(path: Path) -> list[str]:
    return [it.text.en for it in CaptureReader(path) if isinstance(it, Problem)]


def later(items: list[tuple[float, object]], seconds: float) -> list[tuple[float, object]]:
    return [(time + seconds, rest) for time, rest in items]


def close(found: list[tuple[float, object]], expected: list[tuple[float, object]]) -> bool:
    times = [time for time, _ in expected]
    same = [rest for _, rest in found] == [rest for _, rest in expected]
    return same and [time for time, _ in found] == pytest.approx(times, abs=1e-3)


@pytest.mark.parametrize("tool", [shift, pytest.param(edited, marks=needs_wireshark)])
@pytest.mark.parametrize("text", ["+3600", "+1", "-5", "-900.25", "+1000000000"])
def test_notes_follow_their_packets(tmp_path: Path, drive: Path, tool, text: str) -> None:
    """A gap and a marker stood an hour beside their values, in silence."""
    seconds = float(text)
    out = tool(drive, tmp_path / "shifted.pcapng", seconds)
    assert close(values(out), values(drive))
    assert mikas.open(out).span[0] == pytest.approx(mikas.open(drive).span[0] + seconds)
    assert close(moments(out), later(moments(drive), seconds))
    assert comment_of(mikas.open(out).notes) == "mine"
    (problem,) = problems(out)
    assert f"by {text} s; the notes follow" in problem
    assert not problems(drive)
    assert not [it for it in CaptureReader(out).notes() if it.kind == "left-out"]


def test_a_note_that_is_added_to_a_shifted_file_has_its_time(tmp_path: Path, drive: Path) -> None:
    out = shift(drive, tmp_path / "shifted.pcapng", 3600.0)
    time = mikas.open(out).span[1] - 0.5
    append_note(out, note_of(Marker(time, "added")))
    [marker] = [it for it in mikas.open(out).events if getattr(it, "label", "") == "added"]
    assert marker.time == pytest.approx(time, abs=1e-6)


@pytest.mark.parametrize("seconds", [5, 3600])
def test_shifting_packets_and_notes_changes_nothing(tmp_path: Path, drive: Path, seconds) -> None:
    out = shifted(drive, tmp_path / "shifted.pcapng", seconds)
    assert not problems(out)
    assert close(moments(out), later(moments(drive), seconds))


@needs_wireshark
@pytest.mark.parametrize(
    "tool", ["editcap IN OUT", "editcap -r IN OUT 1-150 300-400", "editcap -s 30 IN OUT",
             "editcap -d IN OUT", "mergecap -w OUT IN", "mergecap -a -w OUT IN"]
)  # fmt: skip
def test_what_a_tool_copies_or_cuts_is_not_shifted(tmp_path: Path, drive: Path, tool: str) -> None:
    out = tmp_path / "out.pcapng"
    ran(*({"IN": drive, "OUT": out}.get(word, word) for word in tool.split()))
    assert not [it for it in problems(out) if "shifted" in it]
    kept = moments(drive)  # to `editcap -r` a note is a packet, too
    assert moments(out) == ([it for it in kept if it in moments(out)] if "-r" in tool else kept)


@pytest.mark.parametrize("join", ["cat", pytest.param("mergecap", marks=needs_wireshark),
                                  pytest.param("mergecap -a", marks=needs_wireshark)])  # fmt: skip
def test_a_part_that_was_shifted_costs_the_other_no_note(
    tmp_path: Path, drive: Path, join: str
) -> None:
    out, both = shift(drive, tmp_path / "shifted.pcapng", 3600.0), tmp_path / "both.pcapng"
    if join == "cat":
        both.write_bytes(drive.read_bytes() + out.read_bytes())
    else:
        ran(*join.split(), "-w", both, drive, out)
    assert close(moments(both), moments(drive) + later(moments(drive), 3600.0))
    assert len(problems(both)) == 1


def test_shifted_packets_have_the_date_that_was_given_to_them(tmp_path: Path) -> None:
    """A Pi without a battery: its date is put right with editcap, though a note does that, too."""
    pi = make(tmp_path, "pi", ClockChanged(0.0, 1e9, slept=False, before=0.0, after=1e9))
    assert mikas.open(pi).span[0] > 1e9
    out = shift(pi, tmp_path / "shifted.pcapng", 1.2e9)
    begin, end = mikas.open(out).span
    assert 1.2e9 < begin < end < 1.2e9 + 2000
    assert all(begin - 1 < time < end + 1 for time, _ in moments(out))
    assert any("notes (1) are left out" in it for it in problems(out))


def test_the_seconds_are_those_that_were_given(tmp_path: Path) -> None:
    """A note of a real line is stamped 2 ms before the packet that it follows is."""
    path = tmp_path / "line.pcapng"
    with CaptureWriter(path, url="/dev/ttyUSB0") as sink:
        for time in (1.0, 2.0, 3.0, 4.0):
            sink.record(Direction.RECEIVED, b"\x0a\xf6\x0d", time)
            sink.note(note_of(StateChanged(time - 0.002, "sampling")))
            sink.record(Direction.SENT, b"\x01\xff\x0d", time + 0.001)
    (problem,) = problems(shift(path, tmp_path / "shifted.pcapng", 7.0))
    assert "by +7 s" in problem


def test_a_silent_line_and_a_user_who_waits_are_no_shift(tmp_path: Path) -> None:
    path = tmp_path / "silent.pcapng"
    with CaptureWriter(path, url="/dev/ttyUSB0") as sink:
        sink.note(note_of(StateChanged(0.0, "no-port")))
        for time in (600.0, 4000.0):
            sink.record(Direction.SENT, b"\x01\xff\x0d", time)
            sink.note(note_of(StateChanged(time + 900.0, "no-echo", reason=WHY)))
    append_note(path, note_of(Marker(601.0, "later")))
    assert not problems(path)
    assert sorted(it.time for it in mikas.open(path).events) == [0.0, 601.0, 1500.0, 4900.0]


steps = st.floats(0.0, 900.0) | st.floats(0.0, 0.1)


@settings(max_examples=60, deadline=None)
@given(
    st.lists(st.tuples(st.sampled_from(["packet", "state", "marker"]), steps, steps), max_size=20),
    st.lists(st.integers(0, 19), max_size=1),
)
def test_no_recording_of_our_own_is_taken_for_a_shifted_one(tmp_path_factory, items, stopped):
    """The clock goes on by any step, also between the time of a note and its way to the file: a
    computer that is slow, or slept. Once, another thread has written packets meanwhile.
    """
    path, now, made = tmp_path_factory.mktemp("own") / "own.pcapng", 0.0, []
    with CaptureWriter(path, url="/dev/ttyUSB0") as sink:
        for number, (kind, step, late) in enumerate(items):
            now += step
            event = StateChanged(now, "sampling") if kind == "state" else Marker(now, "x")
            if number in stopped:
                now += late
                sink.record(Direction.SENT, b"\x01\xff\x0d", now)
            if kind == "packet":
                sink.record(Direction.RECEIVED, b"\x01\xff\x0d", now)
            else:
                sink.note(note_of(event))
                made.append(event.time)
    assert not [it for it in problems(path) if "shifted" in it]
    assert [note.time for note in CaptureReader(path).notes()] == made
