"""`--capture`, `log` and `decode`: what passed on the wire, kept and read back."""

from __future__ import annotations

import re

import pytest
from cli_harness import is_one_short_paragraph, is_russian

import mikas as library
from mikas.recording import CaptureReader
from mikas.recording.capture.opening import capture_error
from mikas.recording.capture.reader import Packet, Problem

WITH_A_PORT = [
    ["info", "--quick"],
    ["read", "TWAT"],
    ["watch", "TWAT", "--count", "2"],
    ["faults"],
    ["faults", "erase", "--yes"],
    ["write", "UOZ", "10", "--yes"],
    ["mem", "read", "ram", "40"],
    ["mem", "write", "ram", "40", "0D", "--yes"],
    ["mem", "dump", "ram", "-o", "ram.bin"],
    ["mem", "goto", "8000", "--yes", "--i-know-what-this-does"],
    ["raw", "611A"],
    ["doctor"],
]


@pytest.mark.parametrize("argv", WITH_A_PORT, ids=" ".join)
def test_every_command_with_a_port_is_captured(mikas, tmp_path, argv):
    assert mikas(*argv, "--capture", "wire.pcapng").status == 0
    packets = list(CaptureReader(tmp_path / "wire.pcapng"))
    assert all(isinstance(packet, Packet) for packet in packets)
    assert packets[0].data == bytes.fromhex("01FF0D")
    assert mikas("decode", "wire.pcapng").status == 0


def test_a_capture_stays_when_the_command_fails(mikas, tmp_path):
    assert mikas("read", "--capture", "wire.pcapng", sim="&lost=1").status == 3
    assert len(list(CaptureReader(tmp_path / "wire.pcapng"))) >= 2
    assert mikas("watch", "--capture", "third.pcapng", sim="&lost=1").status == 3
    assert len(list(CaptureReader(tmp_path / "third.pcapng"))) >= 2
    assert mikas("doctor", "--capture", "other.pcapng", sim="&lost=1").status == 3
    assert len(list(CaptureReader(tmp_path / "other.pcapng"))) >= 2


@pytest.mark.parametrize("argv", [["read"], ["doctor"], ["raw", "01"]], ids=" ".join)
def test_an_existing_file_is_never_written_over(mikas, tmp_path, argv):
    file = tmp_path / "wire.pcapng"
    file.write_bytes(b"precious")
    ran = mikas(*argv, "--capture", "wire.pcapng")
    assert (ran.status, ran.out) == (2, "")
    assert "wire.pcapng" in ran.err
    assert file.read_bytes() == b"precious"


def test_log_records_samples_and_counts_them_in_both_languages(mikas, tmp_path):
    ran = mikas("log", "-o", "drive.pcapng", "TWAT", "FREQ", "--count", "5")
    assert (ran.status, ran.out) == (0, "")
    assert "drive.pcapng: 5 samples" in ran.err
    assert "0 gaps" in ran.err
    assert list(CaptureReader(tmp_path / "drive.pcapng"))
    ran = mikas("log", "--out", "b.pcapng", "TWAT", "--count", "5", "--lang", "ru")
    assert "замеров: 5" in ran.err


def test_log_prints_samples_with_json(mikas):
    ran = mikas("log", "-o", "drive.pcapng", "TWAT", "--count", "3", "--json")
    assert [set(sample) for sample in ran.objects] == [{"schema", "time", "values", "gap"}] * 3
    assert "3 samples" in ran.err


def test_log_goes_on_when_its_file_can_not_be_written(mikas, monkeypatch, tmp_path):
    """Nothing that is wrong with the disk costs the session; it is said once, and at the end."""
    from mikas.recording import CaptureWriter

    written = []
    record = CaptureWriter.record

    def full(self, *args):
        written.append(args)
        if len(written) > 40:
            raise capture_error(self.path, OSError(28, "No space left on device"))
        record(self, *args)

    monkeypatch.setattr(CaptureWriter, "record", full)
    ran = mikas("log", "-o", "drive.pcapng", "TWAT", "--count", "300", "--json")
    *samples, last = ran.objects
    assert (ran.status, len(samples)) == (2, 300)
    assert last["error"]["code"] == "DiskFull"
    reported, last = ran.err.splitlines()
    assert reported.startswith("RECORDING STOPPED. drive.pcapng: there is no room left")
    assert last.startswith("NOT RECORDING · drive.pcapng: 300 samples, ")
    assert not any(isinstance(it, Problem) for it in CaptureReader(tmp_path / "drive.pcapng"))
    lost = int(last.split("samples, ")[1].split(" of them not recorded")[0])
    assert recorded_samples(tmp_path / "drive.pcapng") == pytest.approx(300 - lost, abs=2)
    written.clear()
    ran = mikas("watch", "TWAT", "--count", "300", "--capture", "b.pcapng", "--lang", "ru")
    assert (ran.status, len(ran.lines)) == (0, 301)
    assert ran.err.startswith("ЗАПИСЬ ПРЕКРАЩЕНА. b.pcapng")


