"""Whether memory stays flat over a day's driving: sampling and recording, eight simulated hours.

python -m bench.themes.memory HOURS     one line of JSON for every simulated hour
"""

from __future__ import annotations

import gc
import json
import os
import resource
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from time import perf_counter

from bench.rows import Row, Scope, Theme
from mikas.catalog import shipped
from mikas.client import Ecu
from mikas.link.base import Link
from mikas.link.reconnecting import ReconnectingPort
from mikas.recording.recorder import Recorder
from mikas.sampling.acquisition import Acquisition
from mikas.sampling.events import CycleFailed, Sampled
from mikas.sampling.session import SamplingSession
from mikas.tester import Tester

RATE = 6.0  # sets/s; at full rate the simulation itself would take five minutes
FAULTS = {"damaged": 0.002, "lost": 0.001, "late": 0.0005, "cut": 0.001, "foreign": 0.0005}
_HOUR = 3600.0

_METHOD = """\
What `mikas log` runs, in a process of its own on simulated time: sampling, derived channels, alarms
and recording to a file; all codes by list, {rate:.0f} sets a second, {hours} hours. Of a hundred
thousand responses {faults}; none is asked for again, so each of these is a gap in the recording.
Memory is the process's resident set after a garbage collection, at the end of every hour; the first
hour fills caches and is the measure for the others. Once."""


def run(scope: Scope) -> Iterator[Theme]:
    hours = scope.of(8, 2)
    began = perf_counter()
    command = [sys.executable, "-m", "bench.themes.memory", str(hours)]
    reported = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout
    seconds = perf_counter() - began
    looks = [json.loads(line) for line in reported.splitlines()]
    first, last = looks[0], looks[-1]
    # The highest, not the last: what was given back in the end would hide what was needed.
    highest = max(look["resident"] for look in looks)
    aside = (
        f"{first['resident']:.1f} MB after the first hour, at most {highest:.1f} MB later; "
        f"{last['sets']:,} sets and {last['gaps']:,} lost cycles in {seconds:.0f} s, "
        f"a file of {last['file']:.0f} MB"
    )
    growth = highest - first["resident"]
    row = Row(f"growth in {hours - 1} hours", [growth], "MB", 1, at_most=2, aside=aside)
    faults = ", ".join(f"{rate * 1e5:.0f} are {kind}" for kind, rate in FAULTS.items())
    yield Theme("Memory", _METHOD.format(rate=RATE, hours=hours, faults=faults), [row])


def drive(hours: int) -> Iterator[dict[str, float]]:
    """Samples and records; gives the figures at the end of every hour."""
    faults = "".join(f"&{kind}={rate}" for kind, rate in FAULTS.items())
    url = f"sim:?clock=simulated&scenario=city{faults}"
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "drive.pcapng"
        recorder = Recorder()
        acquisition = Acquisition(
            ReconnectingPort(url, sink=recorder), _make_ecu, shipped(), method="list", rate=RATE
        )
        recorder.start(path, url=url)
        sets = gaps = done = 0
        session = SamplingSession(recorder.record_event)
        session.wants_faults = lambda: False
        with closing(session.run(acquisition)) as events:
            for event in events:
                sets += isinstance(event, Sampled)
                gaps += isinstance(event, CycleFailed)
                if event.time >= (done + 1) * _HOUR:
                    done += 1
                    yield {
                        "resident": _resident(),
                        "sets": sets,
                        "gaps": gaps,
                        "file": path.stat().st_size / 1e6,
                    }
                if done == hours:
                    break
        recorder.stop()


def _make_ecu(link: Link) -> Ecu:
    """One that never asks twice, so that every spoilt response is a gap in the recording."""
    return Ecu(Tester(link, retries=0), shipped())


def _resident() -> float:
    """MB that this process has in memory now; at most, where the system gives no more."""
    gc.collect()
    try:
        pages = int(Path("/proc/self/statm").read_text("utf-8").split()[1])
    except OSError:
        peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        return peak / (1e6 if sys.platform == "darwin" else 1e3)
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6


if __name__ == "__main__":
    for look in drive(int(sys.argv[1])):
        print(json.dumps(look), flush=True)
