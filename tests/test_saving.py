"""Files written whole, also on a full disk; `test_saving_posix.py` kills the writer."""

from __future__ import annotations

import errno
import io
import json
import os
from pathlib import Path

import pytest

from mikas import saving
from mikas.client.gate import add_to_journal
from mikas.errors import JournalError, UsageError, reason_of
from mikas.saving import append_line, save, save_json


class SmallDisk:
    """Files opened unbuffered or for text hold `room` more bytes, whatever else is written."""

    def __init__(self, monkeypatch) -> None:
        self.room = 1 << 30
        opened, disk = Path.open, self

        def small(path, mode="r", *args, **settings):
            file = opened(path, mode, *args, **settings)
            return file if mode in ("r", "rb") else disk.limited(file)

        monkeypatch.setattr(Path, "open", small)
        monkeypatch.setattr(saving, "open_regular", lambda path, mode, **_: small(path, mode, 0))

    def limited(self, file):
        disk, raw = self, file if isinstance(file, io.FileIO) else file.buffer.raw

        class Limited(io.FileIO):
            def write(self, data) -> int:
                taken = bytes(data)[: disk.room]
                if not taken:
                    raise OSError(errno.ENOSPC, "No space left on device")
                disk.room -= len(taken)
                return super().write(taken)

        mode = {"ab+": "ab+", "rb+": "rb+", "xb": "rb+", "wb": "rb+"}[raw.mode]
        name, text = raw.name, not isinstance(file, io.FileIO)
        file.close()
        limited = Limited(name, mode)
        return io.TextIOWrapper(io.BufferedWriter(limited), "utf-8") if text else limited


def test_a_full_disk_leaves_the_old_content(tmp_path, monkeypatch):
    file, disk = tmp_path / "it.json", SmallDisk(monkeypatch)
    save(file, "old")
    new = "новое " * 40
    for room in (0, 1, 100, len(new.encode()) - 1):
        disk.room = room
        with pytest.raises(OSError, match="No space left"):
            save(file, new)
        assert [path.name for path in tmp_path.iterdir()] == ["it.json"]
        assert file.read_text("utf-8") == "old"
    disk.room = 1 << 20
    save(file, new)
    assert file.read_text("utf-8") == new


def test_a_full_disk_leaves_no_half_line_in_the_journal(tmp_path, monkeypatch):
    journal, disk = tmp_path / "state" / "journal.jsonl", SmallDisk(monkeypatch)
    entries = [{"change": f"правка {number}", "port": "\udc80"} for number in range(3)]
    add_to_journal(journal, entries[0])
    for room in (0, 1, 20):
        disk.room = room
        with pytest.raises(JournalError, match="make room"):
            add_to_journal(journal, entries[1])
    disk.room = 1 << 20
    add_to_journal(journal, entries[2])
    assert [json.loads(line) for line in journal.read_text("utf-8").splitlines()] == [
        *(entries[0], entries[2])
    ]


def test_a_line_begins_after_one_that_was_cut(tmp_path):
    file = tmp_path / "lines"
    file.write_text('{"whole": 1}\n{"cut": ', "utf-8")
    append_line(file, '{"whole": 2}')
    assert file.read_text("utf-8").splitlines() == ['{"whole": 1}', '{"cut": ', '{"whole": 2}']


def test_a_full_disk_is_explained_in_both_languages():
    reason = reason_of(OSError(errno.ENOSPC, "No space left on device"))
    assert reason == (
        "No space left on device; make room, then repeat",
        "диск заполнен; освободите место и повторите",
    )


@pytest.mark.posix
def test_nothing_is_written_through_a_link_or_to_a_pipe(tmp_path):
    """Planted in a folder that others may write to."""
    secret, file, journal = (tmp_path / name for name in ("secret", "it.json", "journal.jsonl"))
    secret.write_text("not yours")
    for plant in (
        lambda path: path.symlink_to(secret),
        lambda path: os.link(secret, path),
        os.mkfifo,
    ):
        for path in (file, file.with_name("it.json.new"), journal):
            path.unlink(missing_ok=True)
            plant(path)
        save(file, "new")
        assert (file.is_symlink(), file.read_text()) == (False, "new")
        with pytest.raises(JournalError, match=r"a link|second name|a pipe"):
            add_to_journal(journal, {})
        assert secret.read_text() == "not yours"


def test_json_is_saved_with_its_folder_and_an_error_names_the_file(tmp_path: Path) -> None:
    file = tmp_path / "folder" / "list.json"
    for number in (1, 2):
        save_json(file, ["ё", number])
    assert json.loads(file.read_text("utf-8")) == ["ё", 2]
    assert [it.name for it in file.parent.iterdir()] == ["list.json"]
    with pytest.raises(UsageError, match=r"list\.json: "):
        save_json(file / "list.json", [])
