"""The contents of a file do not decide how often its bytes are read: counted, not timed."""

from __future__ import annotations

from collections import deque
from contextlib import suppress

import pytest
from crafted_harness import EXCHANGES, FILES, calls, counted

import mikas
from mikas.catalog import shipped
from mikas.errors import CaptureError
from mikas.recording.capture.reader import CaptureReader
from mikas.recording.exchanges.columns.packets import read
from mikas.recording.inspect import Describer, decode
from mikas.recording.summary import summarise
from mikas.replay import load
from mikas.report.from_recording import find_in_recording

COUNT = 24


def exhausted(items):
    deque(items, maxlen=0)


READERS = {
    "scan": lambda path: exhausted(CaptureReader(path)),
    "notes": lambda path: exhausted(CaptureReader(path).notes()),
    "packets": lambda path: exhausted(read(path)),
    "decode": lambda path: exhausted(decode(CaptureReader(path), lambda: Describer(shipped()))),
    "summary": summarise,
    "table": lambda path: exhausted(mikas.open(path).rows()),
    "window": lambda path: mikas.open(path).span,
    "report": lambda path: find_in_recording(mikas.open(path)),
    "replay": load,
}
QUICK = [READERS[name] for name in ("scan", "notes", "packets")]


def work_of(reader, data, path):
    """Return the bytes that `reader` reads of a file with `data`, and the functions it calls."""
    path.write_bytes(data)

    def work():
        with suppress(CaptureError):  # no recording, or none with a response
            reader(path)

    with counted(path) as files:
        called = calls(work)
    assert files
    return sum(file.taken for file in files), called


@pytest.mark.parametrize("reader", READERS.values(), ids=READERS)
def test_each_byte_of_a_crafted_file_is_read_a_bounded_number_of_times(reader, tmp_path):
    path = tmp_path / "a.pcapng"
    for crafted in FILES if reader in QUICK else FILES[:6]:
        (_, called), (taken, called_twice) = (
            work_of(reader, crafted(count), path) for count in (COUNT, 2 * COUNT)
        )
        assert taken <= 20 * path.stat().st_size, crafted.__name__
        assert called_twice <= 2.2 * called, crafted.__name__


@pytest.mark.parametrize("reader", ["decode", "report", "replay"])
def test_crafted_exchanges_cost_in_proportion_to_their_number(reader, tmp_path):
    for crafted in EXCHANGES:
        files = [crafted(count) for count in (10, 20)]
        (_, once), (_, twice) = (
            work_of(READERS[reader], data, tmp_path / "a.pcapng") for data in files
        )
        assert twice <= 2.2 * once, crafted.__name__
