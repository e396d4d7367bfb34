"""One connection: an acquisition in its own thread, and the way to end it from another.

The event loop never waits for the wire: it hands in jobs (`call`), which go in between cycles, and
is told what happens by `tell`, in this thread. Ending is closing the link under the sampler, whose
next attempt to open it finds that nobody wants it any more.
"""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable, Sequence
from concurrent.futures import Future
from contextlib import closing
from dataclasses import replace
from typing import TYPE_CHECKING, TypeVar

from mikas.client.gate import Confirm
from mikas.dashboard.errors import InternalError
from mikas.dashboard.settings import Settings
from mikas.errors import MikasError
from mikas.link import Link
from mikas.link.reconnecting import ReconnectingPort
from mikas.link.tee import Sink
from mikas.sampling.acquisition import Acquisition

if TYPE_CHECKING:
    from mikas.client import Ecu
    from mikas.client.polling import FixedMethod
    from mikas.sampling.events import Event

T = TypeVar("T")

_log = logging.getLogger("mikas.dashboard")
_PATIENCE = 10.0  # s; opening an address in the network may hang so long


class _NotWanted(Exception):
    """Nobody wants this session any more."""


class Session:
    """Samples from `url` until `stop`. `tell` gets the events, `ended` what ended it by itself."""

    def __init__(
        self,
        url: str,
        settings: Settings,
        names: Sequence[str],
        *,
        echo: str,
        method: FixedMethod | None,
        rate: float | None,
        sink: Sink,
        confirm: Confirm,
        tell: Callable[[Session, Event], None],
        ended: Callable[[Session, MikasError | None], None],
    ) -> None:
        self.url = url
        self._settings = settings
        self._stopping = threading.Event()
        self._link: Link | None = None
        self._lock = threading.Lock()
        self.ended = False
        """It has ended by itself; `failure` says why."""
        self.failure: MikasError | None = None
        self._tell, self._tell_end = tell, ended
        self.plug = ReconnectingPort(
            url,
            find=settings.find,
            open_port=self._open,
            clock=settings.link_clock,
            nap=self._nap,
            sink=sink,
        )
        options = replace(
            settings.connection,
            echo=echo,
            confirm=confirm,
            journal=settings.journal,
            state=settings.units,
        )
        self.acquisition = Acquisition(
            self.plug,
            options.create_ecu,
            options.catalog,
            names,
            method=method or "auto",
            rate=rate,
        )
        self._thread = threading.Thread(target=self._run, name="mikas sampling", daemon=True)

    def start(self) -> None:
        """Begins, in a thread of its own."""
        self._thread.start()

    def stop(self) -> None:
        """Ends it and lets go of the port; may wait for seconds. A second call does nothing."""
        self._stopping.set()
        self.acquisition.stop()
        with self._lock:
            link = self._link
        if link is not None:
            link.close()
        if self._thread.is_alive():
            self._thread.join(_PATIENCE)

    @property
    def ecu(self) -> Ecu | None:
        """The unit of now, to be looked at only."""
        return self.acquisition.ecu

    @property
    def adapter(self) -> str:
        """What is behind the port, once it was open; for a person."""
        with self._lock:
            return self._link.description if self._link else ""

    @property
    def baud(self) -> int:
        """Bits a second on the wire."""
        with self._lock:
            return self._link.baud if self._link else 9600

    def now(self) -> float:
        """The link's clock, also while there is none."""
        with self._lock:
            link = self._link
        return self.plug.now() if link is None else link.now()

    def call(self, job: Callable[[Ecu], T]) -> Future[T]:
        """`job(ecu)` between two cycles, as `Acquisition.call`."""
        return self.acquisition.call(job)

    def _nap(self, seconds: float) -> None:
        self._stopping.wait(seconds)

    def _open(self, url: str) -> Link:
        if self._stopping.is_set():
            raise _NotWanted
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
                    self._tell(self, event)
        except _NotWanted:
            return
        except MikasError as why:
            error = why
        except Exception as bug:  # whatever it is: the page says so, and the port is let go of
            _log.error("a bug in the sampling thread", exc_info=bug)
            error = InternalError(kind=f"{type(bug).__name__}: {bug}")
        finally:
            with self._lock:
                link = self._link
            if link is not None:
                link.close()
            if not self._stopping.is_set():
                self.ended, self.failure = True, error
                self._tell_end(self, error)
