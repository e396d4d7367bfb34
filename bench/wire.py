"""How much of the wire's limit (§5) the tester reaches over a paced pty, with echo.

The virtual ECU runs in a process of its own (`mikas sim`, turn-round 2 ms). The limit is computed
from what was really carried, stuffing included: bytes · 10 / 9600 + requests · 2 ms. What the
tester needs beyond that is its own time, the system's, and the virtual ECU's lateness.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from itertools import islice
from pathlib import Path
from time import perf_counter

from mikas.catalog import shipped
from mikas.client import Ecu
from mikas.link import Chunk, open_link
from mikas.link.base import Link
from mikas.tester import Tester

TURN_ROUND = 0.002
SETS_A_SECOND = {"single": 5.0, "batch": 17.8, "list": 30.0, "stream": 35.0}  # §5, data unstuffed


class CountingLink(Link):
    """A link that counts what came: echo and responses, so everything that the wire carried."""

    def __init__(self, link: Link) -> None:
        self.link = link
        self.url = link.url
        self.received = 0

    def write(self, data: bytes) -> None:
        self.link.write(data)

    def read(self, deadline: float) -> Chunk:
        chunk = self.link.read(deadline)
        self.received += len(chunk.data)
        return chunk

    def now(self) -> float:
        return self.link.now()

    def send_break(self, seconds: float) -> None:
        self.link.send_break(seconds)

    def close(self) -> None:
        self.link.close()


@contextmanager
def paced_ecu() -> Iterator[Ecu]:
    """A tester on a pty behind which a virtual ECU runs in another process."""
    command = [sys.executable, "-m", "mikas", "sim"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        try:
            assert process.stdout is not None
            link = CountingLink(open_link(process.stdout.readline().strip()))
            tester = Tester(link)
            with Ecu(tester, shipped()) as ecu:
                tester.connect()
                yield ecu
        finally:
            process.terminate()


def measured(ecu: Ecu, work: Callable[[], int]) -> tuple[float, float, int]:
    """Runs `work`; returns the seconds it took, the wire's limit for them, and what it returned."""
    link, statistics = ecu.tester.link, ecu.tester.statistics
    assert isinstance(link, CountingLink)
    received, requests = link.received, statistics.requests
    began = perf_counter()
    result = work()
    seconds = perf_counter() - began
    carried = link.received - received
    limit = carried * link.byte_time + (statistics.requests - requests) * TURN_ROUND
    return seconds, limit, result


def run(*, quick: bool = False) -> None:
    sets = 40 if quick else 200
    print("All 21 codes over a paced pty with echo, d = 2 ms:\n")
    print("| method | sets a second | percent of the wire's limit | §5, unstuffed |")
    print("|---|---|---|---|")
    for method in ("single", "batch"):
        with paced_ecu() as ecu:
            for _ in islice(ecu.watch(method=method), 3):
                pass  # what is asked only once in a session is over

            def work(ecu: Ecu = ecu, method: str = method) -> int:
                return sum(not s.gap for s in islice(ecu.watch(method=method), sets))

            seconds, limit, count = measured(ecu, work)
        rate = count / seconds
        print(f"| {method} | {rate:.2f} | {100 * limit / seconds:.1f} | {SETS_A_SECOND[method]} |")
    size = 0x1000 if quick else 0x10000
    with paced_ecu() as ecu, tempfile.TemporaryDirectory() as folder:
        target = Path(folder) / "code.bin"

        def dump() -> int:
            return target.write_bytes(ecu.memory.code.read_block(0, size))

        seconds, limit, _ = measured(ecu, dump)
    share = 100 * limit / seconds
    print(
        f"\nCODE dump of {size // 1024} KiB: {seconds:.1f} s, {share:.1f} % of the wire's limit.\n"
    )
