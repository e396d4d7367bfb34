"""A computer on simulated time whose date is set, or that sleeps, while it records."""

from __future__ import annotations

from contextlib import closing
from pathlib import Path

from mikas.link.clocks import WallClock
from mikas.link.reconnecting import ReconnectingPort
from mikas.recording.recorder import Recorder
from mikas.sampling.acquisition import Acquisition
from mikas.sampling.events import Event
from mikas.sampling.session import SamplingSession
from protocol_codes import SECTION_4
from sampling.sampling_harness import SimulatedPlug, ecu_factory
from virtual_harness import make_bus

BEGAN = 1_700_000_000.0
NIGHT = 12 * 3600.0
YEARS = 4 * 365 * 86400.0


class Computer(SimulatedPlug):
    """A computer whose date may jump against its clock, which does not run while it sleeps."""

    def __init__(self) -> None:
        super().__init__(make_bus())
        self.jumped = 0.0
        self.suspended = 0.0  # in which only the virtual car's clock stood still
        self.wall = WallClock(self.steady, lambda: BEGAN + self.steady() + self.jumped)
        self.recorder = Recorder()
        self.session = SamplingSession(self.recorder.record_event)
        self.session.wants_faults = lambda: False
        self.recorder.conclude = self.session.conclude
        self.port = ReconnectingPort(
            "sim:", open_port=self._open_real, wall=self.wall, wait=self.wait, sink=self.recorder
        )

    def _open_real(self, _: str):
        link = self.open()
        link.is_simulated = link.is_virtual = False
        return link

    def steady(self) -> float:
        return self.now() + self.suspended

    def suspend(self, seconds: float) -> None:
        self.suspended += seconds

    def jump(self, seconds: float) -> None:
        self.jumped += seconds

    def silent(self, begin: float, end: float) -> None:
        """Let the adapter be without 12 V meanwhile."""
        self.at(begin, self.unsupply)
        self.at(end, self.mend)

    def run(self, seconds: float, method: str = "batch", rate: float | None = 5) -> list[Event]:
        acquisition = Acquisition(
            self.port, ecu_factory(), SECTION_4, ["FREQ", "TWAT"], method=method, rate=rate
        )
        found: list[Event] = []
        with closing(self.session.run(acquisition)) as events:
            for event in events:
                found.append(event)
                if self.now() > seconds:
                    break
        return found


def record(path: Path, computer: Computer, seconds: float = 9, **how: object) -> list[Event]:
    computer.recorder.start(path, url="sim:")
    events = computer.run(seconds, **how)
    computer.recorder.stop()
    return events
