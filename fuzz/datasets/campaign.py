"""Case after case by a seed: `python -m fuzz datasets`.

A dataset of three recordings is made once. Of a case it is copied and changed; then a process of
its own adds the same recordings again, asks and reports, as a user does. A finding: an exception
that is no `MikasError`, a hang, too much memory, a touched canary, a control character on the
terminal, a table that is gone although only entries were added that replace it.
"""

from __future__ import annotations

import argparse
import os
import shutil
import sys
import tempfile
from pathlib import Path
from random import Random
from time import monotonic
from typing import Final

from bench.virtual_fleet import BEGAN, DAY, Drive, record

from fuzz.campaigns import campaign_parser
from fuzz.datasets.changes import FOREIGN, change
from fuzz.datasets.visit import apart, prepare

_OLD: Final = 1_000_000_000  # the canary's time of access: a reading changes it


def main() -> int:
    """Run the campaign; return 1 on a finding."""
    given = _arguments()
    print(f"datasets: seed {given.seed}", flush=True)
    found, at, until = 0, given.first, monotonic() + given.seconds
    with tempfile.TemporaryDirectory(prefix="mikas-fuzz-") as folder:
        os.environ["TMPDIR"] = os.environ["MIKAS_STATE"] = folder
        os.environ["XDG_CONFIG_HOME"] = folder
        world = Path(folder)
        prepare()
        _make(world)
        while at < given.first + given.cases and monotonic() < until:
            if what := _case(world, given.seed, at):
                found += 1
                print(f"FOUND in case {at} of seed {given.seed}: {what}")
                repeat = f"--seed {given.seed} --first {at} --cases 1"
                print(f"  {sys.executable} -m fuzz.datasets.campaign {repeat}", flush=True)
            at += 1
    cases = at - given.first
    print(f"datasets: {found or 'nothing'} found in {cases} cases of seed {given.seed}")
    return 1 if found else 0


def _arguments() -> argparse.Namespace:
    parser = campaign_parser("datasets", 45)
    parser.add_argument("--first", type=int, default=0, help="the number of the first case")
    return parser.parse_args()


def _make(world: Path) -> None:
    """Make the recordings, and the dataset of them that every case begins with."""
    (world / "in").mkdir()
    for number, plate in enumerate(("а 101 мр 52", "Е777КХ99", "")):
        drive = Drive(BEGAN + number * DAY, seconds=20.0, rate=2.0, plate=plate, faults=(13,))
        record(world / "in" / f"{number}.pcapng", drive)
    said = _visited(world)
    assert not said, said
    assert len(list((world / "set").glob("_ledger/*.json"))) == 3
    assert (world / "page.html").is_file()
    (world / "set").rename(world / "sound")


def _case(world: Path, seed: int, number: int) -> str:
    """Run a case; return what was found."""
    home, outside = world / "set", world / "outside"
    for folder in (home, outside):
        shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(world / "sound", home)
    outside.mkdir()
    canary = outside / "canary.json"
    canary.write_bytes(b'{"canary": 1}')
    random = Random(f"{seed}:{number}")
    changes = change(random, home, canary)
    done = ", ".join(changes)
    os.utime(canary, (_OLD, _OLD))
    before = _state(outside)
    said = _visited(world)
    after = _state(outside)
    if before != after:
        said += f"\n  outside: {before} became {after}"
    if set(changes) == {FOREIGN} and (gone := _tables(world / "sound") - _tables(home)):
        said += f"\n  gone: {sorted(gone)}"
    return f"{done}\n{said}" if said else ""


def _tables(home: Path) -> set[str]:
    return {str(path.relative_to(home)) for path in home.rglob("*.parquet")}


def _state(outside: Path) -> list[tuple[str, float, float, int]]:
    """Return the times and sizes of the files there: a reading shows too."""
    states = ((it.name, it.lstat()) for it in sorted(outside.iterdir()))
    return [(name, it.st_atime, it.st_mtime, it.st_size) for name, it in states]


def _visited(world: Path) -> str:
    """Visit the dataset in a process that may die of it; return what was found.

    A fork of this one, whose imports are done and which has no threads: it takes half a second.
    """
    with tempfile.TemporaryFile("w+b") as out:
        process = os.fork()
        if not process:
            apart(world, out.fileno())
        status = os.waitstatus_to_exitcode(os.waitpid(process, 0)[1])
        out.seek(0)
        said = out.read().decode("utf-8", "replace")
    return f"  status {status}: {said[-3000:]}" if status else ""


if __name__ == "__main__":
    sys.exit(main())
