"""Streams that another tool has cut from their request: `editcap -r`, and what looks like one."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

import pytest

import mikas
from merged_harness import needs_wireshark, ran
from mikas.catalog import shipped
from mikas.errors import CaptureError
from mikas.framing import encode
from mikas.link.base import Direction
from mikas.recording import CaptureReader, CaptureWriter, Kind, Note
from mikas.recording.annotations.events import note_of
from mikas.recording.capture import blocks as pcapng
from mikas.recording.capture.notes import LEFT_OUT
from mikas.recording.capture.reader import Packet, Problem
from mikas.recording.exchanges.columns.matcher import column_exchanges
from mikas.recording.exchanges.turns import quick_exchanges
from mikas.recording.inspect import Describer, decode
from mikas.replay import load
from mikas.sampling.events import StateChanged
from mikas.sampling.plan import Plan, PlannedParameter
from session_header_harness import write_session_header

SENT = Direction.SENT
NAMES = ("FREQ", "TWAT", "RXX")
Item = Packet | Note


def plan_of(*names: str, method: str = "stream") -> Plan:
    return Plan(tuple(PlannedParameter(shipped().parameter(name)) for name in names), method)


@pytest.fixture(scope="module")
def drive(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A drive as the dashboard records it: its notes, `01`, a stream, other requests, a stream."""
    path = tmp_path_factory.mktemp("drive") / "drive.pcapng"
    url = "sim:?clock=simulated&scenario=city"
    with CaptureWriter(path, url=url) as sink, mikas.connect(url, sink=sink) as ecu:
        write_session_header(
            sink,
            ecu.tester.link.now(),
            version_code=10,
            passports=("A",) * 8,
            catalog_version=shipped().version,
            plan=plan_of(*NAMES),
        )
        sink.note(note_of(StateChanged(ecu.tester.link.now(), "sampling")))
        for _ in ecu.watch(*NAMES, method="stream", count=300):
            pass
        ecu.faults()
        for _ in ecu.watch(*NAMES, method="stream", count=100):
            pass
    return path


def items_of(path: Path) -> list[Item]:
    """Return packets and notes, in the order of the file."""
    packets = [it for it in CaptureReader(path) if isinstance(it, Packet)]
    return sorted([*packets, *CaptureReader(path).notes()], key=lambda it: it.offset)


def write(path: Path, items: list[Item]) -> Path:
    with CaptureWriter(path, url="sim:", overwrite=True) as sink:
        for it in items:
            if isinstance(it, Packet):
                sink.record(it.direction, it.data, it.time)
            else:
                sink.note(it)
    return path


def first_stream(items: list[Item]) -> int:
    """Return the place of the first request of a stream."""
    return next(
        at
        for at, it in enumerate(items)
        if isinstance(it, Packet) and it.direction is SENT and it.data[:1] == b"\x71"
    )


def values(path: Path) -> list[tuple[float, ...]]:
    recording = mikas.open(path)
    begin = recording.span[0] if recording.span else 0.0
    frame = recording.to_pandas().reindex(columns=NAMES).dropna()
    return [(round(begin + at, 6), *row) for at, row in zip(frame.index, frame.values, strict=True)]


def rows(found) -> list[tuple[bytes, bytes]]:
    """Return the responses to streams, each with its request, of arrays or turns."""
    return [
        (request, body)
        for it in found
        if not isinstance(it, Problem | Note)
        for _, request, body in it.answers([body for body in it.bodies if body[:1] == b"\x71"])
    ]


def load_or_refused(path: Path) -> None:
    """Let the replay take the file, or say that there is nothing to play."""
    with suppress(CaptureError):
        load(path)


def by_frames(path: Path) -> list[tuple[bytes, bytes]]:
    parts = decode(CaptureReader(path), lambda: Describer(shipped()))
    return [
        (it.request, it.frame.body)
        for it in parts
        if (getattr(it, "request", b"") or b"")[:1] == b"\x71"
    ]


def problems(path: Path) -> list[str]:
    return [it.text.en for it in CaptureReader(path) if isinstance(it, Problem)]


Cut = Callable[[list[Item]], list[Item]]


def without(begin: int, end: int) -> Cut:
    """Leave out packets, counted from the first stream's request on."""

    def cut(items: list[Item]) -> list[Item]:
        at = first_stream(items)
        return items[: at + begin] + items[at + end :]

    return cut


