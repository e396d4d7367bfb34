"""A disk that takes no more, with every format: the limit on a file's size stands in for it."""

from __future__ import annotations

import errno
import gc
import os
import resource
import sys
from contextlib import contextmanager

import numpy as np
import pytest
from export_tables import CHANNELS

from mikas.errors import ExportError
from mikas.recording.export import SUFFIXES, export
from mikas.recording.table.channels import Rows


@contextmanager
def disk_of(size):
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_a_full_disk_is_an_error_and_leaves_no_file(tmp_path, suffix):
    out = tmp_path / f"log{suffix}"
    chance = np.random.default_rng(7)
    pieces = (
        Rows(np.arange(1000.0) + at, {c.name: chance.random(1000) for c in CHANNELS})
        for at in range(0, 50_000, 1000)
    )
    export(tmp_path / f"first{suffix}", CHANNELS, [])  # imports may write their caches
    (tmp_path / f"first{suffix}").unlink()
    with disk_of(100_000), pytest.raises(ExportError, match="can't be written") as caught:
        export(out, CHANNELS, pieces)
    assert str(out) in str(caught.value)
    assert list(tmp_path.iterdir()) == []


def test_a_disk_without_any_room_prints_no_traceback_of_a_library(tmp_path, capfd):
    """asammdf printed its own where the rest of a buffer could not be written."""
    rows = [Rows(np.arange(3.0), {c.name: np.arange(3.0) for c in CHANNELS})]
    for size in (0, 1, 331, 1500):
        with disk_of(size), pytest.raises(ExportError, match="can't be written"):
            export(tmp_path / "log.mf4", CHANNELS, rows)
        gc.collect()
        assert list(tmp_path.iterdir()) == []
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("number", [errno.ENOSPC, errno.EDQUOT, errno.EMFILE])
@pytest.mark.parametrize("suffix", [".mf4", ".parquet"])
def test_a_file_beside_the_export_that_cannot_be_made_prints_none(
    tmp_path, monkeypatch, capfd, suffix, number
):
    """A disk without a free inode: a destructor of asammdf fails then."""
    original = os.open

    def refuse(path, flags, *rest, **named):
        if flags & os.O_CREAT and str(path).startswith(f"{tmp_path}/log{suffix}."):
            raise OSError(number, os.strerror(number))
        return original(path, flags, *rest, **named)

    rows = [Rows(np.arange(3.0), {c.name: np.arange(3.0) for c in CHANNELS})]
    if suffix == ".mf4":
        monkeypatch.setattr(os, "open", refuse)
    else:  # duckdb opens its own; the folder is what Python makes
        monkeypatch.setattr(os, "mkdir", lambda path, *_, **__: refuse(path, os.O_CREAT))
    with pytest.raises(ExportError, match="can't be written"):
        export(tmp_path / f"log{suffix}", CHANNELS, rows)
    gc.collect()
    monkeypatch.undo()
    assert list(tmp_path.iterdir()) == []
    assert capfd.readouterr() == ("", "")


@pytest.mark.skipif(sys.platform != "linux", reason="other systems refuse such a name")
@pytest.mark.parametrize("suffix", SUFFIXES)
def test_a_name_that_is_not_utf_8_is_written(tmp_path, suffix):
    """duckdb raised `RuntimeError: std::bad_cast`."""
    folder = tmp_path / os.fsdecode(b"\xff")
    folder.mkdir()
    out = folder / os.fsdecode(b"\xfe" + suffix.encode())
    rows = [Rows(np.arange(3.0), {c.name: np.arange(3.0) for c in CHANNELS})]
    assert export(out, CHANNELS, rows).rows == 3
    assert list(folder.iterdir()) == [out]
    assert out.stat().st_size > 0
