"""How fast recordings become a dataset: by one and two workers, and by hand with pandas."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path

from bench.recorded import START, recorded
from bench.rows import Row, Scope, Theme, timed

DAY = 86_400
_QUESTION = "SELECT car, day, avg(TWAT), max(FREQ) FROM samples GROUP BY ALL"
_METHOD = """\
{count} recordings of {hours:g} hour(s) each, a day apart, as `mikas log` writes them (all codes
by list, a virtual unit in a city), {megabytes:.0f} MB together and {rows:,} rows, just written,
so in the system's file cache. Each figure is of a whole process on an empty dataset: its start,
the reading, the interpretation with all derived channels, statistics, warm idle, faults, gaps
and alarms, and the Parquet files with their ledger. By hand: `bench/fleet_by_hand.py`, what one
would write with pandas in a loop over the files, `mikas.open(file).to_pandas()` and
`to_parquet` partitioned by car and day; it makes the samples alone, skips nothing that is there
already, and is in one process. The Dask cluster is a scheduler and workers of one thread on
this computer, started before."""


def run(scope: Scope) -> Iterator[Theme]:
    count, hours, runs = scope.of(24, 3), scope.of(4, 1) / 4, scope.of(3, 1)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "in").mkdir()
        for number in range(count):
            file = folder / "in" / f"{number}.pcapng"
            recorded(file, hours, lap=60, start=START + number * DAY)
        size = sum(file.stat().st_size for file in (folder / "in").iterdir()) / 1e6
        wire = count * hours
        rows = [
            _row("one process", lambda: _add(folder, "--workers", "1"), runs, wire),
            _row("two processes", lambda: _add(folder, "--workers", "2"), runs, wire),
        ]
        for workers, words in ((1, "Dask, one worker"), (2, "Dask, two workers")):
            with _cluster(folder, workers) as address:
                executor = ("--executor", f"dask://{address}")
                rows.append(_row(words, partial(_add, folder, *executor), runs, wire))
        rows.append(_row("by hand with pandas", lambda: _by_hand(folder), runs, wire))
        _add(folder, "--workers", "2")
        again = timed(lambda: _mikas("add", str(folder / "in"), "--to", str(_set(folder))), runs)
        how = "all of them are there already, and not read."
        rows.append(Row("the same command again", again, "s", 2, how=how))
        asked = timed(lambda: _mikas("sql", str(_set(folder)), _QUESTION), runs)
        how = f"`{_QUESTION}`, a whole process."
        rows.append(Row("a question to all samples", asked, "s", 2, how=how))
        reported = timed(lambda: _mikas("report", str(_set(folder))), runs)
        rows.append(Row("report", reported, "s", 2))
        method = _METHOD.format(count=count, hours=hours, megabytes=size, rows=_rows(_set(folder)))
    yield Theme("A fleet", method, rows)


def _row(what: str, work: Callable[[], object], runs: int, wire: float) -> Row:
    taken = timed(work, runs)
    aside = f"{sorted(taken)[len(taken) // 2]:.1f} s"
    return Row(what, [wire / each for each in taken], "hours of recording a second", 2, aside=aside)


def _set(folder: Path) -> Path:
    return folder / "set"


def _add(folder: Path, *options: str) -> None:
    shutil.rmtree(_set(folder), ignore_errors=True)
    _mikas("add", str(folder / "in"), "--to", str(_set(folder)), *options)


def _by_hand(folder: Path) -> None:
    out = folder / "by hand"
    shutil.rmtree(out, ignore_errors=True)
    _run("-m", "bench.fleet_by_hand", str(folder / "in"), str(out))


def _mikas(*arguments: str) -> str:
    return _run("-m", "mikas", "fleet", *arguments)


def _run(*arguments: str) -> str:
    done = subprocess.run([sys.executable, *arguments], check=True, capture_output=True, text=True)
    return done.stdout


def _rows(dataset: Path) -> int:
    return int(_mikas("sql", str(dataset), "SELECT count(*) FROM samples").split()[-1])


@contextmanager
def _cluster(folder: Path, workers: int) -> Iterator[str]:
    """A Dask scheduler with so many workers; gives its address."""
    processes: list[subprocess.Popen[str]] = []

    def start(until: str, *arguments: str) -> str:
        env = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
        command = [sys.executable, "-m", "dask", *arguments, "--host", "127.0.0.1"]
        process = subprocess.Popen(
            [*command, "--no-dashboard"], stderr=subprocess.PIPE, text=True, cwd=folder, env=env
        )
        processes.append(process)
        assert process.stderr is not None
        for line in process.stderr:
            if until in line:
                threading.Thread(target=process.stderr.read, daemon=True).start()
                return line
        raise RuntimeError(f"{' '.join(command)} does not start")

    try:
        said = start("Scheduler at:", "scheduler", "--port", "0")
        address = said.split("tcp://")[1].split()[0]
        for _ in range(workers):
            start(
                "Starting established", "worker", f"tcp://{address}", "--no-nanny",
                "--nthreads", "1",
            )  # fmt: skip
        yield address
    finally:
        for process in processes:
            process.kill()
            process.wait()
