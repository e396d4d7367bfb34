"""A unit that controls the ignition alone: the state and a recording name what it does not have."""

from __future__ import annotations

from dashboard.recordings_rig import record
from dashboard.rig import rig
from mikas.catalog import shipped
from mikas.catalog.ignition_only import DEAD, absent_channels
from mikas.client.parameters.readings import decode
from mikas.dashboard.session.history import History
from mikas.dashboard.session.monitor import ConnectionMonitor
from mikas.recording.ignition_only import absent_in
from mikas.recording.recording import Recording
from mikas.sampling.events import Sampled, UnitFound
from mikas.sampling.session import SamplingSession

NAMES = ("FREQ", "INJ", "JAIR")
IGNITION = "&model=5.4&ignition_only=yes"
CARBURETTOR = f"sim:?scenario=warm-idle{IGNITION}"
ABSENT = list(absent_channels(shipped()))


def test_absent_are_the_dead_channels_and_what_is_computed_from_them():
    assert set(ABSENT) > DEAD
    assert {"FUEL_FLOW", "FUEL_USED", "DUTY", "FILLING"} <= set(ABSENT)
    assert set(ABSENT).isdisjoint({"FREQ", "TWAT", "UOZ", "UACC", "THR", "DET"})


def take(monitor, count, **values):
    """So many samples with these values."""
    for number in range(count):
        fresh = {}
        for name, value in values.items():
            parameter = shipped().parameter(name)
            fresh[name] = decode(parameter, parameter.encode(value), float(number), "corrected")
        monitor.add_event(Sampled(float(number), fresh, {}))


def found(another):
    return UnitFound(0.0, 9, None, another=another)


def monitored():
    return ConnectionMonitor(History(), SamplingSession())


def test_a_unit_whose_engine_does_not_run_is_not_decided_on():
    monitor = monitored()
    take(monitor, 100, FREQ=0.0, INJ=0.0, JAIR=0.0)
    assert not monitor.injection.ignition_only
    take(monitor, 19, FREQ=880.0, INJ=0.0, JAIR=0.0)
    assert not monitor.injection.ignition_only
    take(monitor, 1, FREQ=880.0, INJ=0.0, JAIR=0.0)
    assert monitor.injection.ignition_only


def test_one_value_of_injection_withdraws_it():
    monitor = monitored()
    take(monitor, 20, FREQ=880.0, INJ=0.0, JAIR=0.0)
    take(monitor, 1, FREQ=880.0, INJ=4.8, JAIR=0.0)
    assert not monitor.injection.ignition_only


def test_another_unit_and_a_new_connection_begin_undecided():
    monitor = monitored()
    take(monitor, 20, FREQ=880.0, INJ=0.0, JAIR=0.0)
    monitor.add_event(found(another=False))
    assert monitor.injection.ignition_only
    monitor.add_event(found(another=True))
    assert not monitor.injection.ignition_only
    take(monitor, 20, FREQ=880.0, INJ=0.0, JAIR=0.0)
    monitor.begin(NAMES, 0.0)
    assert not monitor.injection.ignition_only


def test_the_state_names_the_absent_channels_until_another_car_is_connected(tmp_path):
    with rig(tmp_path, CARBURETTOR, names=NAMES) as it:
        it.until(lambda message: message["state"]["absent"] == ABSENT)
        it.post("/connect", {"port": "sim:?scenario=warm-idle"})
        assert it.until(lambda message: message["state"]["samples"] > 50)["state"]["absent"] == []


def test_a_recording_of_such_a_unit_names_them(tmp_path):
    folder = tmp_path / "recordings"
    folder.mkdir()
    record(folder / "carburettor.pcapng", f"&scenario=warm-idle{IGNITION}")
    record(folder / "injected.pcapng", "&scenario=warm-idle")
    with rig(tmp_path, None) as it:
        assert it.get("/recordings/carburettor.pcapng")["absent"] == ABSENT
        assert it.get("/recordings/injected.pcapng")["absent"] == []


def test_of_a_file_of_several_cars_the_last_one_decides(tmp_path):
    path = record(tmp_path / "two.pcapng", f"&scenario=warm-idle{IGNITION}")
    ignition = path.read_bytes()
    injected = record(tmp_path / "other.pcapng", "&scenario=warm-idle").read_bytes()
    for both, absent in ((injected + ignition, ABSENT), (ignition + injected, [])):
        path.write_bytes(both)
        assert list(absent_in(Recording(path, shipped(), last_car=True))) == absent