def front(count: int) -> Cut:
    """Leave out all packets up to that many behind the first stream's request."""

    def cut(items: list[Item]) -> list[Item]:
        at = first_stream(items)
        return [it for it in items[:at] if isinstance(it, Note)] + items[at + count :]

    return cut


CUTS = [without(0, 1), without(0, 2), without(0, 150), front(1), front(2), front(150)]


@pytest.mark.parametrize("cut", CUTS)
def test_a_stream_without_its_request_is_read_by_the_plan(tmp_path, drive: Path, cut: Cut) -> None:
    out = write(tmp_path / "cut.pcapng", cut(items_of(drive)))
    whole, found = values(drive), values(out)
    assert len(found) >= 248
    assert found == whole[-len(found) :]
    (problem,) = problems(out)
    assert problem.endswith("its values are read by the noted plan")
    size_of = shipped().size_of
    assert rows(column_exchanges(out, size_of)) == by_frames(out)
    assert rows(quick_exchanges(out, size_of)) == by_frames(out)
    load(out)


@needs_wireshark
@pytest.mark.parametrize("missing", [1, 2, 100])
def test_editcap_keeps_the_plan_and_not_the_request(tmp_path: Path, drive: Path, missing) -> None:
    out, at = tmp_path / "cut.pcapng", first_stream(items_of(drive))  # a note is a packet, too
    ran("editcap", "-r", drive, out, f"1-{at}", f"{at + missing + 1}-9999")
    found = values(out)
    assert len(found) >= 300
    assert found == values(drive)[-len(found) :]


def change(kind: Kind, **data: object) -> Cut:
    def cut(items: list[Item]) -> list[Item]:
        return [
            replace(it, data={**it.data, **data})
            if isinstance(it, Note) and it.kind == kind
            else it
            for it in front(10)(items)
        ]

    return cut


def leave_out(*kinds: Kind) -> Cut:
    return lambda items: [
        it for it in front(10)(items) if not (isinstance(it, Note) and it.kind in kinds)
    ]


def other_plan(*names: str) -> Note:
    return Note(Kind.PLAN, 1.0, {"method": "stream", "names": [*names]})


def inserted(note: Note, at: int) -> Cut:
    def cut(items: list[Item]) -> list[Item]:
        found = front(10)(items)
        number = len(found) + at if at < 0 else at
        return [*found[:number], note, *found[number:]]

    return cut


def moved(seconds: float, cut: Cut) -> Cut:
    """Let the stream be so much later than the notes in front of it."""

    def cut_and_moved(items: list[Item]) -> list[Item]:
        return [
            replace(it, time=it.time + seconds) if isinstance(it, Packet) else it
            for it in cut(items)
        ]

    return cut_and_moved


def only(count: int) -> Cut:
    """Nothing but so many responses, behind the end of one, and the notes in front."""

    def cut(items: list[Item]) -> list[Item]:
        found = front(10)(items)
        ends = [at for at, it in enumerate(found) if isinstance(it, Packet) and it.data[-1] == 13]
        return found[: ends[count] + 1]

    return cut


def other_request(items: list[Item]) -> list[Item]:
    """Another stream of the same length is requested behind the responses."""
    found = front(10)(items)
    at = first_stream(found)
    return [*found[:at], replace(found[at], data=encode(b"\x71\x29\x29\x29")), *found[at + 1 :]]


def not_ended(*sent: Item) -> Cut:
    """The unit goes on with the stream of the plan before: behind `01`, and behind the note."""

    def cut(items: list[Item]) -> list[Item]:
        at = first_stream(items)
        head, stream = items[:at], items[at : at + 40]
        time = stream[-1].time
        asked = Packet(SENT, b"\x01\xff\x0d", time, 0)
        echo = replace(asked, direction=Direction.RECEIVED)
        then = items[at + 40 : at + 200]
        note = Note(Kind.PLAN, time, {"method": "stream", "names": ["FREQ", "RXX", "TWAT"]})
        return [*head, *stream, asked, echo, *then[:1], note, *sent, *then[1:]]

    return cut


