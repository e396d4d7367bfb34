"""The channels to sample, and their cost; with a connection, and before there is one."""

from __future__ import annotations

import threading
from collections.abc import Sequence
from functools import cached_property

from mikas.client.connecting import ConnectionOptions
from mikas.dashboard.errors import NotConnected
from mikas.dashboard.session.connection import Connection
from mikas.dashboard.session.monitor import ConnectionMonitor
from mikas.dashboard.settings import PlanSettings
from mikas.link.reconnecting import ReconnectingPort
from mikas.sampling.acquisition import Acquisition
from mikas.sampling.plan import Price


class SamplingPlanner:
    """`request`: all channels at first. Any thread may call."""

    def __init__(
        self, connection: Connection, monitor: ConnectionMonitor, options: ConnectionOptions
    ) -> None:
        self._connection, self._monitor, self._options = connection, monitor, options
        self._catalog = options.catalog
        self._lock = threading.Lock()
        self.request = PlanSettings(dict.fromkeys(self.channels, 1))

    @property
    def channels(self) -> list[str]:
        """The names of all channels of the catalog."""
        parameters = (parameter.name for parameter in self._catalog.parameters)
        return [*parameters, *self._catalog.derived]

    def sample(self, request: PlanSettings) -> None:
        """Sample `request` from now on, or from the next connection. Raises `UnknownParameter` …"""
        with self._lock:  # two requests at once: the one that is sampled is the one that is shown
            if (thread := self._connection.thread) is not None:
                thread.acquisition.reconfigure(
                    request.names, request.method or "auto", request.rate
                )
            else:
                for name in request.every:
                    self._catalog.channel(name)
            self.request = request
            self._monitor.set_names(request.every)

    def relearn(self) -> None:
        """Forget the measured speeds and limits of this unit. Raises `NotConnected`."""
        if (thread := self._connection.thread) is None:
            raise NotConnected
        thread.acquisition.relearn()

    def price(self, names: Sequence[str], method: str) -> Price:
        """Return the cost of one cycle of `names`, by the limits known of the unit, if any."""
        thread = self._connection.thread
        acquisition = thread.acquisition if thread else self._unconnected
        return acquisition.price(names, method)

    @cached_property
    def _unconnected(self) -> Acquisition:
        """An acquisition that never runs: it knows the costs on a unit with default limits."""
        port = ReconnectingPort("sim:")
        return Acquisition(port, self._options.create_ecu, self._catalog)
