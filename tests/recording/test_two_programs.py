"""A file that one program records to is neither changed, deleted nor overwritten by another."""

from __future__ import annotations

import sys

import pytest

from mikas.dashboard.library.folder import RecordingFolder
from mikas.errors import CaptureError, UnfitFile
from mikas.files.locks import check_free
from mikas.recording import CaptureWriter
from mikas.recording.annotations.events import note_of
from mikas.recording.capture.reader import CaptureReader
from mikas.recording.capture.writer import append_note
from mikas.sampling.events import Marker
from two_programs_rig import another_recording

NOTE = note_of(Marker(2.0, "here"))


def overwritten(path):
    CaptureWriter(path, url="sim:", overwrite=True).close()


def deleted(path):
    folder = RecordingFolder(path.parent)
    folder.delete(folder.one(path.name))


CHANGES = {"note": lambda path: append_note(path, NOTE), "over": overwritten, "delete": deleted}


@pytest.mark.parametrize("change", CHANGES.values(), ids=CHANGES)
def test_what_another_program_records_is_not_changed_until_it_ends(path, change):
    with another_recording(path) as other:
        before = path.read_bytes()
        with pytest.raises(CaptureError) as refused:
            change(path)
        assert "another program is writing to this file" in refused.value.text.en
        assert "пишет другая программа" in refused.value.text.ru
        if sys.platform == "linux":
            assert f"PID {other.pid}" in refused.value.text.en
        assert path.read_bytes() == before
        other.kill()  # leaves no lock behind
        other.wait()
        change(path)
    assert not path.exists() or path.read_bytes() != before


def test_readers_are_not_kept_away(path):
    with another_recording(path):
        assert sum(1 for _ in CaptureReader(path)) > 0
        with pytest.raises(UnfitFile):
            check_free(path)


def test_a_recording_of_this_program_is_held_until_it_is_closed(path):
    with CaptureWriter(path, url="sim:"):
        CaptureReader(path)  # another look at the file does not end the lock
        with pytest.raises(UnfitFile):
            check_free(path)
        with pytest.raises(CaptureError, match="another program"):
            overwritten(path)
    check_free(path)
    append_note(path, NOTE)
    check_free(path)
