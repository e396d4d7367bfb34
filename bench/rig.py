"""What the benchmarks of the wire share: a unit to sample, and a meter on the way to it.

The unit is a virtual one, in this process on the simulated clock, or in a process of its own
(`mikas sim`) behind a pty paced at 9600 baud. Either echoes, and turns round in 2 ms.
"""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing, contextmanager
from dataclasses import dataclass
from math import inf
from typing import Any

from mikas.catalog import shipped
from mikas.client import Ecu
from mikas.client.parameters.polling import FixedMethod
from mikas.link import Chunk, open_link
from mikas.link.base import Link, LinkWrapper
from mikas.link.reconnecting import ReconnectingPort
from mikas.sampling.acquisition import Acquisition
from mikas.sampling.events import CycleFailed, MethodChosen, Sampled
from mikas.sampling.plan import PlannedParameter
from mikas.tester import Tester

TURN_ROUND = 0.002
_WARM = 3  # cycles before the first one that counts: lists are set, limits learnt

Port = Callable[..., Any]
"""`simulated` or `paced`: gives a context in which there is a `ReconnectingPort`."""


class Meter(LinkWrapper):
    """A link that counts received bytes: echo and responses, so all that the wire carried."""

    def __init__(self, link: Link) -> None:
        super().__init__(link)
        self.received = 0

    def read(self, deadline: float) -> Chunk:
        chunk = self.link.read(deadline)
        self.received += len(chunk.data)
        return chunk


@contextmanager
def simulated(*, latency_ms: int = 0, settings: str = "") -> Iterator[ReconnectingPort]:
    """A virtual unit on simulated time."""
    url = f"sim:?clock=simulated&latency_ms={latency_ms}{settings}"
    yield ReconnectingPort(url, open_port=lambda url: Meter(open_link(url)))


@contextmanager
def paced(*, latency_ms: int = 0) -> Iterator[ReconnectingPort]:
    """A virtual unit in another process, in real time, on a pty."""
    with serving(f"--latency-ms={latency_ms}") as url:
        yield ReconnectingPort(url, open_port=lambda url: Meter(open_link(url)))


@contextmanager
def serving(*options: str) -> Iterator[str]:
    """`mikas sim`; gives the path of its pty."""
    command = [sys.executable, "-m", "mikas", "sim", *options]
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True
    ) as process:
        try:
            assert process.stdout is not None
            url = process.stdout.readline().strip()
            if not url:
                raise RuntimeError(f"{' '.join(command)} does not serve")
            yield url
        finally:
            process.terminate()


@contextmanager
def connected(port: Port) -> Iterator[Ecu]:
    """An ECU that is asked by hand."""
    with port() as plug, make_ecu(plug.open()) as ecu:
        ecu.tester.connect()
        yield ecu


def make_ecu(link: Link) -> Ecu:
    """With nothing remembered from an earlier session."""
    return Ecu(Tester(link), shipped())


def everything() -> list[PlannedParameter]:
    return [PlannedParameter(parameter) for parameter in shipped().parameters]


@dataclass(frozen=True, slots=True)
class Lap:
    """A lap of work: what was done, how long it took, and the wire's time for it (§5)."""

    count: int
    seconds: float
    limit: float

    @property
    def rate(self) -> float:
        return self.count / self.seconds

    @property
    def percent(self) -> float:
        return 100 * self.limit / self.seconds


class Watch:
    """Times laps on one ECU's line.

    The limit is computed from what was really carried, stuffing included: bytes · 10 / 9600 and
    2 ms for each request.
    """

    def __init__(self, ecu: Ecu) -> None:
        self._ecu = ecu
        self._meter = _meter_of(ecu.tester.link)
        self._mark = self._look()

    def _look(self) -> tuple[float, int, int]:
        return self._meter.now(), self._meter.received, self._ecu.tester.statistics.requests

    def lap(self, count: int) -> Lap:
        """What passed since the last lap, or since the watch was made."""
        before, self._mark = self._mark, self._look()
        seconds, carried, requests = (
            now - then for now, then in zip(self._mark, before, strict=True)
        )
        limit = carried * self._meter.byte_time + requests * TURN_ROUND
        return Lap(count, seconds, limit)


def _meter_of(link: Link) -> Meter:
    """Return the meter among the links that are wrapped around each other."""
    while not isinstance(link, Meter):
        assert isinstance(link, LinkWrapper)
        link = link.link
    return link


@dataclass(slots=True)
class Session:
    """What sampling brought: the method that was used, laps of it, and what was lost.

    `gaps`: cycles; `errors`: exchanges that failed; `hole`: the longest time in seconds between two
    samples of the laps.
    """

    laps: list[Lap]
    method: str = ""
    gaps: int = 0
    errors: int = 0
    hole: float = 0.0


def sample(
    plug: ReconnectingPort,
    wanted: Sequence[PlannedParameter],
    method: FixedMethod | None,
    *,
    sets: int,
    runs: int,
    began: Callable[[], object] = lambda: None,
) -> Session:
    """Runs the sampler for `runs` laps of `sets` cycles. `method` None: the fastest.

    `began` is called at the beginning of the first lap.
    """
    ecus: list[Ecu] = []

    def make(link: Link) -> Ecu:
        ecus.append(make_ecu(link))
        return ecus[-1]

    session = Session([], method or "")
    seen = -_WARM if method else -inf  # what is sampled while it still tries does not count
    watch: Watch | None = None
    before = 0.0  # when the latest sample came
    names = [f"{each.parameter.name}/{each.divisor}" for each in wanted]
    sampler = Acquisition(plug, make, shipped(), names, method=method or "auto")
    with closing(sampler.run()) as events:
        for event in events:
            if isinstance(event, MethodChosen):
                session.method, seen = event.method, -_WARM
            session.gaps += isinstance(event, CycleFailed)
            if not isinstance(event, Sampled):
                continue
            seen += 1
            if seen > 0:
                session.hole = max(session.hole, event.time - before)
            before = event.time
            if seen == 0:
                watch = Watch(ecus[-1])
                began()
            elif seen > 0 and seen % sets == 0:
                assert watch is not None
                session.laps.append(watch.lap(sets))
                if len(session.laps) == runs:
                    session.errors = ecus[-1].tester.statistics.failed
                    break
    return session
