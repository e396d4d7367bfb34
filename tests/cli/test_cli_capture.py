"""`--capture`, `log` and `decode`: what passed on the wire, kept and read back."""

from __future__ import annotations

import pytest

from mikas.recording import CaptureReader
from mikas.recording.reader import Packet, Problem

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


def test_log(mikas, tmp_path):
    ran = mikas("log", "-o", "drive.pcapng", "TWAT", "FREQ", "--count", "5")
    assert (ran.status, ran.out) == (0, "")
    assert "drive.pcapng: 5 samples" in ran.err
    assert "0 gaps" in ran.err
    assert list(CaptureReader(tmp_path / "drive.pcapng"))
    ran = mikas("log", "--out", "b.pcapng", "TWAT", "--count", "5", "--lang", "ru")
    assert "отсчётов 5" in ran.err


def test_log_tells_samples_with_json(mikas):
    ran = mikas("log", "-o", "drive.pcapng", "TWAT", "--count", "3", "--json")
    assert [set(sample) for sample in ran.objects] == [{"schema", "time", "values", "gap"}] * 3
    assert "3 samples" in ran.err


def test_log_stops_when_its_file_can_not_be_written(mikas, monkeypatch):
    from mikas.recording import CaptureWriter

    written = []
    record = CaptureWriter.record

    def full(self, *args):
        written.append(args)
        if len(written) > 20:
            raise self._failure(OSError(28, "No space left on device"))
        record(self, *args)

    monkeypatch.setattr(CaptureWriter, "record", full)
    ran = mikas("log", "-o", "drive.pcapng", "TWAT", "--count", "1000")
    assert ran.status == 2
    assert "drive.pcapng" in ran.err.splitlines()[-1]
    written.clear()
    ran = mikas("watch", "TWAT", "--count", "20", "--capture", "b.pcapng")
    assert (ran.status, len(ran.lines)) == (0, 21)  # the samples matter more than the capture
    assert "The capture stopped early" in ran.err


def test_decode(mikas):
    mikas("read", "TWAT", "INJ", "--capture", "wire.pcapng")
    text = mikas("decode", "wire.pcapng").out
    assert "CREADP; read parameters: TWAT INJ" in text
    assert "TWAT=86" in text or "TWAT=8" in text
    assert "echo" in text
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


def test_a_capture_cut_short(mikas, tmp_path):
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


def test_decode_uses_the_reading_and_the_catalog_asked_for(mikas):
    mikas("read", "UACC", "--capture", "wire.pcapng")
    assert "UACC=14" in mikas("decode", "wire.pcapng").out
    assert "UACC=-11" in mikas("decode", "wire.pcapng", "--reading", "literal").out
