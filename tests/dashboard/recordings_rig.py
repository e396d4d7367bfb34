"""Recordings for the API's tests."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import mikas
from mikas.client.connecting import ConnectionOptions
from mikas.i18n import Text
from mikas.link import open_link
from mikas.link.base import CaptureTee
from mikas.recording import CaptureWriter
from mikas.recording.annotations.events import note_of
from mikas.sampling.events import Gap, Marker
from session_header_harness import write_session_header

SIM = "sim:?clock=simulated"


def record(path, settings="", count=100):
    """A drive as the program records it, with a gap and a marker."""
    path.write_bytes(_recorded(settings, count))
    return path


@cache
def _recorded(settings, count):
    """On simulated time: the same at each call."""
    with TemporaryDirectory() as folder:
        return _drive(Path(folder) / "drive.pcapng", SIM + settings, count).read_bytes()


def record_fault(path):
    """A drive in which 71 is stored from the start, and 13 appears after some seconds."""
    link = open_link(f"{SIM}&scenario=warm-idle&faults=71")
    with CaptureWriter(path, url=link.url) as sink:
        ecu = ConnectionOptions().create_ecu(CaptureTee(link, sink))
        ecu.tester.connect()
        names = ("FREQ", "TWAT", "UACC", "JAIR", "MINERR")
        ecu.faults()
        for _ in ecu.watch(*names, method="batch", count=60):
            pass
        link.bus.ecu.responder.car.faults.append(13)
        for _ in ecu.watch(*names, method="batch", count=60):
            pass
        ecu.faults()
        for _ in ecu.watch(*names, method="batch", count=20):
            pass
    return path


def _drive(path, url, count):
    with CaptureWriter(path, url=url) as sink, mikas.connect(url, sink=sink) as ecu:
        write_session_header(
            sink,
            ecu.tester.link.now(),
            version_code=ecu.version_code,
            passports=ecu.passport().pieces,
            catalog_version=ecu.catalog.version,
        )
        ecu.faults()
        for _ in ecu.watch(method="batch", count=count // 2):
            pass
        now = ecu.tester.link.now()
        sink.note(note_of(Marker(now, "here")))
        sink.note(note_of(Gap(now, now, now + 0.1, Text("no echo", "нет эха"))))
        for _ in ecu.watch(method="batch", count=count - count // 2):
            pass
    return path
