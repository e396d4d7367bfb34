"""What goes wrong between a host and a chip: each a pitfall that was met with a real one.

A test sets them on `Device.faults` at any moment. What a pull, a bound kernel driver, a late
cancellation or a browser that settles nothing does is the transport's part
(`usb.transports.usbfs_rig`, `usb.page.node_rig`).
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Literal

Fault = Literal["stall", "hang", "ignore", ""]


@dataclass(slots=True)
class Faults:
    """`hangs_in`, `hangs_out`: data never come, or are never taken, until it is False again."""

    hangs_in: bool = False
    hangs_out: bool = False
    empty: int = 0
    """Empty packets that are still to come before the next data."""
    _requests: dict[int, Fault] = field(default_factory=dict)
    _stalls: int = 0
    _babbles: int = 0

    def stall(self, *requests: int) -> None:
        """Refuse these control requests from now on, as a clone does that lacks them."""
        self._requests |= dict.fromkeys(requests, "stall")

    def hang(self, *requests: int) -> None:
        """Never answer these control requests: what a page waits for may not settle."""
        self._requests |= dict.fromkeys(requests, "hang")

    def ignore(self, *requests: int) -> None:
        """Acknowledge these control requests and do nothing: a copy's break, say."""
        self._requests |= dict.fromkeys(requests, "ignore")

    def forgive(self, requests: Iterable[int] | None = None) -> None:
        """Answer these requests again; None: all."""
        for request in list(self._requests) if requests is None else requests:
            self._requests.pop(request, None)

    def stall_in(self, times: int = 1) -> None:
        """Halt the IN endpoint at the next packet, until the host clears that."""
        self._stalls += times

    def babble(self, times: int = 1) -> None:
        """Send more at the next packet than the endpoint's size."""
        self._babbles += times

    # -- asked by the device -----------------------------------------------------------------------

    def of_request(self, request: int) -> Fault:
        return self._requests.get(request, "")

    def takes_stall(self) -> bool:
        if not self._stalls:
            return False
        self._stalls -= 1
        return True

    def takes_empty(self) -> bool:
        if not self.empty:
            return False
        self.empty -= 1
        return True

    def of_in(self, packet: bytes, size: int) -> bytes:
        """Return what comes instead of `packet`.

        A packet longer than `size` is for the transport to refuse, as a host's hardware does.
        """
        if self._babbles:
            self._babbles -= 1
            return packet + bytes(size + 1)
        return packet
