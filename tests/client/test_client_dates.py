"""What the library keeps of a unit has its true date, though the date was set meanwhile."""

from __future__ import annotations

import json
import time

import pytest
from client_harness import lines

from mikas.client import connect
from mikas.client.memory.dumps import Dump, read_manifest
from mikas.client.memory.restoring import DumpFile, Restore
from mikas.recording import CaptureWriter

YEARS = 4 * 365 * 86400.0
NIGHT = 43200.0
SOON = 3600.0  # s; of these tests, on any machine


def nothing(_: int) -> None:
    pass


@pytest.fixture(params=["plain", "captured"])
def ecu(request, tmp_path):
    port, journal = "sim:?clock=real", tmp_path / "journal"
    if request.param == "plain":
        with connect(port, confirm=lambda _: True, journal=journal) as it:
            yield it
    else:
        with (
            CaptureWriter(tmp_path / "c.pcapng", url=port) as sink,
            connect(port, confirm=lambda _: True, journal=journal, sink=sink) as it,
        ):
            yield it


@pytest.fixture(params=[YEARS, -NIGHT])
def date(ecu, request, monkeypatch):
    """The computer's date, which was set by so many seconds while `ecu` is connected."""
    real = time.time
    monkeypatch.setattr(time, "time", lambda: real() + request.param)
    return pytest.approx(time.time(), abs=SOON)


def test_a_change_has_its_date_in_the_journal(ecu, date, tmp_path):
    ecu.memory.ram.write(0x40, 1)
    entries = lines(tmp_path / "journal")
    assert [entry["time"] for entry in entries] == [date, date]


def test_a_dump_has_its_date(ecu, date, tmp_path):
    job = Dump(ecu, ecu.memory["ram"], tmp_path / "d", first=0x40, last=0x47, resume=False)
    job.advance(block=None, progress=nothing)
    assert read_manifest(tmp_path / "d").time == date


def test_an_interrupted_restore_has_its_date(ecu, date, tmp_path):
    file = tmp_path / "d"
    dumped = Dump(ecu, ecu.memory["ram"], file, first=0x40, last=0x47, resume=False)
    dumped.advance(block=None, progress=nothing)
    file.write_bytes(bytes(byte ^ 0xFF for byte in file.read_bytes()))
    job = Restore(ecu, ecu.memory["ram"], DumpFile.read(file, "ram"), resume=False)
    job.compare(block=1, progress=nothing)
    next(job.write())
    assert json.loads((tmp_path / "d.restore.json").read_text("utf-8"))["time"] == date
