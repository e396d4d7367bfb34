"""Recorded sessions with a virtual unit as tables: what the client read, what `decode` reads."""

from __future__ import annotations

from contextlib import closing
from itertools import islice
from math import isnan
from pathlib import Path
from random import Random

import numpy as np
from exchanges_reference import rows as reference_rows
from hypothesis import given, settings
from hypothesis import strategies as st
from table_harness import ParameterTable

from capture_writing_harness import appending
from mikas import tester as testers
from mikas.catalog import load, shipped
from mikas.client import Ecu
from mikas.errors import MikasError
from mikas.framing import Decoder, encode
from mikas.link import Chunk
from mikas.link.base import CaptureTee, Direction
from mikas.link.virtual import VirtualLink
from mikas.recording.capture.reader import CaptureReader, Problem
from mikas.recording.capture.writer import CaptureWriter
from mikas.tester.exchange import TimedDecoder
from mikas.virtual.bus import AdapterKind, Bus
from mikas.virtual.ecu import VirtualEcu
from mikas.virtual.fault_injector import FaultInjector, LineFault
from mikas.virtual.responder import Identity, Responder
from virtual_harness import TableCar

CATALOG = shipped()
NAMES = [p.name for p in CATALOG.parameters]
METHODS = ["single", "batch", "list", "stream", "stroke0", "stroke3"]
READINGS = ["corrected", "literal", "alternative", "family"]


class RestlessCar(TableCar):
    """No datum is ever the same again, so a value in the wrong place can't pass for a right one.

    None is 01, which D10 knows as a refusal too: the client asks again then, and drops the first.
    """

    def __init__(self) -> None:
        super().__init__({code: bytes(size) for code, size in CATALOG.codes}, rpm=3000.0)

    def raw(self, code: int, now: float) -> bytes:
        datum = Random(f"{code} {now}").randbytes(self.size_of(code))
        return b"\x02" if datum == b"\x01" else datum


def record(path, steps, *, adapter=None, fault_injector=None, interpretation="corrected"):
    """Runs the steps (method, names, count) and returns every reading that the client gave."""
    unit = VirtualEcu(Responder(RestlessCar(), Identity(0x0A)))
    link = VirtualLink(Bus(unit, adapter=adapter, fault_injector=fault_injector), start=1000.0)
    readings = []
    with appending(path, url="sim:") as writer:
        tester = testers.Tester(CaptureTee(link, writer))
        with Ecu(tester, CATALOG, interpretation=interpretation) as ecu:
            try:
                tester.connect()
                for method, names, count in steps:
                    with closing(ecu.watch(*names, method=method)) as samples:
                        for sample in islice(samples, count):
                            readings += sample.readings.values()
                    ecu.faults()
            except MikasError:
                pass  # the line was too bad; what was recorded up to there counts
    return readings


def table_of(path, catalog=CATALOG, interpretation="corrected", size=65536):
    """(time, values by name that are no NaN) of each row; the names of the channels."""
    table = ParameterTable(path, catalog, interpretation)
    flat = []
    for stretch in table.rows(size):
        assert 0 < len(stretch.times) <= size
        assert (np.diff(stretch.times) >= 0).all()
        assert list(stretch.values) == [channel.name for channel in table.channels]
        for row, time in enumerate(stretch.times.tolist()):
            values = {name: float(column[row]) for name, column in stretch.values.items()}
            flat.append((time, {name: v for name, v in values.items() if not isnan(v)}))
    return flat, [channel.name for channel in table.channels]


def wanted_of(path, catalog=CATALOG, interpretation="corrected"):
    flat, decoded = [], set()
    for _, time, values in reference_rows(CaptureReader(path), catalog, interpretation):
        there = {name: v for name, v in values.items() if not isnan(v)}
        flat.append((time, there))
        decoded.update(there)
    return flat, [p.name for p in catalog.parameters if p.name in decoded]


def same_values(shown, wanted):
    """Bit for bit; times to the lump (lumps may seem to overlap; times are kept rising)."""
    assert [values for _, values in shown] == [values for _, values in wanted]
    assert np.allclose([t for t, _ in shown], [t for t, _ in wanted], rtol=0, atol=0.1)


