"""Recorded sessions with a virtual unit, and the same replayed: for the tests of replay."""

from __future__ import annotations

from contextlib import contextmanager
from pathlib import Path

from capture_writing_harness import appending, coalescing
from mikas.client import connect
from mikas.link.base import Direction
from mikas.replay import car_on

SENT, RECEIVED = Direction.SENT, Direction.RECEIVED
METHODS = ["single", "batch", "list", "stream"]
NAMES = ["TWAT", "FREQ", "UACC", "INJ", "JAIR", "RXX", "RDET", "THR", "UOZ", "TAIR", "FREQX"]


@contextmanager
def session(url, folder, path=None, *, joined=True, **options):
    """A connected ECU, recorded to `path`."""
    folder = Path(folder)
    common = {"state": folder, "journal": folder / "journal", **options}
    if path is None:
        with connect(url, **common) as ecu:
            yield ecu
        return
    with (
        appending(path, url=url) as writer,
        coalescing(writer) as sink,
        connect(url, sink=sink if joined else writer, **common) as ecu,
    ):
        yield ecu


def sim(**settings):
    return "sim:?clock=simulated&" + "&".join(f"{k}={v}" for k, v in settings.items())


def again(path, **settings):
    return f"replay:{path}?clock=simulated&" + "&".join(f"{k}={v}" for k, v in settings.items())


def begun(bus):
    """The wire of a replay that plays since second 0 of its clock, not since the first request."""
    car = car_on(bus)
    car.powered(0.0)
    car.seek(0.0, 0.0)
    return bus


def do(ecu, steps):
    """Each step reads for a while and waits; what came, with the times from the begin."""
    got = []
    began = None
    for method, names, count, pause in steps:
        for sample in ecu.watch(*names, method=method, count=count):
            began = sample.time if began is None else began
            raw = {name: reading.raw for name, reading in sample.readings.items()}
            got.append((sample.time - began, raw))
        ecu.tester.wait(ecu.tester.link.now() + pause)
    return got


def linger(ecu):
    """Goes on for a minute, so that the recording does."""
    ecu.tester.wait(ecu.tester.link.now() + 60)
    ecu.raw(b"\x01")
