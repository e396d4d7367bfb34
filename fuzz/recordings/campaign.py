"""Case after case, in a process that may die of one: `python -m fuzz recordings`.

The process reports the case that it is at; if it dies (a hang, or a crash in a library), the next
one goes on behind that case. A finding is named by its reader, its kind and the innermost function
of mikas; the first file of each is kept in build/fuzz, made small.
"""

from __future__ import annotations

import argparse
import os
import re
import subprocess
import sys
import tempfile
import traceback
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path
from time import monotonic
from typing import Final, TextIO

from fuzz.campaigns import campaign_parser
from fuzz.recordings.cases import Cases
from fuzz.recordings.limits import TooMuch, arm, bound_addresses, place
from fuzz.recordings.minimizing import minimized
from fuzz.recordings.readers import Reader, read, readers_of, warm_up

FINDINGS: Final = Path("build/fuzz/recordings/findings")
_COUNTED: Final = 4  # of every so many cases one has its calls counted
_FRAME: Final = re.compile(r'File "([^"]*/mikas/[^"]*)", line (\d+) in (\w+)')
_OURS: Final = "/src/mikas/"


@dataclass
class Campaign:
    """What has been found; `cases` and `readings` are counted."""

    seed: int
    cases: int = 0
    readings: int = 0
    found: Counter[str] = field(default_factory=Counter)

    def report(self, seconds: float) -> str:
        """Return the figures, and the findings by how often they occurred."""
        speed = self.cases / seconds if seconds else 0.0
        found = len(self.found) or "nothing"
        figures = f"{self.readings} readings, {seconds:.0f} s, {speed:.1f} cases/s"
        lines = [f"recordings: {found} found in {self.cases} cases of seed {self.seed}; {figures}"]
        lines += [f"  {count} × {name}" for name, count in self.found.most_common()]
        return "\n".join(lines)


def main() -> int:
    """Run the campaign; return 1 on a finding."""
    given = _arguments()
    if given.worker is not None:
        _work(given.seed, given.worker, given.last)
        return 0
    print(f"recordings: seed {given.seed}", flush=True)
    FINDINGS.mkdir(parents=True, exist_ok=True)
    for path in FINDINGS.iterdir():  # of an earlier run
        path.unlink()
    campaign, began = Campaign(given.seed), monotonic()
    first, last = given.first, given.first + given.cases
    while first < last and monotonic() - began < given.seconds:
        first = _run(campaign, first, last, began + given.seconds)
    print(campaign.report(monotonic() - began))
    return 1 if campaign.found else 0


def _arguments() -> argparse.Namespace:
    parser = campaign_parser("recordings", 180)
    parser.add_argument("--first", type=int, default=0, help="the number of the first case")
    parser.add_argument("--worker", type=int, help=argparse.SUPPRESS)
    parser.add_argument("--last", type=int, help=argparse.SUPPRESS)
    return parser.parse_args()


def _run(campaign: Campaign, first: int, last: int, until: float) -> int:
    """Run cases in another process until one kills it; return the number of the next case."""
    words = ("--seed", campaign.seed, "--worker", first, "--last", last)
    command = [sys.executable, "-m", "fuzz.recordings.campaign", *map(str, words)]
    at, reader = first, ""
    with (
        tempfile.TemporaryDirectory(prefix="mikas-fuzz-") as folder,  # it may be killed
        tempfile.TemporaryFile("w+") as errors,
        subprocess.Popen(
            command,
            stdout=subprocess.PIPE,
            stderr=errors,
            text=True,
            encoding="utf-8",
            env=os.environ | {"TMPDIR": folder},
        ) as process,
    ):
        assert process.stdout is not None
        for line in process.stdout:
            word, _, rest = line.rstrip("\n").partition(" ")
            if word == "case":
                at = int(rest)
                if monotonic() > until:
                    process.kill()
                    return last
                campaign.cases += 1
            elif word == "reader":
                reader = rest
                campaign.readings += 1
            elif word == "found":
                campaign.found[rest] += 1
                if campaign.found[rest] == 1:
                    print(f"FOUND {rest}", flush=True)
            else:
                print(line, end="", flush=True)
        status = process.wait()
        if not status:
            return last
        errors.seek(0)
        said = errors.read()
    kind = "hang" if status in (-27, 1) and "most recent call first" in said else "crash"
    name = f"{reader}: {kind} (status {status}) in {_innermost(said)}"
    campaign.found[name] += 1
    if campaign.found[name] == 1:
        print(f"FOUND {name}\n{said[-4000:]}", flush=True)
        print(_kept(Cases(campaign.seed).case(at), name, campaign.seed, at), flush=True)
    return at + 1