def all_found(readings, table, tolerance):
    """Each reading stands in the row of its time."""
    times = np.array([time for time, _ in table])
    for reading in readings:
        if reading.raw == b"\x01":
            continue  # a lone one may count as a refusal (D10)
        near = (np.abs(times - reading.time) <= tolerance).nonzero()[0]
        values = [table[row][1].get(reading.name) for row in near]
        assert float(reading.value) in values, (reading, values)


names = st.lists(st.sampled_from(NAMES), min_size=1, max_size=23, unique=True)
steps = st.lists(
    st.tuples(st.sampled_from(METHODS), st.one_of(names, st.just(NAMES)), st.integers(1, 4)),
    min_size=1,
    max_size=4,
)
adapters = st.builds(AdapterKind, echo=st.booleans(), latency=st.sampled_from([0.0, 0.016]))


@settings(max_examples=30)
@given(steps, adapters, st.sampled_from(READINGS))
def test_the_table_of_a_clean_session_has_the_values_read_live(
    tmp_path_factory, plan, adapter, interpretation
):
    path = tmp_path_factory.mktemp("session") / "line.pcapng"
    readings = record(path, plan, adapter=adapter, interpretation=interpretation)
    shown, channels = table_of(path, interpretation=interpretation)
    wanted, decoded = wanted_of(path, interpretation=interpretation)
    assert channels == decoded
    same_values(shown, wanted)
    all_found(readings, shown, 0.02 if adapter.latency else 2e-6)
    # Nothing else stands there than what was read, but for what a stream sent while it was ended.
    if not any(method.startswith("str") for method, _, _ in plan):
        read = {(r.name, float(r.value)) for r in readings}
        asked = {name for _, asked, _ in plan for name in asked}
        # FREQ is asked by the client itself, to see whether the unit answers at all; and parameters
        # that share a byte come with each other, asked or not.
        probes = {"FREQ", "RXX", "BITPOW", "RDET"}
        values = {pair for _, row in shown for pair in row.items()}
        assert {pair for pair in values if pair[0] in asked - probes} <= read


@settings(max_examples=30)
@given(steps, adapters, st.integers(0, 999), st.sampled_from([0.02, 0.1, 0.3]), st.data())
def test_the_table_of_a_disturbed_session_has_the_values_of_the_reference(
    tmp_path_factory, plan, adapter, seed, rate, data
):
    path = tmp_path_factory.mktemp("session") / "line.pcapng"
    kinds = data.draw(st.lists(st.sampled_from(LineFault), min_size=1, unique=True))
    rates = dict.fromkeys(kinds, rate / len(kinds))
    readings = record(path, plan, adapter=adapter, fault_injector=FaultInjector(rates, seed=seed))
    shown, channels = table_of(path, size=data.draw(st.sampled_from([1, 3, 50, 65536])))
    wanted, decoded = wanted_of(path)
    assert channels == decoded
    same_values(shown, wanted)
    all_found(readings, shown, 0.05)


def test_the_table_of_a_long_session_has_the_values_of_every_method(tmp_path):
    path = tmp_path / "line.pcapng"
    plan = [(method, NAMES, 60) for method in METHODS]
    readings = record(path, plan)
    shown, _ = table_of(path, size=100)
    same_values(shown, wanted_of(path)[0])
    all_found(readings, shown, 2e-6)


@settings(max_examples=30)
@given(steps, st.lists(st.tuples(st.floats(0, 1), st.integers(1, 255)), min_size=1, max_size=8))
def test_the_table_of_a_damaged_file_has_the_values_and_problems_of_the_reference(
    tmp_path_factory, plan, wounds
):
    path = tmp_path_factory.mktemp("session") / "line.pcapng"
    record(path, plan)
    data = bytearray(path.read_bytes())
    for place, bits in wounds:
        data[min(len(data) - 1, 64 + int(place * (len(data) - 64)))] ^= bits
    path.write_bytes(data[: len(data) - wounds[0][1] % 3 * 17])
    shown, channels = table_of(path, size=1000)
    wanted, decoded = wanted_of(path)
    assert channels == decoded
    assert [values for _, values in shown] == [values for _, values in wanted]
    problems = [item for item in CaptureReader(path) if isinstance(item, Problem)]
    assert ParameterTable(path, CATALOG).raw.problems == problems


