"""What is to be sampled, and what that costs; with a connection, and before there is one."""

from __future__ import annotations

import threading
from collections.abc import Sequence
from functools import cached_property
from typing import TYPE_CHECKING

from mikas.dashboard.errors import NotConnected
from mikas.dashboard.wishes import Wish
from mikas.link.reconnecting import ReconnectingPort
from mikas.sampling.acquisition import Acquisition

if TYPE_CHECKING:
    from mikas.dashboard.dashboard import Hub
    from mikas.sampling.plan import Price


class Planning:
    """Changes the hub's wish; any thread may."""

    def __init__(self, hub: Hub) -> None:
        self._hub = hub
        self._lock = threading.Lock()

    @property
    def channels(self) -> list[str]:
        """Every channel that the catalog has."""
        catalog = self._hub.catalog
        return [*(parameter.name for parameter in catalog.parameters), *catalog.derived]

    def want(self, wish: Wish) -> None:
        """Samples this from now on, or from the next connection. Raises `UnknownParameter` …"""
        with self._lock:  # two at once: what is sampled is what is said to be
            if (session := self._hub.session) is not None:
                session.acquisition.reconfigure(wish.names, wish.method or "auto", wish.rate)
            else:
                for name in wish.every:
                    self._hub.catalog.channel(name)
            self._hub.wish = wish
            self._hub.monitor.set_names(wish.every)

    def relearn(self) -> None:
        """Forgets what was learnt of this unit. Raises `NotConnected`."""
        if self._hub.session is None:
            raise NotConnected
        self._hub.session.acquisition.relearn()

    def price(self, names: Sequence[str], method: str) -> Price:
        """What a set of `names` costs, with what is known of the unit, if there is one."""
        session = self._hub.session
        acquisition = session.acquisition if session else self._unconnected
        return acquisition.price(names, method)

    @cached_property
    def _unconnected(self) -> Acquisition:
        """Never run: it knows what things cost on a unit of which nothing is known."""
        options = self._hub.settings.connection
        return Acquisition(ReconnectingPort("sim:"), options.create_ecu, options.catalog)
