"""Packed recordings: read as if they were not, or named with the program that unpacks them."""

from __future__ import annotations

import bz2
import gzip
import io
import lzma
import os
import shutil
import subprocess
import tarfile
import zipfile
from contextlib import suppress
from pathlib import Path

import pytest

import mikas
from merged_harness import record
from mikas.errors import CaptureError
from mikas.recording.annotations.events import comment_note
from mikas.recording.capture import packed
from mikas.recording.capture.reader import CaptureReader, Packet, Problem
from mikas.recording.capture.writer import append_note
from mikas.recording.summary import summarise


def zipped(*contents: bytes, method: int = zipfile.ZIP_DEFLATED) -> bytes:
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", method) as archive:
        archive.writestr("read me.txt", "of a drive")
        for number, content in enumerate(contents):
            archive.writestr(f"drives/{number}.pcapng", content)
    return out.getvalue()


PACKINGS = {
    "gzip": gzip.compress,
    "bzip2": bz2.compress,
    "xz": lzma.compress,
    "lzma": lambda data: lzma.compress(data, lzma.FORMAT_ALONE),
    "zip": zipped,
    "zip without packing": lambda data: zipped(data, method=zipfile.ZIP_STORED),
    "several streams": lambda data: gzip.compress(data[:999]) + gzip.compress(data[999:]),
}


@pytest.fixture(scope="module")
def plain(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return record(tmp_path_factory.mktemp("plain") / "drive.pcapng", "A111AA52", count=600)


def items(path: Path) -> list[Packet | Problem]:
    return list(CaptureReader(path))


@pytest.mark.parametrize("how", PACKINGS)
def test_a_packed_recording_is_read_as_the_plain_one(tmp_path: Path, plain: Path, how) -> None:
    path = tmp_path / "drive.pcapng"  # the name says nothing
    path.write_bytes(PACKINGS[how](plain.read_bytes()))
    assert items(path) == items(plain)
    assert mikas.open(path).to_pandas().equals(mikas.open(plain).to_pandas())
    assert mikas.open(path).notes == mikas.open(plain).notes
    found, wanted = summarise(path), summarise(plain)
    assert (found.samples, found.unit, found.car) == (wanted.samples, wanted.unit, wanted.car)


@pytest.mark.parametrize("how", PACKINGS)
def test_of_a_cut_one_all_before_the_cut_is_read(tmp_path: Path, plain: Path, how) -> None:
    data, whole = PACKINGS[how](plain.read_bytes()), items(plain)
    path = tmp_path / "drive.pcapng"
    for share in (0.3, 0.6, 0.9):
        path.write_bytes(data[: int(len(data) * share)])
        if how == "bzip2":  # its blocks are larger than this recording
            with pytest.raises(CaptureError):
                items(path)
            continue
        *read, last = items(path)
        assert read == whole[: len(read)]
        assert len(read) > share / 2 * len(whole)
        assert isinstance(last, Problem)
        assert "the recording was interrupted here" in last.text.en


@pytest.mark.parametrize("how", PACKINGS)
def test_damage_never_ends_in_an_unknown_error(tmp_path: Path, plain: Path, how) -> None:
    data = PACKINGS[how](plain.read_bytes())
    path = tmp_path / "drive.pcapng"
    for at in range(0, len(data), max(1, len(data) // 20)):
        path.write_bytes(data[:at] + bytes([data[at] ^ 0x41]) + data[at + 1 :])
        with suppress(CaptureError):
            items(path)


@pytest.mark.parametrize(
    ("head", "program"),
    [
        (b"\x04\x22\x4d\x18", "lz4 -d"),
        (b"7z\xbc\xaf\x27\x1c", "7z x"),
        (b"Rar!\x1a\x07\x01\x00", "unrar x"),
    ],
)
def test_another_packing_is_named_with_its_program(tmp_path: Path, head, program) -> None:
    path = tmp_path / "drive.pcapng"
    path.write_bytes(head + bytes(200))
    with pytest.raises(CaptureError, match=f"unpack it first: `{program}`"):
        CaptureReader(path)


@pytest.mark.parametrize(("tool", "program"), [("zstd", "unzstd"), ("lz4", "lz4 -d")])
def test_what_the_real_tools_pack_is_known(tmp_path: Path, plain: Path, tool, program) -> None:
    if shutil.which(tool) is None and not os.environ.get("MIKAS_REQUIRE_PACKERS"):
        pytest.skip(f"{tool} is not installed")
    path = tmp_path / "drive.pcapng"
    made = subprocess.run([tool, "-c", str(plain)], check=True, capture_output=True)
    path.write_bytes(made.stdout)
    try:
        assert items(path) == items(plain)  # Zstandard on Python 3.14
    except CaptureError as error:
        assert f"`{program}`" in str(error)


def test_a_tar_is_named_also_inside_gzip(tmp_path: Path, plain: Path) -> None:
    for name, mode in (("a.tar", "w"), ("a.tar.gz", "w:gz")):
        with tarfile.open(tmp_path / name, mode) as archive:
            archive.add(plain, "drive.pcapng")
    with pytest.raises(CaptureError, match="`tar xf`"):
        CaptureReader(tmp_path / "a.tar")
    with pytest.raises(CaptureError, match=r"packed twice \(gzip, then tar\).*`gunzip`"):
        CaptureReader(tmp_path / "a.tar.gz")


def test_several_recordings_in_a_zip_are_named(tmp_path: Path, plain: Path) -> None:
    path = tmp_path / "drives.zip"
    path.write_bytes(zipped(plain.read_bytes(), plain.read_bytes()))
    with pytest.raises(CaptureError, match=r"2 recordings \(drives/0.pcapng, drives/1.pcapng\)"):
        CaptureReader(path)
    path.write_bytes(zipped())
    with pytest.raises(CaptureError, match="no recording of the line is packed"):
        CaptureReader(path)


@pytest.mark.parametrize("how", [name for name in PACKINGS if name != "several streams"])
def test_a_bomb_is_refused_in_bounds(tmp_path, plain, how, monkeypatch) -> None:
    monkeypatch.setattr(packed, "MOST", 3 << 20)
    path = tmp_path / "bomb"
    path.write_bytes(PACKINGS[how](bytes(8 << 20)))
    with pytest.raises(CaptureError, match="no recording"):
        CaptureReader(path)
    path.write_bytes(PACKINGS[how](plain.read_bytes() + bytes(8 << 20)))
    with pytest.raises(CaptureError, match="more than 3 MB"):
        CaptureReader(path)


def test_nothing_is_added_to_a_packed_file(tmp_path: Path, plain: Path) -> None:
    path = tmp_path / "drive.pcapng"
    data = gzip.compress(plain.read_bytes())
    path.write_bytes(data)
    with pytest.raises(CaptureError, match="unpack it first"):
        append_note(path, comment_note(0.0, "mine"))
    assert path.read_bytes() == data
