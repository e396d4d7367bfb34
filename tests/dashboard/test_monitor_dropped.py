"""Dropped parameters: listed until they are answered again, each change logged once."""

from __future__ import annotations

from mikas.dashboard.session.history import History
from mikas.dashboard.session.monitor import ConnectionMonitor
from mikas.sampling.events import LineState, ParameterDropped, ParameterReturned, StateChanged
from mikas.sampling.session import SamplingSession


def test_a_parameter_that_returns_is_no_longer_dropped():
    monitor = ConnectionMonitor(History(), SamplingSession())
    monitor.add_event(StateChanged(0.0, LineState.SAMPLING, None))
    for event in (
        ParameterDropped(1.0, "INJ"),
        ParameterDropped(1.0, "TAIR"),
        ParameterDropped(2.0, "INJ"),
        ParameterReturned(3.0, "INJ"),
        ParameterReturned(4.0, "INJ"),
    ):
        monitor.add_event(event)
    assert monitor.dropped == ["TAIR"]
    logged = [(it.kind, it.time) for it in monitor.logged if it.kind in ("dropped", "returned")]
    assert logged == [("dropped", 1.0), ("dropped", 1.0), ("returned", 3.0)]
