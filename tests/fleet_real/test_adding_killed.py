"""`mikas fleet add` killed at any moment: nothing is half there, and the same command continues."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from contextlib import suppress
from pathlib import Path

import pytest

from fleet_rig import BEGAN, DAY, ask, files_of, make
from mikas.fleet.ledger import FOLDER, open_ledger
from mikas.fleet.stores import store

pytestmark = [pytest.mark.realtime, pytest.mark.posix]
ROWS = "SELECT drive, count(*), min(time), max(time) FROM samples GROUP BY drive ORDER BY drive"


def command(folder: Path, dataset: Path, *more: str) -> list[str]:
    return [sys.executable, "-m", "mikas", "fleet", "add", str(folder), "--to", str(dataset), *more]


def begin(folder: Path, dataset: Path, *more: str) -> subprocess.Popen:
    env = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path), "LC_ALL": "C.UTF-8"}
    return subprocess.Popen(
        command(folder, dataset, *more), env=env, text=True, stdout=subprocess.PIPE,
        stderr=subprocess.PIPE, start_new_session=True,
    )  # fmt: skip


def entries(dataset: Path) -> int:
    return len(list((dataset / FOLDER).glob("*.json")))


def wait_for(process: subprocess.Popen, dataset: Path, count: int) -> None:
    """Return when so many recordings count, or the process has ended."""
    while process.poll() is None and entries(dataset) < count:
        with suppress(subprocess.TimeoutExpired):
            process.wait(timeout=0.02)


def ended(group: int) -> bool:
    """Whether no process of the group is left."""
    try:
        os.killpg(group, 0)
    except ProcessLookupError:
        return True
    return False


def test_killed_runs_leave_whole_recordings_and_the_last_one_completes(tmp_path) -> None:
    for number in range(12):
        make(tmp_path / "in" / f"{number}.pcapng", began=BEGAN + number * DAY)
    dataset = tmp_path / "set"
    for count in (1, 4):
        process = begin(tmp_path / "in", dataset, "--workers", "2")
        wait_for(process, dataset, count)
        process.send_signal(signal.SIGKILL)
        process.communicate()
        while not ended(process.pid):  # its workers end with it
            pass
        counted = open_ledger(store(str(dataset))).entries
        assert len(counted) >= count
        assert [row[1] for row in ask(dataset, ROWS)] == [239] * len(counted)
    assert len(counted) < 12
    process = begin(tmp_path / "in", dataset, "--json")
    out, err = process.communicate()
    assert process.returncode == 0, err
    assert f'"added": {12 - len(counted)}' in out
    named = {name for it in open_ledger(store(str(dataset))).entries.values() for name in it.files}
    assert files_of(dataset) == named
    assert [row[1] for row in ask(dataset, ROWS)] == [239] * 12


def test_a_replacement_that_is_killed_counts_once(tmp_path, monkeypatch) -> None:
    """Killed between any two writes of the ledger and of the removals."""
    from fleet_rig import add_here
    from mikas.fleet.stores import DiskStore

    class Killed(BaseException):
        pass

    whole = make(tmp_path / "whole.pcapng").read_bytes()
    file = tmp_path / "drive.pcapng"
    for stop in range(20):
        dataset = tmp_path / f"set {stop}"
        file.write_bytes(whole[: len(whole) // 2])
        add_here(file, to=dataset)
        file.write_bytes(whole)
        steps = iter(range(stop))

        def counted(original, steps=steps):
            def step(*given):
                if next(steps, None) is None:
                    raise Killed
                return original(*given)

            return step

        with monkeypatch.context() as patched:
            for name in ("write", "put", "remove"):
                patched.setattr(DiskStore, name, counted(getattr(DiskStore, name)))
            try:
                add_here(file, to=dataset)
            except Killed:
                pass
            else:
                break
        assert ask(dataset, "SELECT count(DISTINCT drive), count(*) > 100 FROM samples") == [
            (1, True)
        ]
        add_here(file, to=dataset)
        assert ask(dataset, "SELECT count(*) FROM samples") == [(239,)]
        (entry,) = open_ledger(store(str(dataset))).entries.values()
        assert files_of(dataset) == set(entry.files)
    assert stop > 5


def test_ctrl_c_ends_cleanly(tmp_path) -> None:
    for number in range(12):
        make(tmp_path / "in" / f"{number}.pcapng", began=BEGAN + number * DAY)
    process = begin(tmp_path / "in", tmp_path / "set", "--workers", "2")
    wait_for(process, tmp_path / "set", 1)
    os.killpg(process.pid, signal.SIGINT)  # as a terminal does: to all of them
    _, err = process.communicate()
    assert process.returncode == 130
    assert "Traceback" not in err
    assert "the same command continues" in err
    while not ended(process.pid):
        pass
    assert not list((tmp_path / "set" / ".parts").glob("*"))
