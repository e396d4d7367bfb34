"""No value comes out of a recording that the tester, on the same bytes, has refused (D1, D13)."""

from __future__ import annotations

from contextlib import closing
from itertools import islice

from hypothesis import example, given, settings
from hypothesis import strategies as st
from test_table_sessions import CATALOG, NAMES, RestlessCar, adapters

from capture_writing_harness import appending
from mikas import tester as testers
from mikas.client import Ecu
from mikas.errors import MikasError
from mikas.link.base import CaptureTee, Direction
from mikas.link.virtual import VirtualLink
from mikas.recording.capture.reader import CaptureReader
from mikas.recording.exchanges.columns.matcher import column_exchanges
from mikas.recording.exchanges.fitting import Fitting
from mikas.recording.exchanges.scalar import DecodedFrame
from mikas.recording.exchanges.turns import quick_exchanges
from mikas.recording.inspect import decode
from mikas.virtual.bus import AdapterKind, Bus
from mikas.virtual.ecu import VirtualEcu
from mikas.virtual.fault_injector import FaultInjector, LineFault
from mikas.virtual.responder import Identity, Responder

STREAMS = {0x71, 0x7F, 0x80, 0x81, 0x82, 0x83}


class WatchedTester(testers.Tester):
    """Keeps what it accepted: (request, response) as bodies."""

    def __init__(self, link, **options) -> None:
        super().__init__(link, **options)
        self.accepted: list[tuple[bytes, bytes]] = []

    def _once(self, command, wire):
        value, reply = super()._once(command, wire)
        self.accepted.append((command.body(), reply.body))
        return value, reply


def session(path, plan, *, adapter, faults, timing=None):
    """Run the plan (method, names, count) over a bad line; return what the tester accepted."""
    unit = VirtualEcu(Responder(RestlessCar(), Identity(0x0A)))
    link = VirtualLink(Bus(unit, adapter=adapter, fault_injector=faults), start=1000.0)
    with appending(path, url="sim:") as writer:
        tester = WatchedTester(CaptureTee(link, writer), timing=timing)
        with Ecu(tester, CATALOG) as ecu:
            for method, names, count in plan:
                try:
                    if tester.version_code is None:
                        tester.connect()
                    with closing(ecu.watch(*names, method=method)) as samples:
                        for _ in islice(samples, count):
                            pass
                    ecu.faults()
                except MikasError:
                    continue
    return tester.accepted


def by_decode(path):
    return [
        (item.request, item.frame.body)
        for item in decode(CaptureReader(path))
        if isinstance(item, DecodedFrame)
        and item.direction is Direction.RECEIVED
        and item.request is not None
    ]


def by_arrays(path, matcher):
    return [
        (item.bodies[number], item.responses.body(row))
        for item in matcher(path, CATALOG.size_of)
        for row, number in enumerate(item.responses.numbers.tolist())
        if number >= 0
    ]


def counted(pairs):
    """Leave out what gives no value by itself: the version, streams, and what does not fit."""
    fitting, listed = Fitting(CATALOG.size_of), None
    for request, response in pairs:
        if request[0] == 0x64:
            listed = fitting.list_length(request) if response == b"\x00" else None
        if request == b"\x01" or request[0] in STREAMS:
            continue
        if fitting.fits(request, response, listed):
            yield request, response


def is_subsequence(part, whole):
    rest = iter(whole)
    return all(each in rest for each in part)


names = st.lists(st.sampled_from(NAMES), min_size=1, max_size=5, unique=True)
plans = st.lists(
    st.tuples(st.sampled_from(["single", "batch", "list", "stream"]), names, st.integers(1, 5)),
    min_size=1,
    max_size=4,
)


@settings(max_examples=60, deadline=None)
@example(  # a `01` was sent behind a late response to `01`: it had not been taken
    [
        ("batch", ["TWAT", "FREQ"], 3),
        ("stream", ["TWAT", "FREQ"], 3),
        ("single", ["TWAT", "FREQ", "FREQX"], 1),
    ],
    AdapterKind(echo=False),
    59,
    0.4,
    [LineFault.CUT, LineFault.LATE, LineFault.LOST],
)
@given(
    plans,
    adapters,
    st.integers(0, 999),
    st.sampled_from([0.05, 0.2, 0.4]),
    st.lists(st.sampled_from(LineFault), min_size=1, unique=True),
)
def test_what_the_tester_refused_is_in_no_table(tmp_path_factory, plan, adapter, seed, rate, kinds):
    path = tmp_path_factory.mktemp("session") / "line.pcapng"
    faults = FaultInjector(dict.fromkeys(kinds, rate / len(kinds)), seed=seed)
    accepted = session(path, plan, adapter=adapter, faults=faults)
    shown = by_decode(path)
    assert by_arrays(path, column_exchanges) == shown
    assert by_arrays(path, quick_exchanges) == shown
    assert list(counted(shown)) == list(counted(accepted))
