"""Which ports a client may name: on this computer any, from the network those that are here.

A port's URL can name more than an adapter: a recording to be replayed, a scenario's file, any
address that this computer can reach. From the network (`--lan-control`) none of these can be named:
only a serial port that was found, the one that is in use, or a virtual car that comes with mikas.
"""

from __future__ import annotations

from typing import Annotated

from fastapi import Depends, Request

from mikas.dashboard.api.dependencies import TheHub
from mikas.dashboard.dashboard import Hub
from mikas.dashboard.errors import NotFromNetwork
from mikas.link.urls import parse
from mikas.virtual.scenarios.scenario import SCENARIOS

_OF_A_CAR = {"scenario", "seed", "model", "faults"}


class Reach:
    """What the client that asks may name."""

    def __init__(self, hub: Hub, *, here: bool) -> None:
        self._hub = hub
        self._here = here

    def check(self, url: str | None) -> None:
        """Raises `NotFromNetwork`, `BadPortUrl`; None, the one likely adapter, is for everybody."""
        if url is None or self._here or self._is_in_use(url):
            return
        if not (_is_shipped_car(url) or url in [port.url for port in self._hub.settings.find()]):
            raise NotFromNetwork(url=url)

    def _is_in_use(self, url: str) -> bool:
        return self._hub.way is not None and self._hub.way.url == url


def _is_shipped_car(url: str) -> bool:
    parsed = parse(url)
    return (
        parsed.scheme == "sim"
        and not parsed.address
        and set(parsed.options) <= _OF_A_CAR
        and parsed.options.get("scenario", next(iter(SCENARIOS))) in SCENARIOS
    )


def _reach(request: Request, hub: TheHub) -> Reach:
    return Reach(hub, here=bool(request.scope["state"]["here"]))


TheReach = Annotated[Reach, Depends(_reach)]
