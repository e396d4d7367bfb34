"""What `mikas log` costs the computer at full rate, over a paced pty."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from time import perf_counter, sleep

from bench.rig import serving
from bench.rows import Row, Scope, Theme

_METHOD = """\
`mikas log` records all parameters at full rate: user and system time of the whole process, all its
threads, over the time that passed, in percent of one core. It is looked at from outside (`/proc`)
{settle:.0f} s after its start, when it has connected and tried the methods, and again
{seconds} s later; each run is another process. The virtual ECU is a process too, and not
counted."""
_SETTLE = 10.0  # s


@dataclass(frozen=True, slots=True)
class _Look:
    """What a process had used at a moment: seconds of the processor, wake-ups."""

    time: float
    cpu: float
    wakes: int


def run(scope: Scope) -> Iterator[Theme]:
    if not Path("/proc/self/stat").exists():
        return  # no way to look into another process that every system has
    seconds, runs = scope.of(30, 5), scope.of(3, 1)
    rows = []
    for method in ("auto", "batch", "list"):
        looks = [_log(method, seconds) for _ in range(runs if method == "auto" else 1)]
        shares = [100 * (after.cpu - b.cpu) / (after.time - b.time) for b, after in looks]
        wakes = median((after.wakes - b.wakes) / (after.time - b.time) for b, after in looks)
        before = median(b.cpu for b, _ in looks)
        aside = f"woken {wakes:.0f} times a second; {before:.1f} s of its time up to the first look"
        rows.append(Row(f"`log`, {method}", shares, "%", 2, at_most=5, aside=aside))
    yield Theme("The computer's time", _METHOD.format(settle=_SETTLE, seconds=seconds), rows)


def _log(method: str, seconds: float) -> tuple[_Look, _Look]:
    with serving() as url, tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, "-m", "mikas", "--port", url, "log", "--method", method]
        command += ["-o", str(Path(folder) / "drive.pcapng")]
        environment = os.environ | {"XDG_STATE_HOME": folder}  # nothing learnt before
        with subprocess.Popen(command, env=environment, stderr=subprocess.PIPE) as process:
            sleep(_SETTLE)
            before = _look(process.pid)
            sleep(seconds)
            after = _look(process.pid)
            process.send_signal(signal.SIGINT)
            _, reported = process.communicate()
        if process.returncode not in (0, 130) or b" 0 gaps" not in reported:
            raise RuntimeError(reported.decode())
        return before, after


def _look(process: int) -> _Look:
    folder = Path(f"/proc/{process}")
    after_name = (folder / "stat").read_text("utf-8").rpartition(")")[2].split()
    cpu = (int(after_name[11]) + int(after_name[12])) / os.sysconf("SC_CLK_TCK")
    wakes = sum(
        int(line.split()[1])
        for task in (folder / "task").iterdir()
        for line in (task / "status").read_text("utf-8").splitlines()
        if line.startswith("voluntary_ctxt_switches")
    )
    return _Look(perf_counter(), cpu, wakes)
