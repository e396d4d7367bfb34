"""Which `01`s of a recording are data, and which the refusal of D10: what counts, live, counts."""

from __future__ import annotations

from functools import partial
from math import isnan

import pytest
from exchanges_reference import rows as reference_rows
from hypothesis import given, settings
from hypothesis import strategies as st
from table_harness import ParameterTable

from mikas.catalog import shipped
from mikas.framing import encode
from mikas.link.base import Direction
from mikas.recording.capture.reader import CaptureReader
from mikas.recording.capture.writer import CaptureWriter
from mikas.recording.exchanges.columns import matcher as capture
from mikas.recording.table import raw_recording

CATALOG = shipped()


def write(path, exchanges, *, apart=0.1, echo=True):
    """Each exchange is a request and the responses to it; None: one that is damaged."""
    with CaptureWriter(path, url="sim:") as writer:
        time = 0.0
        for request, *responses in exchanges:
            wire = encode(bytes.fromhex(request))
            writer.record(Direction.SENT, wire, time)
            if echo:
                writer.record(Direction.RECEIVED, wire, time + 0.005)
            for number, response in enumerate(responses):
                answer = b"\x77\x0d" if response is None else encode(bytes.fromhex(response))
                writer.record(Direction.RECEIVED, answer, time + 0.01 * (number + 1))
            time += apart + 0.01 * len(responses)


def table_in(path):
    """The values of each row by `ParameterTable`, and its channels."""
    table = ParameterTable(path, CATALOG)
    flat = []
    for stretch in table.rows():
        for row in range(len(stretch.times)):
            there = {name: float(column[row]) for name, column in stretch.values.items()}
            flat.append({name: value for name, value in there.items() if not isnan(value)})
    return flat, [channel.name for channel in table.channels]


def expected(path):
    flat = [
        {name: value for name, value in values.items() if not isnan(value)}
        for _, _, values in reference_rows(CaptureReader(path), CATALOG)
    ]
    names = {name for values in flat for name in values}
    return flat, [p.name for p in CATALOG.parameters if p.name in names]


def values_of(path, exchanges):
    write(path, exchanges)
    shown = table_in(path)
    assert shown == expected(path)
    return shown[0]


STREAMS = ["71", "7F", "80", "81", "82", "83"]


@pytest.mark.parametrize("stream", STREAMS)
def test_a_stream_of_one_code_that_is_refused_is_no_value(tmp_path, stream):
    path = tmp_path / "a.pcapng"
    exchanges = [(f"{stream}29", "01"), ("01", "0A"), (f"{stream}29", "01"), ("01", "0A")]
    assert values_of(path, exchanges) == [{}, {}]
    assert table_in(path)[1] == []


@pytest.mark.parametrize("stream", STREAMS)
def test_a_stream_of_one_code_that_goes_on_began_with_a_value(tmp_path, stream):
    rows = values_of(tmp_path / "a.pcapng", [(f"{stream}29", "01", "01", "02"), ("01", "0A")])
    assert rows == [{"FREQ": 40.0}, {"FREQ": 40.0}, {"FREQ": 80.0}]


def test_only_the_first_response_of_a_stream_can_be_a_refusal(tmp_path):
    exchanges = [("7129", "02", "01"), ("01", "0A"), ("7129", "0101", "01"), ("01", "0A")]
    assert values_of(tmp_path / "a.pcapng", exchanges) == [
        {"FREQ": 80.0},
        {"FREQ": 40.0},
        {},
        {"FREQ": 40.0},
    ]


def test_a_lone_01_that_is_followed_by_another_value_is_one(tmp_path):
    exchanges = [("6120", "01"), ("6120", "02"), ("6120", "01"), ("6120", "01"), ("6120", "03")]
    rows = values_of(tmp_path / "a.pcapng", exchanges)
    assert [row["THR"] for row in rows] == [1.0, 2.0, 1.0, 1.0, 3.0]


def test_a_lone_01_that_nothing_follows_is_none(tmp_path):
    path = tmp_path / "a.pcapng"
    exchanges = [("6120", "14"), ("6120", "01"), ("6120", "01"), ("611A", "01")]
    assert values_of(path, exchanges) == [{"THR": 20.0}, {}, {}, {}]
    assert table_in(path)[1] == ["THR"]


def test_asked_for_twice_at_once_it_is_confirmed(tmp_path):
    exchanges = [("6120", "14"), ("6120", "01"), ("612020", "0101"), ("6120", "01")]
    rows = values_of(tmp_path / "a.pcapng", exchanges)
    assert [row.get("THR") for row in rows] == [20.0, 1.0, 1.0, 1.0]


def test_asked_for_twice_at_once_it_is_refused(tmp_path):
    """And so are those behind it, even if the unit gives it again later on."""
    exchanges = [("6120", "14"), ("6120", "01"), ("612020", "01"), ("6120", "01"), ("6120", "15")]
    rows = values_of(tmp_path / "a.pcapng", [*exchanges, ("612020", "0101"), ("6120", "01")])
    values = [row.get("THR") for row in rows]
    assert values == [20.0, None, None, None, 21.0, 1.0, 1.0]


def test_a_01_among_others_confirms_what_follows(tmp_path):
    exchanges = [("612029", "0115"), ("6120", "01"), ("6120", "01")]
    rows = values_of(tmp_path / "a.pcapng", exchanges)
    assert [row.get("THR") for row in rows] == [1.0, 1.0, 1.0]


def test_a_unit_that_takes_one_at_a_time_and_goes_on_is_believed(tmp_path):
    """What asked twice did not get two, and took the 01 for a datum: it asks on."""
    exchanges = [("6120", "14"), ("6120", "01"), ("612020",), ("01", "0A")]
    exchanges += [("6120", "01"), ("6120", "01")]
    rows = values_of(tmp_path / "a.pcapng", exchanges)
    assert [row.get("THR") for row in rows] == [20.0, 1.0, 1.0, 1.0]


answers = st.sampled_from(["01", "01", "02", "0101", "0102", None])
exchange = st.one_of(
    st.tuples(st.sampled_from(["6120", "6107", "6129"]), answers),
    st.tuples(st.sampled_from(["612020", "612029", "610707"]), answers),
    st.tuples(st.sampled_from(["6420", "63"]), st.sampled_from(["00", "01", "05"])),
    st.tuples(st.just("01"), st.just("0A")),
    st.lists(answers, max_size=4).map(lambda them: ("7120", *them)),
    st.lists(answers, max_size=4).map(lambda them: ("8129", *them)),
)


@settings(max_examples=60)
@given(
    st.lists(exchange, min_size=1, max_size=40),
    st.booleans(),
    st.sampled_from([300, 2000, 1 << 20]),
)
def test_any_session_however_it_is_cut(tmp_path_factory, exchanges, echo, window):
    path = tmp_path_factory.mktemp("session") / "a.pcapng"
    write(path, exchanges, echo=echo)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(
            raw_recording, "read_exchanges", partial(capture.column_exchanges, window=window)
        )
        assert table_in(path) == expected(path)
