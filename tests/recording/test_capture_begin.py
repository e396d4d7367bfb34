"""A capture that can't be started: the error says what to do, and no file is left behind."""

from __future__ import annotations

import errno
import os

import pytest

from mikas.errors import CaptureError
from mikas.recording.capture.opening import capture_error
from mikas.recording.capture.writer import CaptureWriter


@pytest.mark.parametrize(
    ("number", "what_to_do"),
    [
        (errno.EACCES, "choose another folder"),
        (errno.EPERM, "choose another folder"),
        (errno.EROFS, "choose another folder"),
        (errno.ENOENT, "folder does not exist; make it"),
        (errno.ENOTDIR, "folder does not exist; make it"),
        (errno.ENAMETOOLONG, "choose a shorter one"),
        (errno.ENOSPC, "Make room"),
        (errno.EEXIST, "choose another name"),
        (errno.EIO, os.strerror(errno.EIO)),
    ],
)
def test_why_a_capture_can_not_begin_says_what_to_do(tmp_path, monkeypatch, number, what_to_do):
    def refuse(self, **_):
        raise OSError(number, os.strerror(number))

    monkeypatch.setattr(CaptureWriter, "_open", refuse)
    with pytest.raises(CaptureError, match=what_to_do) as raised:
        CaptureWriter(tmp_path / "a.pcapng", url="sim:")
    assert "so far" not in str(raised.value)  # nothing was recorded
    if number not in (errno.ENOSPC, errno.EIO):
        assert "выберите" in raised.value.text.ru


def test_a_file_that_was_made_for_nothing_is_taken_away_and_one_that_was_there_is_not(
    tmp_path, monkeypatch
):
    def full(self, block):
        raise capture_error(self.path, OSError(errno.ENOSPC, "No space left on device"))

    monkeypatch.setattr(CaptureWriter, "_append", full)
    for settings in ({}, {"overwrite": True}):
        with pytest.raises(CaptureError):
            CaptureWriter(tmp_path / "a.pcapng", url="sim:", **settings)
        assert not list(tmp_path.iterdir()) or settings
    (tmp_path / "b.pcapng").write_bytes(b"")
    with pytest.raises(CaptureError):
        CaptureWriter(tmp_path / "b.pcapng", url="sim:", overwrite=True)
    assert (tmp_path / "b.pcapng").exists()
