"""Virtual cars that outlive a connection: who disconnects, or calls the doctor, finds the same car
again, with what was erased still erased and the engine as warm as it is by now.
"""

from __future__ import annotations

from mikas.link import Link, open_link
from mikas.link.virtual import RealTimeVirtualLink
from mikas.virtual.bus import Bus


class VirtualCars:
    """Opens ports; of `sim:` in real time, the same URL leads to the same car."""

    def __init__(self) -> None:
        self._cars: dict[str, Bus] = {}

    def open(self, url: str) -> Link:
        """As `open_link`."""
        if (car := self._cars.get(url)) is not None:
            return RealTimeVirtualLink(car, url=url)
        link = open_link(url)
        if type(link) is RealTimeVirtualLink:  # one of `replay:` begins anew each time
            self._cars[url] = link.bus
        return link
