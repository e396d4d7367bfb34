"""`Ecu.record`: every exchange of one unit in a file, whatever asked for it, while it is open."""

from __future__ import annotations

import asyncio

import pytest

import mikas
from mikas import errors
from mikas.client import AsyncEcu
from mikas.errors import system_error
from mikas.i18n import Text
from mikas.recording import CaptureWriter
from mikas.recording.capture.reader import CaptureReader
from mikas.sampling.events import Marker
from mikas.testing.units import LineFault, VirtualUnit


@pytest.fixture
def unit():
    with VirtualUnit(faults="17") as made:
        yield made


def names_in(path):
    return {channel.name for channel in mikas.open(path).channels}


def full_disk(*_):
    raise system_error(28)


def test_every_exchange_is_in_the_file_and_none_from_before_or_after(unit, tmp_path):
    path = tmp_path / "drive.pcapng"
    with unit.connect() as ecu:
        ecu.passport()
        ecu.read("UACC")
        with ecu.record(path) as recording:
            ecu.read("TWAT", "FREQ")
            ecu.faults()
            ecu.memory.ram.read(0x40)
            with ecu.stream("FREQ") as stream:
                for _ in range(5):
                    next(stream)
            size = recording.bytes
        ecu.read("UACC")
        assert recording.path == path
        assert path.stat().st_size >= size > 0
        assert recording.failure is None
    table = mikas.open(path)
    assert {channel.name for channel in table.channels} == {"FREQ", "TWAT"}
    assert len(table) >= 6
    assert 17 in next(iter(table.raw.fault_readings.values()))[0].codes


def test_it_has_the_units_identity_marks_and_words(unit, tmp_path):
    path = tmp_path / "drive.pcapng"
    with unit.connect() as ecu, ecu.record(str(path)) as recording:
        ecu.read("TWAT")
        assert recording.mark("warm") is not None
        recording.note("left bank")
        passport = ecu.passport()
    recorded = mikas.open(path)
    assert recorded.unit.version_code == ecu.version_code
    assert recorded.unit.passport == passport.pieces
    labels = [event.label for event in recorded.events if isinstance(event, Marker)]
    assert labels == ["warm"]


def test_a_session_and_a_recording_of_a_unit_give_the_same_numbers(unit, tmp_path):
    path = tmp_path / "drive.pcapng"
    with unit.connect() as ecu, ecu.record(path):
        values = [ecu.read("FREQ")["FREQ"].value for _ in range(5)]
    assert mikas.open(path).to_pandas()["FREQ"].tolist() == values


def test_an_existing_file_is_refused_and_stays(unit, tmp_path):
    path = tmp_path / "drive.pcapng"
    path.write_bytes(b"mine")
    with unit.connect() as ecu:
        with pytest.raises(FileExistsError):
            ecu.record(path)
        assert path.read_bytes() == b"mine"
        assert ecu.read("TWAT")


def test_two_at_a_time_are_each_whole_in_whatever_order_they_end(unit, tmp_path):
    with unit.connect() as ecu:
        ecu.passport()
        link = ecu.tester.link
        for number, order in enumerate(((0, 1), (1, 0))):
            paths = [tmp_path / f"{number}-{name}.pcapng" for name in ("a", "b")]
            both = [ecu.record(path) for path in paths]
            ecu.read("TWAT")
            both[order[0]].close()
            ecu.read("FREQ")
            both[order[1]].close()
            both[order[1]].close()
            assert ecu.tester.link is link
            names = [names_in(path) for path in paths]
            assert names[order[0]] == {"TWAT"}
            assert names[order[1]] == {"TWAT", "FREQ"}


def test_a_running_stream_is_refused_with_what_to_do(unit, tmp_path):
    path = tmp_path / "drive.pcapng"
    with unit.connect() as ecu, ecu.stream("FREQ") as stream:
        next(stream)
        with pytest.raises(errors.UsageError, match="close it"):
            ecu.record(path)
        assert next(stream)
    assert not path.exists()


def test_a_line_that_fails_while_it_begins_leaves_no_file(unit, tmp_path):
    path = tmp_path / "drive.pcapng"
    with unit.connect() as ecu:
        unit.unplug()
        with pytest.raises(errors.LinkLost):
            ecu.record(path)
    assert not path.exists()
    with unit.connect() as ecu, ecu.record(path):
        ecu.read("TWAT")


@pytest.mark.parametrize("has_callback", [False, True])
def test_a_full_disk_is_raised_or_called_back(unit, tmp_path, monkeypatch, has_callback):
    said = []
    with unit.connect() as ecu:
        recording = ecu.record(
            tmp_path / "drive.pcapng", on_failure=said.append if has_callback else None
        )
        ecu.read("TWAT")
        monkeypatch.setattr("mikas.recording.capture.writer.write_all", full_disk)
        if has_callback:
            assert ecu.read("TWAT")
            assert ecu.read("FREQ")
            assert [type(each) for each in said] == [errors.DiskFull]
        else:
            for _ in range(2):
                with pytest.raises(OSError, match="no room") as caught:
                    ecu.read("TWAT")
                assert caught.value.errno == 28
        monkeypatch.undo()
        assert isinstance(recording.failure, errors.DiskFull)
        recording.close()
        assert ecu.read("TWAT")


def full_at_the_end(writer, close=CaptureWriter.close):
    close(writer)
    raise errors.DiskFull(str(writer.path), Text("it is full", "он заполнен"))


def test_a_full_disk_does_not_hide_what_has_ended_the_work(unit, tmp_path, monkeypatch):
    def work(ecu):
        with ecu.record(tmp_path / "drive.pcapng"):
            ecu.read("TWAT")
            monkeypatch.setattr(CaptureWriter, "close", full_at_the_end)
            raise ZeroDivisionError

    with unit.connect() as ecu, pytest.raises(ZeroDivisionError):
        work(ecu)


def test_a_damaged_response_is_in_the_file_as_it_came(unit, tmp_path):
    path = tmp_path / "drive.pcapng"
    with unit.connect() as ecu, ecu.record(path):
        unit.next_responses(LineFault.CUT)
        ecu.read("TWAT")
    assert names_in(path) == {"TWAT"}
    assert len(list(CaptureReader(path))) >= 4


def test_a_session_of_asyncio_is_recorded_too(unit, tmp_path):
    path = tmp_path / "drive.pcapng"

    async def scene():
        async with AsyncEcu(unit.connect()) as ecu:
            async with ecu.record(path) as recording:
                await ecu.read("TWAT")
                recording.mark()
            await ecu.read("FREQ")

    asyncio.run(scene())
    assert names_in(path) == {"TWAT"}


def test_a_client_that_records_nothing_does_not_load_it():
    import subprocess
    import sys

    code = (
        "import sys, mikas\nwith mikas.connect('sim:?clock=simulated') as ecu: ecu.read('TWAT')\n"
        "print([name for name in sys.modules if name.startswith('mikas.recording')])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
