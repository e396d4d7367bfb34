"""One result, by columns, by turns or frame by frame, and over the arrays of the browser."""

from __future__ import annotations

import subprocess
import sys

from hypothesis import given, settings
from hypothesis import strategies as st
from refusals_reference import RefusalResolver
from scalar_reference import scalar_exchanges
from test_columnar import plain
from test_refusals import exchange, write
from test_table_sessions import adapters, record, steps

from mikas.catalog import shipped
from mikas.recording.capture.reader import Problem
from mikas.recording.exchanges.columns.matcher import column_exchanges
from mikas.recording.exchanges.groups import ResponseClassifier
from mikas.recording.exchanges.layouts import READ_LIST, Layouts
from mikas.recording.exchanges.refusals import RefusalColumns
from mikas.recording.exchanges.turns import quick_exchanges
from mikas.virtual.fault_injector import FaultInjector, LineFault

LAYOUTS = Layouts(shipped().size_of)


def joined(items):
    """The results of all stretches of each port as one; and how many problems there are."""
    whole, problems = {}, 0
    for item in items:
        if isinstance(item, Problem):
            problems += 1
            continue
        stretch = plain(item)
        first, bodies, times = stretch["requests"]
        found = whole.setdefault(item.source, {"when": [], "requests": [], "rest": {}})
        found["when"] += stretch["when"][2]
        found["requests"] += zip(bodies, times, stretch["wires"][0], strict=True)
        assert first == len(found["requests"]) - len(bodies)
        for name in ("times", "after", "bodies", "damaged"):
            found["rest"].setdefault(name, []).extend(stretch[name])
        found["rest"].setdefault("answered", []).extend(zip(*stretch["answered"], strict=True))
        echoes, raw = found["rest"].get("counts", (0, False))
        found["rest"]["counts"] = echoes + stretch["counts"][0], raw or stretch["counts"][1]
    return whole, problems


def same(path):
    reference = joined(scalar_exchanges(path))
    assert joined(column_exchanges(path, shipped().size_of)) == reference
    assert joined(quick_exchanges(path, shipped().size_of)) == reference


@settings(max_examples=15)
@given(
    steps,
    adapters,
    st.sampled_from([0.0, 0.02, 0.3]),
    st.integers(0, 99),
    st.lists(st.tuples(st.floats(0, 1), st.integers(1, 255)), max_size=4),
)
def test_columns_and_the_reference_agree_on_sessions_with_a_virtual_unit(
    tmp_path_factory, plan, adapter, rate, seed, wounds
):
    path = tmp_path_factory.mktemp("session") / "line.pcapng"
    faults = FaultInjector(dict.fromkeys(LineFault, rate / len(LineFault)), seed=seed)
    record(path, plan, adapter=adapter, fault_injector=faults)
    record(path, plan[:1])
    same(path)
    data = bytearray(path.read_bytes())
    for place, bits in wounds:
        data[min(len(data) - 1, 64 + int(place * (len(data) - 64)))] ^= bits
    path.write_bytes(data)
    same(path)


def refused_by_columns(path):
    """Times of the doubtful responses that do not count."""
    classifier, refusals, times = ResponseClassifier(LAYOUTS), None, []
    for item in column_exchanges(path, shipped().size_of):
        refusals = refusals or RefusalColumns(item.bodies)
        refusals.add_responses(list(classifier.groups(item)), item.responses)
        times += item.responses.times.tolist()
    if refusals is None:
        return set()
    refusals.conclude()
    return {times[number] for number in refusals.refused}


def refused_in_order(path):
    refused = set()
    resolver = RefusalResolver(lambda time, counts: None if counts else refused.add(time))
    listed, setting = None, None
    for item in scalar_exchanges(path):
        responses, sent = item.responses, item.requests.first
        for row, serial in enumerate(responses.requests.tolist()):
            while sent <= responses.after[row]:
                request = item.bodies[item.requests.numbers[sent - item.requests.first]]
                resolver.sent(request)
                if request[:1] == b"\x64":
                    listed, setting = None, request
                sent += 1
            if responses.numbers[row] < 0:
                continue
            request = item.bodies[responses.numbers[row]]
            body = responses.body(row)
            if request == setting and body == b"\x00":
                listed = LAYOUTS.layout_of(request)
            layout = listed if request == READ_LIST else LAYOUTS.layout_of(request)
            if layout is not None and request[:1] != b"\x64":
                resolver.is_certain_value(responses.times[row], request, serial, layout, body)
        for number in item.requests.numbers[sent - item.requests.first :]:
            resolver.sent(item.bodies[number])
    resolver.conclude()
    return refused


@settings(max_examples=80)
@given(st.lists(exchange, min_size=1, max_size=40), st.booleans())
def test_the_same_verdicts_on_lone_01s(tmp_path_factory, exchanges, echo):
    path = tmp_path_factory.mktemp("session") / "a.pcapng"
    write(path, exchanges, echo=echo)
    assert refused_by_columns(path) == refused_in_order(path)


IN_A_BROWSER = """
import sys

from mikas.browser.arrays import install

install()
from mikas.catalog import shipped
from mikas.recording.exchanges import read_exchanges
from mikas.recording.inspect import decode
from mikas.recording.capture.reader import CaptureReader
from mikas.replay import load

path = sys.argv[1]
assert sum(len(item.responses.times) for item in read_exchanges(path, shipped().size_of)) > 0
assert any(True for _ in decode(CaptureReader(path)))
print(load(path).frames)
"""


def test_over_the_arrays_of_a_browser_it_is_read_by_turns(tmp_path):
    path = tmp_path / "a.pcapng"
    write(path, [("6129", "15"), ("6120", "14"), ("01", "0A")])
    command = [sys.executable, "-c", IN_A_BROWSER, str(path)]
    ran = subprocess.run(command, check=False, capture_output=True, text=True, timeout=120)
    assert (ran.returncode, ran.stdout.strip()) == (0, "3"), ran.stderr