def test_samples_after_a_next_file_that_can_not_be_opened_are_counted_as_lost(
    mikas, monkeypatch, tmp_path
):
    from mikas.recording import recorder

    def no_more(named):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(recorder, "_next", no_more)
    argv = ("log", "-o", "a.pcapng", "TWAT", "--method", "batch", "--count", "300")
    ran = mikas(*argv, "--rotate", "1s", "--lang", "ru")
    assert ran.status == 2
    last = ran.err.splitlines()[-1]
    assert last.startswith("ЗАПИСЬ ПРЕКРАЩЕНА · a.pcapng: замеров: 300, из них не записано: ")
    lost = int(last.split("не записано: ")[1].split(",")[0])
    assert recorded_samples(tmp_path / "a.pcapng") == pytest.approx(300 - lost, abs=2)


def recorded_samples(file) -> int:
    """Readings in a recording of one parameter; one or two are asked before the first sample."""
    from mikas.catalog import load
    from mikas.recording.recording import Recording

    return sum(len(rows.times) for rows in Recording(file, load()).rows())


@pytest.mark.parametrize("name", ["drive.csv", "drive.MF4", "drive.parquet", "a.msl", "a.mlg", "-"])
def test_a_name_that_promises_something_else_is_refused(mikas, tmp_path, name):
    """`log` makes no table: whoever opened drive.csv in a spreadsheet would find no line of it."""
    ran = mikas("log", "-o", name, "TWAT", "--count", "1", sim="&lost=1")
    assert (ran.status, ran.out) == (2, "")  # before anybody is asked
    is_one_short_paragraph(ran.err)
    assert "mikas export" in ran.err or name == "-"
    is_russian(mikas("log", "-o", name, "--lang", "ru").err)
    assert not [file for file in tmp_path.iterdir() if file.is_file()]


def test_a_name_without_a_suffix_is_taken_as_it_is(mikas, tmp_path):
    assert mikas("log", "-o", "drive", "TWAT", "--count", "2").status == 0
    assert recorded_samples(tmp_path / "drive") >= 2


def test_log_leaves_no_file_without_a_unit(mikas, tmp_path):
    """So that the same command works once the ignition is on."""
    assert mikas("log", "-o", "drive.pcapng", "TWAT", sim="&lost=1").status == 3
    assert not (tmp_path / "drive.pcapng").exists()
    assert mikas("log", "-o", "drive.pcapng", "TWAT", "--count", "2", sim="").status == 0
    before = (tmp_path / "drive.pcapng").read_bytes()
    assert mikas("log", "-o", "drive.pcapng", "TWAT", sim="&lost=1").status == 2
    assert (tmp_path / "drive.pcapng").read_bytes() == before


@pytest.mark.parametrize("method", ["stream", "list", "batch"])
def test_a_recording_can_be_read_alone_after_each_rotation(mikas, tmp_path, method):
    from mikas.catalog import load
    from mikas.recording.recording import Recording

    ran = mikas("log", "-o", "a.pcapng", "TWAT", "FREQ", "--method", method,
                "--rotate", "2s", "--duration", "7")  # fmt: skip
    assert ran.status == 0, ran.err
    files = sorted(tmp_path.glob("a*.pcapng"))
    assert len(files) >= 3
    assert "a-2.pcapng" in ran.err
    for file in files[:3]:
        recording = Recording(file, load())
        assert {column.name for column in recording.channels} >= {"TWAT", "FREQ"}
        assert sum(len(rows.times) for rows in recording.rows()) > 50
        assert {"unit", "catalog", "plan"} <= {str(n.kind) for n in CaptureReader(file).notes()}


