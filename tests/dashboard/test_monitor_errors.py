"""Errors of the state: failed exchanges with their bytes, each counted once."""

from __future__ import annotations

import pytest

from dashboard.rig import rig
from mikas.dashboard.session.history import ExchangeFailed, History, page_json
from mikas.dashboard.session.monitor import ConnectionMonitor
from mikas.errors import LinkLost, NoResponse, NotSupported, PortNotFound
from mikas.sampling.events import CycleFailed, LineState, Marker, Sampled, StateChanged
from mikas.sampling.session import SamplingSession
from mikas.tester import Statistics


def take(monitor, event):
    """Let the monitor take `event`, and the gaps that its session finds."""
    for each in monitor.session.events_of(event):
        monitor.add_event(each)


def connected():
    monitor = ConnectionMonitor(History(), SamplingSession())
    take(monitor, StateChanged(0.0, LineState.SAMPLING, None))
    return monitor


def errors(monitor):
    return [event for event in map(page_json, monitor.logged) if event["kind"] == "error"]


def spoilt(time, kind=NoResponse):
    return kind(seconds=0.5, request=b"\x01\x02", received=b"\x03", time=time)


def test_an_error_cured_by_a_retry_is_reported_with_its_bytes():
    monitor, statistics = connected(), Statistics()
    statistics.fail(spoilt(5.0))
    monitor.count_failures(tuple(statistics.failures), 6.0)
    monitor.count_failures(tuple(statistics.failures), 7.0)
    (error,) = errors(monitor)
    assert (error["time"], error["code"]) == (5.0, "NoResponse")
    assert (error["sent"], error["received"]) == ("0102", "03")
    assert error["text"]["ru"]
    assert (monitor.meters.errors, monitor.meters.errors_minute(10.0)) == (1, 1)


def test_an_error_that_also_ended_a_cycle_is_reported_once():
    monitor, statistics = connected(), Statistics()
    cured, last = spoilt(5.0), spoilt(5.5)
    for error in (cured, last):
        statistics.fail(error)
    monitor.count_failures(tuple(statistics.failures), 5.6)
    take(monitor, CycleFailed(5.6, last))
    monitor.count_failures(tuple(statistics.failures), 6.0)
    assert [error["time"] for error in errors(monitor)] == [5.0, 5.5]
    assert monitor.meters.errors == 2


def test_a_verdict_on_reported_exchanges_adds_no_errors():
    monitor, statistics = connected(), Statistics()
    last = spoilt(5.5)
    statistics.fail(last)
    verdict = NotSupported(command="x", request=b"\x01", received=b"", time=5.5)
    verdict.__cause__ = last
    take(monitor, CycleFailed(5.6, verdict))
    monitor.count_failures(tuple(statistics.failures), 6.0)
    assert [error["code"] for error in errors(monitor)] == ["NotSupported"]


@pytest.mark.parametrize("received", [b"", b"\x01"])
def test_an_unknown_command_is_reported_and_is_no_error_of_the_line(received):
    monitor = connected()
    verdict = NotSupported(command="x", request=b"\x71", received=received, time=5.5)
    verdict.__cause__ = None if received else spoilt(5.5)
    take(monitor, CycleFailed(5.6, verdict))
    assert [error["code"] for error in errors(monitor)] == ["NotSupported"]
    assert monitor.meters.errors == 0


def test_another_look_finds_only_what_is_new_though_the_tester_forgets():
    monitor, statistics = connected(), Statistics()
    for time in range(100):
        statistics.fail(spoilt(float(time)))
        monitor.count_failures(tuple(statistics.failures), float(time))
    assert [error["time"] for error in errors(monitor)] == [float(time) for time in range(100)]
    assert monitor.meters.errors_minute(99.0) == 61


def test_a_port_that_is_waited_for_is_one_error_and_a_gap():
    monitor = connected()
    for time in range(1, 50):
        take(
            monitor, CycleFailed(float(time), PortNotFound(url="x", found="none", time=float(time)))
        )
    assert len(errors(monitor)) == 1
    take(monitor, Sampled(50.0, {}, {}))
    take(monitor, CycleFailed(51.0, PortNotFound(url="x", found="none", time=51.0)))
    assert len(errors(monitor)) == 2


def test_many_errors_push_out_nothing_else():
    monitor = connected()
    monitor.log(Marker(1.0, "knock"))
    for number in range(6000):
        monitor.log(ExchangeFailed.of(2.0 + number, spoilt(2.0 + number)))
    monitor.log(Marker(9000.0, "again"))
    kinds = [event.kind for event in monitor.logged]
    assert kinds[:3] == ["state", "marker", "error"]
    assert kinds[-2:] == ["error", "marker"]
    assert len(errors(monitor)) == 5000


def test_a_bad_line_shows_its_errors_with_bytes(tmp_path):
    with rig(tmp_path, "sim:?scenario=warm-idle&damaged=0.03&seed=3") as it, it.live() as live:
        found, counted = [], 0
        while len(found) < 3:
            message = live.next()
            found += [e for e in message.get("events", ()) if e["kind"] == "error"]
            counted = message.get("state", {}).get("errors", counted)
        assert all(error["sent"] for error in found)
        assert any(error["received"] for error in found)
        assert live.until(lambda m: m["state"]["errors"] >= 3)["state"]["errors_minute"] >= 1


def test_an_adapter_that_is_out_is_one_error_whatever_it_is_called_meanwhile():
    monitor = connected()
    take(monitor, Sampled(0.5, {}, {}))
    take(monitor, CycleFailed(1.0, LinkLost(url="x", problem="gone", time=1.0)))
    for time in range(2, 12):
        take(monitor, CycleFailed(float(time), PortNotFound(url="x", found="none")))
    assert [error["code"] for error in errors(monitor)] == ["LinkLost"]
    assert monitor.meters.errors == 1
