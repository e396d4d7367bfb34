"""The sampling thread: an acquisition in a thread of its own, which other threads can stop.

The event loop never waits for the wire: it queues jobs (`call`), which run between cycles, and
`on_event` is called with each event, in this thread. Stopping closes the link under the sampler,
whose next attempt to open it is refused.
"""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable
from concurrent.futures import Future
from contextlib import closing
from dataclasses import replace
from typing import TypeVar

from mikas.client import Ecu
from mikas.client.gate import Confirm
from mikas.dashboard.errors import InternalError
from mikas.dashboard.settings import PlanSettings, PortSettings, Settings
from mikas.errors import MikasError
from mikas.link import Link
from mikas.link.reconnecting import ReconnectingPort
from mikas.link.tee import Sink
from mikas.sampling.acquisition import Acquisition
from mikas.sampling.events import Event

T = TypeVar("T")

_log = logging.getLogger("mikas.dashboard")
_JOIN = 10.0  # s; opening an address in the network may take so long


class _Stopped(Exception):
    """The thread was stopped."""


class SamplingThread:
    """Samples from the port until `stop`.

    `on_event` gets the events; `on_end` the error, if sampling ended by itself.
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
    ) -> None:
        self.url = port.url
        self._settings = settings
        self._stopping = threading.Event()
        self._link: Link | None = None
        self._lock = threading.Lock()
        self.ended = False
        """Sampling has ended by itself, with `failure` if it was an error."""
        self.failure: MikasError | None = None
        self._on_event, self._on_end = on_event, on_end
        self.port = ReconnectingPort(
            port.url,
            find=settings.find,
            open_port=self._open,
            clock=settings.link_clock,
            nap=self._wait,
            sink=sink,
        )
        options = replace(
            settings.connection,
            echo=port.echo,
            confirm=confirm,
            journal=settings.journal,
            state=settings.units,
        )
        self.acquisition = Acquisition(
            self.port,
            options.create_ecu,
            options.catalog,
            request.names,
            method=request.method or "auto",
            rate=request.rate,
        )
        self._thread = threading.Thread(target=self._run, name="mikas sampling", daemon=True)

    def start(self) -> None:
        """Start sampling."""
        self._thread.start()

    def stop(self) -> None:
        """Stop sampling and close the port; may take seconds. A second call does nothing."""
        self._stopping.set()
        self.acquisition.stop()
        with self._lock:
            link = self._link
        if link is not None:
            link.close()
        if self._thread.is_alive():
            self._thread.join(_JOIN)

    @property
    def ecu(self) -> Ecu | None:
        """The unit, for reading its attributes only."""
        return self.acquisition.ecu

    @property
    def adapter(self) -> str:
        """The adapter's description, once the port was open."""
        with self._lock:
            return self._link.description if self._link else ""

    @property
    def baud(self) -> int:
        """Bits per second on the line."""
        with self._lock:
            return self._link.baud if self._link else 9600

    def now(self) -> float:
        """Return the time of the link's clock, also while no link is open."""
        with self._lock:
            link = self._link
        return self.port.now() if link is None else link.now()

    def call(self, job: Callable[[Ecu], T]) -> Future[T]:
        """Run `job(ecu)` between two cycles, as `Acquisition.call`."""
        return self.acquisition.call(job)

    def _wait(self, seconds: float) -> None:
        self._stopping.wait(seconds)

    def _open(self, url: str) -> Link:
        if self._stopping.is_set():
            raise _Stopped
        link = self._settings.open_port(url)
        with self._lock:
            self._link = link
        if self._stopping.is_set():
            link.close()
        return link

    def _run(self) -> None:
        error: MikasError | None = None
        try:
            with closing(self.acquisition.run()) as events:
                for event in events:
                    if self._stopping.is_set():
                        return
                    self._on_event(self, event)
        except _Stopped:
            return
        except MikasError as why:
            error = why
        except Exception as bug:  # any: the page shows it, and the port is closed
            _log.error("a bug in the sampling thread", exc_info=bug)
            error = InternalError(kind=f"{type(bug).__name__}: {bug}")
        finally:
            with self._lock:
                link = self._link
            if link is not None:
                link.close()
            if not self._stopping.is_set():
                self.ended, self.failure = True, error
                self._on_end(self, error)
