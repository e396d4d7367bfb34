"""Killed by `kill -9`: the user's files are whole, and can be gone on with.

Each child is a fork of this process that counts its steps and kills itself; so a seed repeats it.
`bench/themes/crash.py` kills the real commands at random moments, a thousand times.
"""

from __future__ import annotations

import json
import os
import signal
import sys
from itertools import count
from random import Random

import numpy as np

import mikas
from mikas.client.memory.dumps import Dump, manifest_path, read_manifest
from mikas.recording import CaptureWriter, Coalescer
from mikas.saving import append_line, save, write_all


def killed(act, at, *modules) -> bool:
    """Run `act` in a child that is killed before line number `at` in these modules.

    Return False if it ended before. `write_text` is counted too: it empties a file, then writes.
    """
    counted = ("/mikas/saving.py", *modules)
    child = os.fork()
    if not child:
        left = at

        def trace(frame, event, _):
            nonlocal left
            code = frame.f_code
            if not code.co_filename.endswith(counted) and code.co_name != "write_text":
                return None
            left -= event == "line"
            if not left:
                os.kill(os.getpid(), signal.SIGKILL)
            return trace

        sys.settrace(trace)
        try:
            act()
        finally:
            os._exit(0)
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == -signal.SIGKILL


def test_saving_is_killed_before_every_line(tmp_path):
    file, seen = tmp_path / "it.json", set()
    for at in count(1):
        file.write_text("old", "utf-8")
        was_killed = killed(lambda: save(file, "new"), at)
        seen.add(file.read_text("utf-8"))
        if not was_killed:
            break
    assert at > 10
    assert seen == {"old", "new"}  # and never a part of either
    save(file, "newer")
    assert [path.name for path in tmp_path.iterdir()] == ["it.json"]


def test_a_line_of_the_journal_is_killed_before_every_line(tmp_path):
    file = tmp_path / "journal.jsonl"
    line = json.dumps({"before": "00 " * 9000})
    for at in count(1):
        file.write_text("first\n", "utf-8")
        was_killed = killed(lambda: append_line(file, line), at)
        append_line(file, "last")
        lines = file.read_text("utf-8").splitlines()
        assert lines in (["first", "last"], ["first", line, "last"])
        if not was_killed:
            break
    assert at > 10


def test_a_dump_is_killed_and_gone_on_with(tmp_path):
    random = Random(1)
    with mikas.connect("sim:?clock=simulated") as ecu:
        whole = ecu.memory.ram.read_block(0, 64)
        file = tmp_path / "d"

        def dump(*, resume=False):
            job = Dump(ecu, ecu.memory.ram, file, first=0, last=63, resume=resume)
            job.advance(block=8, progress=lambda _: None)

        sizes = set()
        for at in random.sample(range(1, 110), 10):
            file.unlink(missing_ok=True)
            manifest_path(file).unlink(missing_ok=True)
            assert killed(dump, at, "/client/memory/dumps.py")
            sizes.add(file.stat().st_size if file.exists() else None)
            begun = file.exists() or manifest_path(file).exists()
            dump(resume=begun)
            assert file.read_bytes() == whole
            assert read_manifest(file).complete
        assert len(sizes) > 4


def test_a_recording_is_killed_and_has_all_but_the_last_second(tmp_path, monkeypatch):
    """In the middle of a write, too: the last block is cut."""
    path, random = tmp_path / "it.pcapng", Random(2)
    url = "sim:?clock=simulated&seed=1"

    def session(reported, left):
        def cut(file, data):
            nonlocal left
            left -= 1
            if left:
                return write_all(file, data)
            file.write(data[: random.randrange(len(data))])
            return os.kill(os.getpid(), signal.SIGKILL)

        monkeypatch.setattr("mikas.recording.capture.writer.write_all", cut)
        with (
            CaptureWriter(path, url=url, overwrite=True) as writer,
            mikas.connect(url, sink=Coalescer(writer)) as ecu,
        ):
            for sample in ecu.watch("TWAT", "FREQ", method="batch"):
                values = [sample.readings[name].value for name in ("TWAT", "FREQ")]
                os.write(reported, json.dumps([sample.time, *values]).encode() + b"\n")

    for _ in range(6):
        heard, reported = os.pipe()
        left = random.randrange(350, 700)
        if not (child := os.fork()):
            session(reported, left)
        os.close(reported)
        with os.fdopen(heard) as lines:
            shown = [json.loads(line) for line in lines]
        assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == -signal.SIGKILL
        recorded = [
            [time, *values]
            for rows in mikas.open(path, names=["TWAT", "FREQ"]).rows()
            for time, *values in zip(rows.times, *rows.values.values(), strict=True)
        ]
        expected = [sample for sample in shown if sample[0] <= shown[-1][0] - 1]
        assert len(expected) > 10
        assert np.allclose(recorded[: len(expected)], expected, rtol=0, atol=1e-5)
