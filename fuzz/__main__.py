"""Fuzzes the parsers, two at a time: `make fuzz`. Exit status 1 on a finding.

python -m fuzz                       all targets: recordings 270 s, exchanges 60 s, the others 45 s
python -m fuzz notes --seconds 5     this one
python -m fuzz notes --input FILE    repeats one input, with its traceback
python -m fuzz notes --base64 TEXT   the same; a finding prints this line
python -m fuzz recordings --seed 2   other cases, as of `clients`, `exchanges`, `datasets`
python -m fuzz --keep                moves what was reached since into fuzz/corpus, minimized

A target is a module or a package of this folder with `check(data)`, which raises on a finding.
libFuzzer mutates the inputs of fuzz/corpus; those that reach new code are kept in build/fuzz.
`recordings` makes its inputs itself (fuzz/recordings/), and so do `clients`, `exchanges`
and `datasets` (folders here).
"""

from __future__ import annotations

import argparse
import base64
import re
import shlex
import subprocess
import sys
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import Final

# libFuzzer's
TARGETS: Final = (
    "actions",
    "framing",
    "capture",
    "catalog",
    "foreign_logs",
    "guided",
    "instruments",
    "notes",
    "units",
)
RECORDINGS: Final = "recordings"
CLIENTS: Final = "clients"
EXCHANGES: Final = "exchanges"
DATASETS: Final = "datasets"
CORPUS: Final = Path(__file__).parent / "corpus"
BUILD: Final = Path("build/fuzz")

EACH: Final = 45  # seconds
OF_EXCHANGES: Final = 60
CASES: Final = 4000

# Of one input. More is a finding: the inputs are small.
SECONDS: Final = 5
MEBIBYTES: Final = 1024
LONGEST: Final = 4096  # bytes


@dataclass(frozen=True)
class Run:
    """One target's process: exit status, output, and the files of its findings."""

    target: str
    status: int
    output: str
    findings: list[Path]

    @property
    def is_good(self) -> bool:
        return not self.status and not self.findings

    def report(self) -> str:
        """Return the last figures of a good run; else all output, and how to repeat it."""
        if self.is_good:
            figures = re.findall(r"^#\d.*", self.output, re.MULTILINE)
            return f"{self.target}: nothing found\n  {figures[-1] if figures else self.output}"
        lines = [self.output, f"{self.target}: FOUND (exit status {self.status})"]
        for path in self.findings:
            data = base64.b64encode(path.read_bytes()).decode()
            lines.append(f"Repeat {path.name}:")
            lines.append(f"  {sys.executable} -m fuzz {self.target} --base64 {shlex.quote(data)}")
        return "\n".join(lines)


Work = dict[str, Callable[[], Run]]


def main() -> int:
    given = _arguments()
    if given.target and given.target != EXCHANGES and (given.input or given.base64 is not None):
        data = given.input.read_bytes() if given.input else base64.b64decode(given.base64)
        import_module(f"fuzz.{given.target}").check(data)
        print(f"{given.target}: nothing found in these {len(data)} bytes")
        return 0
    if given.keep:
        wanted = [given.target] if given.target else TARGETS
        work: Work = {it: partial(_keep, it) for it in wanted if it in TARGETS}
    else:
        work = _campaigns(given)
    with ThreadPoolExecutor(given.jobs) as pool:
        runs = list(pool.map(lambda target: work[target](), work))
    print("\n".join(run.report() for run in runs if run.target in TARGETS))
    return 0 if all(run.is_good for run in runs) else 1


def _campaigns(given: argparse.Namespace) -> Work:
    """Return the campaigns: that of recordings lasts as long as all others, one after another."""
    seconds = given.seconds or EACH
    long = given.seconds if given.target and given.seconds else seconds * (len(TARGETS) + 1)
    lasting = {
        RECORDINGS: long,
        EXCHANGES: given.seconds or OF_EXCHANGES,
        CLIENTS: seconds,
        DATASETS: seconds,
    }
    campaigns: Work = {
        target: partial(_fuzz_campaign, target, seconds=time, seed=given.seed, cases=given.cases)
        for target, time in lasting.items()
    }
    campaigns |= {target: partial(_fuzz, target, seconds) for target in TARGETS}
    return {given.target: campaigns[given.target]} if given.target else campaigns


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m fuzz", description="Fuzz the parsers.")
    parser.add_argument(
        "target", nargs="?", choices=(*TARGETS, RECORDINGS, CLIENTS, EXCHANGES, DATASETS)
    )
    parser.add_argument("--seconds", type=int, help=f"for each target ({EACH})")
    parser.add_argument("--seed", type=int, default=1, help="of all but libFuzzer's")
    parser.add_argument("--cases", type=int, default=CASES, help="at most so many recordings")
    parser.add_argument("--jobs", type=int, default=2, help="targets at a time")
    parser.add_argument("--keep", action="store_true", help="move what is new into fuzz/corpus")
    parser.add_argument("--input", type=Path, help="repeat this file only")
    parser.add_argument("--base64", help="repeat this input only")
    return parser.parse_args()


def _fuzz_campaign(target: str, **options: int) -> Run:
    """Run the campaign of a target that makes its cases; it reports by itself."""
    words = [word for name, value in options.items() for word in (f"--{name}", str(value))]
    command = [sys.executable, "-m", f"fuzz.{target}.campaign", *words]
    done = subprocess.run(command, stdin=subprocess.DEVNULL, check=False)
    return Run(target, done.returncode, "", [])


def _fuzz(target: str, seconds: int) -> Run:
    corpus = [_folder(target, "reached"), CORPUS / target]
    return _driven(target, f"-max_total_time={seconds}", f"-max_len={LONGEST}", *corpus)


def _keep(target: str) -> Run:
    """Replace the corpus by the fewest inputs that reach the same code, new ones among them."""
    least = _folder(target, "least")
    for path in least.iterdir():
        path.unlink()
    reached = _folder(target, "reached")
    run = _driven(target, "-merge=1", f"-max_len={LONGEST}", least, CORPUS / target, reached)
    if run.is_good and any(least.iterdir()):
        for path in (CORPUS / target).iterdir():
            path.unlink()
        for path in least.iterdir():
            path.rename(CORPUS / target / path.name)
    return run


def _driven(target: str, *options: str | Path) -> Run:
    findings = _folder(target, "findings")
    for path in findings.iterdir():  # of an earlier run
        path.unlink()
    limits = (f"-timeout={SECONDS}", f"-rss_limit_mb={MEBIBYTES}", f"-artifact_prefix={findings}/")
    command = [sys.executable, "-m", "fuzz.drive", target, *limits, *map(str, options)]
    done = subprocess.run(  # what libFuzzer prints may hold any bytes
        command,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        encoding="utf-8",
        errors="replace",
        check=False,
    )
    return Run(target, done.returncode, done.stdout, sorted(findings.iterdir()))


def _folder(target: str, name: str) -> Path:
    folder = BUILD / target / name
    folder.mkdir(parents=True, exist_ok=True)
    return folder


if __name__ == "__main__":
    sys.exit(main())
