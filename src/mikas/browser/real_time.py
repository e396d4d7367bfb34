"""Ports in real time: on a simulated clock nothing ever waits, so in a worker nothing else runs."""

from __future__ import annotations

from typing import Final

from mikas.i18n import Text
from mikas.link import Link, open_link
from mikas.link.urls import bad_port_url, parse

_SIMULATED: Final = Text(
    "clock=simulated runs as fast as the computer can, and the page would stand still; leave it "
    "out, so that the car runs in real time",
    "с clock=simulated время идёт так быстро, как может компьютер, и страница остановилась бы; "
    "уберите этот параметр, и автомобиль поедет в реальном времени",
)


def open_in_real_time(url: str) -> Link:
    """Open a port, as `open_link`. Raises `BadPortUrl` for a simulated clock, too."""
    if parse(url).options.get("clock") == "simulated":
        raise bad_port_url(url, _SIMULATED)
    return open_link(url)