UNKNOWN = {
    "no plan": leave_out(Kind.PLAN),
    "no stream": change(Kind.PLAN, method="batch"),
    "unknown method": change(Kind.PLAN, method=[7]),
    "another length": change(Kind.PLAN, names=["FREQ", "TWAT"]),
    "an unknown name": change(Kind.PLAN, names=["FREQ", "TWAT", "NONE"]),
    "no names": change(Kind.PLAN, names=[]),
    "no list": change(Kind.PLAN, names="FREQ"),
    "no texts": change(Kind.PLAN, names=["FREQ", "TWAT", 7]),
    "another catalog": change(Kind.CATALOG, version="own"),
    "not sampled": change(Kind.STATE, state="echo-only"),
    "another stream requested next": other_request,
    "before the plan": moved(-1000.0, front(10)),
    "long after the plan": moved(1000.0, only(200)),
    "the latest plan is another": inserted(other_plan("FREQ", "TWAT"), 4),
}


@pytest.mark.parametrize("cut", UNKNOWN.values(), ids=UNKNOWN)
def test_a_stream_that_the_plan_does_not_tell_has_no_values_but_a_sentence(
    tmp_path: Path, drive: Path, cut: Cut
) -> None:
    items = cut(items_of(drive))
    out = write(tmp_path / "cut.pcapng", items)
    requests = [it.time for it in items if isinstance(it, Packet) and it.direction is SENT]
    (problem,) = problems(out)
    assert problem.endswith("it has no values")
    assert all(time > min(requests) for time, *_ in values(out)), values(out)[:3]
    load_or_refused(out)


KNOWN = {
    "long after the plan, requested again": moved(1000.0, front(10)),
    "no state": leave_out(Kind.STATE),
    "no catalog": leave_out(Kind.CATALOG),
    "another plan later": inserted(other_plan("FREQ", "TWAT"), -10),
    "as few as a stream has": only(3),
}


@pytest.mark.parametrize("cut", KNOWN.values(), ids=KNOWN)
def test_the_plan_of_that_place_is_enough(tmp_path: Path, drive: Path, cut: Cut) -> None:
    out = write(tmp_path / "cut.pcapng", cut(items_of(drive)))
    assert len(values(out)) >= 3
    assert len(problems(out)) == 1


@pytest.mark.parametrize("sent", [[], [Packet(SENT, b"\x01\xff\x0d", 0.0, 0)]])
def test_a_stream_that_did_not_end_is_not_of_the_next_plan(tmp_path, drive: Path, sent) -> None:
    out = write(tmp_path / "on.pcapng", not_ended(*sent)(items_of(drive)))
    assert not problems(out)
    assert {request for request, _ in by_frames(out)} == {b"\x71\x29\x1a\x07"}


def test_two_responses_are_no_stream(tmp_path: Path, drive: Path) -> None:
    out = write(tmp_path / "cut.pcapng", only(2)(items_of(drive)))
    assert not problems(out)
    assert not values(out)


def test_packets_without_a_direction_are_no_stream(tmp_path: Path) -> None:
    """What text2pcap makes."""
    path = tmp_path / "text.pcapng"
    packets = [pcapng.EnhancedPacket(0, number, encode(b"\x15\x7e\x04")) for number in range(30)]
    blocks = [pcapng.Section(), pcapng.Interface(), *packets]
    path.write_bytes(b"".join(map(pcapng.encode, blocks)))
    assert len(problems(path)) == 30
    assert not [it for it in problems(path) if "stream" in it]


def test_a_whole_recording_has_no_cut_stream(drive: Path) -> None:
    assert not problems(drive)
    assert len(values(drive)) >= 400


@pytest.mark.parametrize("stream", [["x", 300, -1, None], [0x71], "71", {}, [0x71, 0x29] * 5000])
def test_a_note_that_only_this_program_makes_is_harmless_in_a_file(
    tmp_path: Path, drive: Path, stream: object
) -> None:
    notes = [Note(LEFT_OUT, 0.0, {"stream": stream})]
    out = write(tmp_path / "cut.pcapng", [*notes, *leave_out(Kind.PLAN)(items_of(drive))])
    assert problems(out)
    assert not [it for it in CaptureReader(out).notes() if it.kind == LEFT_OUT]
    mikas.open(out).to_pandas()
    by_frames(out)
    load_or_refused(out)
