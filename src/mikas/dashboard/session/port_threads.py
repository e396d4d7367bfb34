"""The two users of the port, each in its thread: the sampling thread and the diagnosis.

The event loop never waits for the wire. Other threads stop either user by closing the link under
it (`StoppablePort`): its wait ends at once, and the next attempt to open the port is refused. A
running stream is ended before.
"""

from __future__ import annotations

import asyncio
import logging
import threading
import traceback
from collections.abc import Callable
from contextlib import closing
from dataclasses import replace

from mikas.cleaning import without_secrets
from mikas.client.doctor import Step, examine
from mikas.client.gate import Confirm
from mikas.client.identity import UnitIdentity
from mikas.client.other_units import other_units
from mikas.dashboard.errors import InternalError
from mikas.dashboard.settings import PlanSettings, PortSettings, Settings
from mikas.errors import MikasError
from mikas.link import Link
from mikas.link.base import Sink
from mikas.link.reconnecting import ReconnectingPort
from mikas.sampling.acquisition import Acquisition
from mikas.sampling.events import Event

_log = logging.getLogger("mikas.dashboard")
_END = 2.0  # s that the end of a stream may take
_JOIN = 10.0  # s; opening an address in the network may take so long


def logged(what: str, bug: Exception, port: str) -> InternalError:
    """Log a bug, and return its error; neither has a password of the port's URL."""
    trace = "".join(traceback.format_exception(bug)).rstrip("\n")
    _log.error("%s\n%s", what, without_secrets(trace, port=port))
    return InternalError(kind=f"{type(bug).__name__}: {bug}", url=port)


class Stopped(Exception):
    """The port was not opened: its user was stopped."""


class StoppablePort:
    """Opens links until `stop`, which closes the latest one; any thread may call."""

    def __init__(self, open_port: Callable[[str], Link]) -> None:
        self._open_port = open_port
        self.link: Link | None = None
        """The latest link; None: none was opened."""
        self.stopping: threading.Event = threading.Event()

    def open(self, url: str) -> Link:
        """Open the port. Raises `Stopped`."""
        if self.stopping.is_set():
            raise Stopped
        self.link = link = self._open_port(url)
        if self.stopping.is_set():
            link.close()
        return link

    def close(self) -> None:
        """Close the latest link."""
        if (link := self.link) is not None:
            link.close()

    def stop(self) -> None:
        """Close the latest link, and refuse to open another; also before the first one."""
        self.stopping.set()
        self.close()


class SamplingThread(threading.Thread):
    """Samples from the port until `stop`.

    `on_event` gets the events; `on_end` the error, if sampling ended by itself. `before`, `moved`:
    as for `Acquisition`.
    """

    def __init__(
        self,
        port: PortSettings,
        settings: Settings,
        request: PlanSettings,
        *,
        sink: Sink,
        confirm: Confirm,
        on_event: Callable[[SamplingThread, Event], None],
        on_end: Callable[[SamplingThread, MikasError | None], None],
        before: UnitIdentity | None = None,
        moved: bool = False,
    ) -> None:
        super().__init__(name="mikas sampling", daemon=True)
        self.url: str = port.url
        self._stoppable = StoppablePort(settings.open_port)
        self.ended: bool = False
        """Sampling has ended by itself, with `failure` if it was an error."""
        self.at_end: Callable[[], object] = lambda: None
        """Called when sampling has ended, perhaps twice; ends what is read beside the unit."""
        self.failure: MikasError | None = None
        self._on_event, self._on_end = on_event, on_end
        self.port: ReconnectingPort = ReconnectingPort(
            port.url,
            find=settings.find,
            open_port=self._stoppable.open,
            wall=settings.wall,
            wait=self._stoppable.stopping.wait,
            sink=sink,
            timeout=settings.connection.timeout,
        )
        options = replace(
            port.applied(settings.connection),
            confirm=confirm,
            journal=settings.journal,
            state=settings.units,
        )
        self.acquisition: Acquisition = Acquisition(
            self.port,
            options.create_ecu,
            options.catalog,
            request.names,
            method=request.method,
            rate=request.rate,
            before=before,
            moved=moved,
        )
        self.acquisition.prefer(request.first)

    def stop(self) -> None:
        """Stop sampling and close the port; may take seconds. A second call does nothing."""
        self._stoppable.stopping.set()
        self.acquisition.stop()
        if (ecu := self.acquisition.ecu) is not None and ecu.tester.sync.streaming:
            self.join(_END)  # it ends the stream, without which the unit would go on (D12)
        self._stoppable.close()
        if self.is_alive():
            self.join(_JOIN)
        self.at_end()

    @property
    def adapter(self) -> str:
        """The adapter's description; empty until the port was open."""
        return link.description if (link := self._stoppable.link) else ""

    @property
    def baud(self) -> int:
        """Bits per second on the line."""
        return link.baud if (link := self._stoppable.link) else 9600

    def now(self) -> float:
        """Return the time of the clock of the events, also while no link is open."""
        return self.port.now()

    def run(self) -> None:
        """Sample; in the thread."""
        error: MikasError | None = None
        try:
            with closing(self.acquisition.run()) as events:
                for event in events:
                    if self._stoppable.stopping.is_set():
                        return
                    self._on_event(self, event)
        except Stopped:
            return
        except MikasError as why:
            error = why
        except Exception as bug:  # any: the page shows it, and the port is closed
            error = logged("a bug in the sampling thread", bug, self.url)
        finally:
            self._stoppable.close()
            if not self._stoppable.stopping.is_set():
                self.at_end()
                self.failure, self.ended = error, True  # read in the other order
                try:
                    self._on_end(self, error)
                except Exception as bug:  # any: `failure` says why sampling ended
                    logged("a bug at the end of sampling", bug, self.url)


class Diagnosis(StoppablePort):
    """Examines `port` once. `other_units`: as `mikas.client.other_units`."""

    def __init__(
        self, port: PortSettings, settings: Settings, *, other_units: bool = False
    ) -> None:
        super().__init__(settings.open_port)
        self.url = port.url
        self._other_units = other_units
        options = port.applied(settings.connection)
        self._options = replace(options, journal=settings.journal, state=settings.units)
        self.task: asyncio.Task[None] | None = None
        """The task that calls `run` and gives the port back; set by its creator."""

    def run(self, report: Callable[[Step], None]) -> None:
        """Run the steps, calling `report` as each ends. The port is free when this returns.

        Raises as `examine`, and `InternalError` for a bug.
        """
        steps = examine(
            lambda: self.open(self.url),
            self._options.create_ecu,
            others=other_units if self._other_units else None,
        )
        try:
            for step in steps:
                if not self.stopping.is_set():  # else the step failed by the closed link
                    report(step)
        except Stopped:
            return
        except MikasError:
            raise
        except Exception as bug:  # any: the page shows it
            raise logged("a bug in the diagnosis", bug, self.url) from bug

    async def stop_and_wait(self) -> None:
        """Stop the diagnosis, and wait until the port is given back."""
        await asyncio.to_thread(self.stop)
        if self.task is not None:
            await asyncio.wait({self.task})
