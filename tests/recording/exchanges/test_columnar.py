"""The columnar stage against the scalar one, whatever the line brought (D1, D13)."""

from __future__ import annotations

import numpy as np
from exchanges_reference import answers
from hypothesis import given
from hypothesis import strategies as st
from scalar_reference import FITTING, ScalarMatcher

from mikas.framing import encode
from mikas.i18n import Text
from mikas.link.base import Direction
from mikas.recording.capture.reader import Packet, Problem, Source
from mikas.recording.exchanges.columns.matcher import ColumnarMatcher
from mikas.recording.exchanges.columns.packets import Packets

SENT, RECEIVED = Direction.SENT, Direction.RECEIVED
LINE = Source(0, "sim:", baud=9600)

requests = st.sampled_from(
    [bytes.fromhex(it) for it in ("01", "611a", "611a29", "6311", "63", "641a29", "711a", "1111")]
)
wires = st.one_of(
    requests.map(encode),
    st.sampled_from([b"\x0a", b"\x09", b"\x00", b"\x01", b"\x7d", b"\x7d\x22", b""]).map(encode),
    st.binary(max_size=6).map(encode),
    st.binary(max_size=5),
    st.sampled_from([b"\xf3\x0d", b"\x0d", b"\xf3\x0d\x0d", b"\x61", b"\xc0\x40\x0d", b""]),
)
waits = st.sampled_from([0.0, 0.001, 0.01, 0.03, 0.3, 1.0])


@st.composite
def turns(draw):
    """Mostly a request, its echo and an answer, as (direction, data, wait)."""
    wire = encode(draw(requests))
    answer = encode(draw(st.sampled_from([b"\x0a", b"\x7d", b"\x7d\x22", b"\x00", b"\x11\x11"])))
    echo = draw(st.sampled_from([wire, wire, wire, b"", wire[:-1] + b"\x00"]))
    came = echo + draw(st.sampled_from([answer, answer, answer + answer, b"", answer[:2]]))
    at = draw(st.integers(0, len(came)))
    return [
        (SENT, wire, draw(waits)),
        (RECEIVED, came[:at], draw(waits)),
        (RECEIVED, came[at:], draw(waits)),
    ]


anything = st.tuples(st.sampled_from(Direction), wires, waits).map(lambda it: [it])
repeated = st.builds(lambda turn, count: turn * count, turns(), st.integers(2, 6))
problems = st.just([None])
lines = st.lists(st.one_of(turns(), turns(), repeated, anything, problems), max_size=14).map(
    lambda parts: [it for part in parts for it in part]
)


def made(line):
    now, items = 0.0, []
    for number, it in enumerate(line):
        if it is None:
            items.append(Problem(number, Text("broken", "сломано")))
            continue
        direction, data, wait = it
        now += wait
        items.append(Packet(direction, data, now, number, source=LINE))
    return items


def as_arrays(packets):
    data = b"".join(it.data for it in packets)
    lengths = np.array([len(it.data) for it in packets])
    return Packets(
        source=LINE,
        times=np.array([it.time for it in packets]),
        sent=np.array([it.direction is SENT for it in packets]),
        offsets=np.array([it.offset for it in packets]),
        buffer=np.frombuffer(data, np.uint8),
        at=lengths.cumsum() - lengths,
        lengths=lengths,
    )


def results(items, sizes, matcher, stretch):
    """The exchanges of stretches of these sizes in turn."""
    waiting, found = [], []

    def flush():
        if waiting:
            found.append(matcher.feed(stretch(waiting)))
            waiting.clear()

    for item in items:
        if isinstance(item, Problem):
            flush()
            matcher.matching.interrupt()
            continue
        waiting.append(item)
        if len(waiting) == sizes[0]:
            flush()
            sizes = [*sizes[1:], sizes[0]]
    flush()
    return found


def plain(found):
    """An interpretation as lists, request bodies in place of their numbers."""

    def bodies(numbers):
        return [found.bodies[number] if number >= 0 else None for number in numbers.tolist()]

    requests, responses, data = found.requests, found.responses, bytes(found.responses.bodies)
    places = zip(responses.starts.tolist(), responses.lengths.tolist(), strict=True)
    return {
        "requests": (requests.first, bodies(requests.numbers), requests.times.tolist()),
        "wires": (requests.lengths.tolist(), responses.wire_lengths.tolist()),
        "times": responses.times.tolist(),
        "answered": (responses.requests.tolist(), bodies(responses.numbers)),
        "after": responses.after.tolist(),
        "bodies": [data[start : start + length] for start, length in places],
        "damaged": found.damaged.tolist(),
        "counts": (found.echoes, found.raw_checksum),
        "when": (found.begin, found.end, list(found.gaps)),
    }


def columnar(items, sizes):
    return [plain(it) for it in results(items, sizes, ColumnarMatcher(LINE, FITTING), as_arrays)]


def scalar(items, sizes):
    return [plain(it) for it in results(items, sizes, ScalarMatcher(LINE), list)]


def matched(items, sizes):
    """(time, body, request) of each response, from stretches of these sizes in turn."""
    return [
        it
        for found in columnar(items, sizes)
        for it in zip(found["times"], found["bodies"], found["answered"][1], strict=True)
    ]


sizes_of_stretches = st.lists(st.sampled_from([1, 2, 3, 7, 20, 1000]), min_size=1, max_size=4)


@given(lines, sizes_of_stretches)
def test_columnar_and_scalar_come_to_the_same_result(line, sizes):
    items = made(line)
    assert columnar(items, sizes) == scalar(items, sizes)


@given(lines, sizes_of_stretches)
def test_the_same_answers_to_the_same_requests(line, sizes):
    items = made(line)
    expected = [(time, body, request) for _, time, body, request, *_ in answers(items)]
    assert matched(items, sizes) == expected


def test_behind_a_missing_part_only_a_stream_goes_on():
    def frames(first, answer):
        sent = encode(bytes.fromhex(first))
        return [(SENT, sent, 0.1), (RECEIVED, sent, 0.01), (RECEIVED, encode(answer), 0.01)]

    lost = [None, (RECEIVED, encode(b"\x55"), 0.01)]
    line = frames("01", b"\x0a") + frames("611a", b"\x7d") + lost + frames("711a", b"\x7d") + lost
    assert [request for _, _, request in matched(made(line), [100])] == [
        b"\x01",
        b"\x61\x1a",
        None,
        b"\x71\x1a",
        b"\x71\x1a",
    ]