def test_two_recordings_in_a_file_do_not_mix(tmp_path):
    path = tmp_path / "line.pcapng"
    record(path, [("batch", ["TWAT", "FREQ"], 3)])
    record(path, [("list", ["UACC"], 3)])  # time starts again
    table = ParameterTable(path, CATALOG)
    (first, _), (second, rows) = table.stretches()
    assert (first.recording, second.recording) == (0, 1)
    assert np.isnan(rows.values["TWAT"]).all()
    assert not np.isnan(rows.values["UACC"]).any()


OWN = """
version = "1"

[parameter.TWAT]
code = 0x1A
size = 1
text = { en = "coolant", ru = "ОЖ" }
unit = "°C"
offset = -50
source = "my own measurement"
confidence = "reported"
"""


def test_a_changed_definition_reads_old_recordings_anew(tmp_path):
    path = tmp_path / "line.pcapng"
    record(path, [("batch", ["TWAT"], 5)])
    own = own_catalog(tmp_path)
    before, after = table_of(path)[0], table_of(path, own)[0]
    assert [row["TWAT"] - 10 for _, row in before] == [row["TWAT"] for _, row in after]
    same_values(after, wanted_of(path, own)[0])


def own_catalog(folder: Path):
    file = folder / "own.toml"
    file.write_text(OWN, encoding="utf-8")
    return load(file)


def test_channels_say_what_they_are(tmp_path):
    path = tmp_path / "line.pcapng"
    record(path, [("batch", ["RXX", "FREQ"], 2)])
    table = ParameterTable(path, CATALOG, "literal")
    channels, rows, problems = table.channels, table.rows(), table.raw.problems
    parameters = {p.name: p for p in CATALOG.parameters}
    assert [c.name for c in channels] == [n for n in NAMES if parameters[n].code in (0x07, 0x29)]
    speed = next(c for c in channels if c.name == "FREQ")
    assert speed.unit == parameters["FREQ"].literal.unit  # E1: the source's own
    assert [c.is_flag for c in channels] == [parameters[c.name].is_flag for c in channels]
    (stretch,) = rows
    assert set(np.unique(stretch.values["RXX"])) <= {0.0, 1.0}
    assert problems == []


@given(
    held_up=st.lists(st.sampled_from([0.0, 0.0, 0.004, 0.05, 0.2]), min_size=1, max_size=9),
    lump=st.integers(1, 40),
    size=st.sampled_from([3, 65536]),
)
def test_late_responses_in_one_chunk_have_the_times_that_they_had_live(
    tmp_path_factory, held_up, lump, size
):
    """They rise, so that no table has two rows at one time."""
    byte_time = 10 / 9600
    codes = bytes([code for code, size in CATALOG.codes if size == 1][:2])
    wire, request = encode(b"\x85\x7d") * 30, encode(b"\x71" + codes)
    path = tmp_path_factory.mktemp("late") / "line.pcapng"
    decoder, live, now = TimedDecoder(Decoder(), byte_time), [], 1000.0
    with CaptureWriter(path, url="sim:") as writer:
        writer.record(Direction.SENT, request, now)
        writer.record(Direction.RECEIVED, request, now)
        for number, begin in enumerate(range(0, len(wire), lump)):
            data = wire[begin : begin + lump]
            late = held_up[number % len(held_up)]
            # As a recording keeps it, in whole microseconds.
            now = round(max(now, 1000 + (begin + len(data)) * byte_time + late), 6)
            writer.record(Direction.RECEIVED, data, now)
            live += [began for _, began in decoder.feed(Chunk(data, now))]
    times = np.array([time for time, _ in table_of(path, size=size)[0]])
    assert (np.diff(times) > 0).all()
    np.testing.assert_allclose(times, live, rtol=0, atol=2 * byte_time)  # rounded another way
