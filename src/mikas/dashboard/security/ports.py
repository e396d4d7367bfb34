"""Which ports a client may name: on this computer any, from the network those that are here.

A port's URL can name more than an adapter: a recording to replay, a scenario's file, any address
that this computer can reach. From the network (`--lan-control`) none of these may be named: only a
serial port that was found, the port in use, or a virtual car that comes with mikas.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from mikas.dashboard.errors import NotFromNetwork
from mikas.link import Port
from mikas.link.urls import parse
from mikas.virtual.scenarios.scenario import SCENARIOS

_CAR_OPTIONS = {"scenario", "seed", "model", "faults"}


@dataclass(frozen=True, slots=True)
class PortPolicy:
    """`local`: the client is on this computer. `find`: lists the ports; `in_use`: a URL."""

    local: bool
    find: Callable[[], list[Port]]
    in_use: str | None

    def check(self, url: str | None) -> None:
        """Raise `NotFromNetwork`, `BadPortUrl`; None, the one likely adapter, is always allowed."""
        if url is None or self.local or url == self.in_use:
            return
        if not (_is_shipped_car(url) or url in [port.url for port in self.find()]):
            raise NotFromNetwork(url=url)


def _is_shipped_car(url: str) -> bool:
    parsed = parse(url)
    return (
        parsed.scheme == "sim"
        and not parsed.address
        and set(parsed.options) <= _CAR_OPTIONS
        and parsed.options.get("scenario", next(iter(SCENARIOS))) in SCENARIOS
    )