def _innermost(said: str) -> str:
    """Return the innermost function of mikas in the stacks of faulthandler."""
    for stack in reversed(said.split("most recent call first")):
        if found := _FRAME.search(stack):
            return place(found[1], found[3])
    return "no function of mikas"


class Worker:
    """Reads case after case; says where it is, and what it has found."""

    def __init__(self, seed: int, path: Path, own: TextIO) -> None:
        self.cases = Cases(seed)
        self.path = path
        self._own = own
        self._known: set[str] = set()

    def read(self, number: int) -> None:
        """Let the readers of this case read it."""
        self._say(f"case {number}")
        data = self.cases.case(number)
        for reader in readers_of(number):
            self._say(f"reader {reader.name}")
            name = self._finding(reader, data, calls=number % _COUNTED == 0)
            if name is not None:
                self._say(f"found {name}")
                if name not in self._known:
                    self._known.add(name)
                    self._explain(reader, data, name, number)

    def _finding(self, reader: Reader, data: bytes, *, calls: bool = True) -> str | None:
        """Return the finding's name; None: the reader has read the file as it should."""
        self.path.write_bytes(data)
        try:
            read(reader, self.path, calls=calls)
        except TooMuch as error:
            return f"{reader.name}: {error.what} in {error.where}"
        except Exception as error:  # any that is no MikasError: that is the finding
            frames = traceback.extract_tb(error.__traceback__)
            ours = [frame for frame in frames if _OURS in frame.filename]
            where = place(ours[-1].filename, ours[-1].name) if ours else f"after {frames[-1].name}"
            return f"{reader.name}: {type(error).__name__} in {where}"
        return None

    def _explain(self, reader: Reader, data: bytes, name: str, number: int) -> None:
        """Keep the file, made small, and say how it fails."""
        small = data
        if ": too many" not in name:  # less work is not the same finding
            small = minimized(data, lambda fewer: self._finding(reader, fewer) == name)
        self.path.write_bytes(small)
        try:
            read(reader, self.path)
        except Exception:  # the finding, once more, for its traceback
            self._say(traceback.format_exc(limit=-6))
        self._say(_kept(small, name, self.cases.seed, number))

    def _say(self, line: str) -> None:
        print(line, file=self._own, flush=True)


def _work(seed: int, first: int, last: int) -> None:
    """Be the process that may die."""
    own = os.fdopen(os.dup(1), "w", encoding="utf-8")  # the readers may print
    os.dup2(2, 1)
    with tempfile.TemporaryDirectory(prefix="mikas-fuzz-") as folder:
        worker = Worker(seed, Path(folder) / "it.pcapng", own)
        warm_up(worker.path, worker.cases)
        arm(sys.stderr)
        bound_addresses()
        for number in range(first, last):
            worker.read(number)


def _kept(data: bytes, name: str, seed: int, number: int) -> str:
    """Keep the file; return how to repeat it."""
    kept = FINDINGS / (re.sub(r"[^\w.]+", "-", name)[:100] + ".pcapng")
    kept.write_bytes(data)
    return (
        f"  case {number} of seed {seed}; {len(data)} bytes:\n"
        f"  {sys.executable} -m fuzz recordings --input {kept}"
    )


if __name__ == "__main__":
    sys.exit(main())
