"""A person's words about a recording, in its own file."""

from __future__ import annotations

import errno
from pathlib import Path
from typing import Any

import pytest

from mikas.errors import CaptureError, DiskFull
from mikas.files import Mode, open_regular
from mikas.link.base import Direction
from mikas.recording import CaptureReader, CaptureWriter
from mikas.recording.annotations.events import comment_note, comment_of, note_of
from mikas.recording.annotations.fields import LONGEST_COMMENT
from mikas.recording.capture import blocks as pcapng
from mikas.recording.capture import writer
from mikas.recording.capture.notes import Note
from mikas.recording.capture.reader import Packet, Problem
from mikas.recording.capture.writer import append_note
from mikas.recording.summary import summarise
from mikas.sampling.events import TextNote


@pytest.fixture
def drive(tmp_path: Path) -> Path:
    path = tmp_path / "drive.pcapng"
    with CaptureWriter(path, url="sim:") as sink:
        sink.record(Direction.SENT, b"\x01\xff\x0d", 1.0)
        sink.note(note_of(TextNote(2.0, "a word in between")))
        sink.record(Direction.RECEIVED, b"\x0a\xf6\x0d", 3.0)
    return path


def comment_text(path: Path) -> str:
    return comment_of(CaptureReader(path).notes())


def test_the_last_words_count_and_nothing_else_changes(drive: Path) -> None:
    before = drive.read_bytes()
    packets = [item for item in CaptureReader(drive) if isinstance(item, Packet)]
    assert comment_text(drive) == ""
    for text in ("первые", "вторые\nна двух строках", ""):
        append_note(drive, comment_note(10.0, text))
        assert comment_text(drive) == text
    assert drive.read_bytes().startswith(before)
    assert list(CaptureReader(drive)) == packets


def test_behind_a_cut_end_they_are_found_all_the_same(drive: Path) -> None:
    drive.write_bytes(drive.read_bytes()[:-5])
    append_note(drive, comment_note(10.0, "cut"))
    assert comment_text(drive) == "cut"
    items = list(CaptureReader(drive))
    assert sum(isinstance(item, Packet) for item in items) == 1
    assert any(isinstance(item, Problem) for item in items)


def test_a_comment_longer_than_the_end_that_is_searched_hides_no_packet(drive: Path) -> None:
    append_note(drive, comment_note(10.0, "Ж" * LONGEST_COMMENT))
    assert summarise(drive).length == 2.0


def test_a_comment_is_appended_in_the_file_s_byte_order(tmp_path: Path) -> None:
    path = tmp_path / "big.pcapng"
    path.write_bytes(pcapng.encode(pcapng.Section(), ">"))
    append_note(path, comment_note(1.0, "big"))
    assert comment_text(path) == "big"
    assert not any(isinstance(item, Problem) for item in CaptureReader(path))


def test_a_note_of_that_kind_without_a_text_is_no_comment() -> None:
    assert comment_of([Note("about", 1.0, {"text": 5}), Note("about", 1.0, {})]) == ""
    assert len(comment_note(1.0, "x" * 99_999).data["text"]) == LONGEST_COMMENT


def test_what_can_not_be_written_leaves_the_file_as_it_was(
    drive: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = drive.read_bytes()

    class FullDisk:
        def __init__(self, file) -> None:
            self._file, self._left = file, 7

        def write(self, data) -> int:
            if not self._left:
                raise OSError(errno.ENOSPC, "No space left on device")
            count = self._file.write(data[: self._left])
            self._left = 0
            return count

        def __enter__(self):
            return self

        def __exit__(self, *_) -> None:
            self._file.close()

        def __getattr__(self, name):
            return getattr(self._file, name)

    def full(path: Path, mode: Mode, **settings: Any) -> FullDisk:
        return FullDisk(open_regular(path, mode, **settings))

    monkeypatch.setattr(writer, "open_regular", full)
    with pytest.raises(DiskFull):
        append_note(drive, comment_note(1.0, "too much"))
    monkeypatch.undo()
    assert drive.read_bytes() == before
    empty = tmp_path / "empty.pcapng"
    empty.write_bytes(b"")
    with pytest.raises(CaptureError):
        append_note(empty, comment_note(1.0, "x"))
    assert empty.read_bytes() == b""
    with pytest.raises(CaptureError):
        append_note(tmp_path / "none.pcapng", comment_note(1.0, "x"))


@pytest.mark.posix
def test_a_comment_is_not_written_through_a_link(drive: Path) -> None:
    """A planted one; the folder's own list has none (`RecordingFolder`)."""
    before, link = drive.read_bytes(), drive.with_name("link.pcapng")
    for make in (link.symlink_to, link.hardlink_to):
        make(drive)
        with pytest.raises(CaptureError, match=r"is a link|second name"):
            append_note(link, comment_note(10.0, "words"))
        link.unlink()
    assert drive.read_bytes() == before