def test_what_is_recorded_is_byte_for_byte_what_passed(mikas, tmp_path, monkeypatch):
    from mikas.link.base import CaptureTee, Direction

    passed = dict.fromkeys(Direction, b"")
    record = CaptureTee._record  # noqa: SLF001

    def noted(self, direction, data, time):
        passed[direction] += data
        record(self, direction, data, time)

    monkeypatch.setattr(CaptureTee, "_record", noted)
    mikas("log", "-o", "a.pcapng", "--count", "200", sim="&damaged=0.02&noise=0.02&seed=3")
    recorded = dict.fromkeys(Direction, b"")
    for packet in CaptureReader(tmp_path / "a.pcapng"):
        recorded[packet.direction] += packet.data
    assert recorded == passed
    assert len(passed[Direction.RECEIVED]) > 2000


def test_decode_explains_each_frame_of_a_capture(mikas):
    mikas("read", "TWAT", "INJ", "--capture", "wire.pcapng")
    text = mikas("decode", "wire.pcapng").out
    assert "CREADP; read parameters: TWAT INJ" in text
    assert "TWAT=86" in text or "TWAT=8" in text
    assert "echo" in text
    assert "  availability, model\n" in text  # and not our own word for it twice
    russian = mikas("decode", "wire.pcapng", "--lang", "ru").out
    assert "чтение параметров: TWAT INJ" in russian
    assert "мс" in russian
    frames = mikas("decode", "wire.pcapng", "--json").objects
    assert {frame["schema"] for frame in frames} == {1}
    assert {frame["type"] for frame in frames} == {"frame"}
    assert len(frames) == len(text.splitlines())
    (answer,) = (f for f in frames if f["request"] == "611A3F" and not f["echo"])
    assert answer["meaning"]["en"].startswith("TWAT=")
    assert answer["body"] == answer["body"].upper()


def test_a_capture_cut_short_is_decoded_up_to_the_cut(mikas, tmp_path):
    mikas("read", "--capture", "wire.pcapng")
    whole = mikas("decode", "wire.pcapng").lines
    file = tmp_path / "wire.pcapng"
    file.write_bytes(file.read_bytes()[:-7])
    ran = mikas("decode", "wire.pcapng")
    assert ran.status == 0
    assert len(ran.lines) >= len(whole) - 1
    assert "interrupted here" in ran.out
    kinds = [it["type"] for it in mikas("decode", "wire.pcapng", "--json").objects]
    assert "problem" in kinds
    assert any(isinstance(it, Problem) for it in CaptureReader(file))


def test_decode_uses_the_interpretation_and_the_catalog_asked_for(mikas):
    mikas("read", "UACC", "--capture", "wire.pcapng")
    assert "UACC=14" in mikas("decode", "wire.pcapng").out
    assert "UACC=-11" in mikas("decode", "wire.pcapng", "--interpretation", "literal").out


@pytest.mark.parametrize("options", [["--count", "5"], ["--rate", "2", "--duration", "3"]])
def test_the_rows_of_an_export_are_explained_where_samples_are_counted(mikas, options, tmp_path):
    assert "an export" not in mikas("log", "-o", "0.pcapng", "TWAT", "--duration", "1").err
    ran = mikas("log", "-o", "a.pcapng", "TWAT", *options)
    rows = sum(len(it.times) for it in library.open(tmp_path / "a.pcapng").rows())
    samples = int(re.search(r": (\d+) samples", ran.err)[1])
    assert rows > samples
    assert ran.err.endswith("an export makes a row of each.\n")
    is_russian(mikas("log", "-o", "b.pcapng", "TWAT", *options, "--lang", "ru").err)


@pytest.mark.parametrize("method", ["stream", "batch"])
def test_the_stored_faults_are_in_the_recording_at_both_ends(mikas, tmp_path, method):
    from mikas.recording.summary import summarise

    ran = mikas("log", "-o", "a.pcapng", "TWAT", "MINERR", "--method", method,
                "--rotate", "2s", "--duration", "3", sim="&faults=53,13")  # fmt: skip
    assert ran.status == 0, ran.err
    assert "Stored faults: 53, 13." in ran.err
    for file in ("a.pcapng", "a-2.pcapng"):
        noted = [it for it in library.open(tmp_path / file).events if it.kind == "faults"]
        assert {it.codes for it in noted} == {(53, 13)}
        assert len(noted) == 2
        assert noted[1].time - noted[0].time > 0.5
        assert summarise(tmp_path / file).faults == (53, 13)
    assert mikas("decode", "a-2.pcapng").out.count("faults 53 13") == 2


def test_a_unit_without_02_ends_a_recording_in_time(mikas, tmp_path):
    ran = mikas("log", "-o", "a.pcapng", "TWAT", "--duration", "4", sim="&missing=02")
    assert ran.status == 0, ran.err
    assert recorded_samples(tmp_path / "a.pcapng") > 20
