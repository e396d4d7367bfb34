"""The identity of a USB adapter: which port is the one that was opened first.

A port's name belongs to the adapter that took it first: after an unplug, `/dev/ttyUSB0` may be a
stranger's, and the right cable comes back as `/dev/ttyUSB1`. A stranger's cable may be in another
car, whose values must never pass for this car's. So:

- Vendor, product, serial number and interface identify an adapter, under any name and in any USB
  socket.
- **Without a serial number** (CH340, most PL2303), and where two adapters have the same one
  (CP2102: often `0001`), the USB socket decides among like adapters. One in another socket is taken
  only if it is the only one of its kind, and was plugged in after this one had been pulled. Then it
  is most likely the same cable, moved. Whether the same unit answers, sampling checks by version
  and passports, as after any loss (D13): so a like cable of another car is reported as another
  unit, as far as that has passports.
- A port without a USB identity (built in, a pty) is known by its name only.

On Windows and macOS a port whose socket is unknown keeps its name in that socket: the name stands
for the socket.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from mikas.errors import AdapterTaken, AnotherAdapter, PortNotFound
from mikas.i18n import Text
from mikas.link.holders import adapter_without_port
from mikas.link.ports import Port, listed, named


class AdapterIdentity(NamedTuple):
    """The properties of an adapter that stay when it is plugged in again.

    `interface`: `1.0` of an adapter with several ports (FT2232); empty for others.
    """

    vid: int
    pid: int
    serial_number: str | None
    interface: str


def identity_of(port: Port | None) -> AdapterIdentity | None:
    """Return the identity of `port`; None without one."""
    if port is None or port.vid is None or port.pid is None:
        return None
    interface = (port.location or "").partition(":")[2]
    return AdapterIdentity(port.vid, port.pid, port.serial_number, interface)


class KnownAdapter:
    """The adapter on `port` among the ports `present`. `port` must have an identity."""

    def __init__(self, port: Port, present: Sequence[Port]) -> None:
        identity = identity_of(port)
        assert identity is not None
        self._identity = identity
        self._description = port.description
        self._place = _place(port)
        self._only_in_place = len(self._like(present)) > 1
        self._was_away = False

    def locate(self, present: Sequence[Port], address: str) -> Port:
        """Return the port of this adapter; `address`: its latest name.

        Raises `AnotherAdapter` if its name or its kind is another's, `PortNotFound` if it is away.
        """
        like = self._like(present)
        here = [port for port in like if _place(port) == self._place]
        self._only_in_place |= len(like) > 1
        if here:
            return named(address, here) or here[0]
        if not like:
            self._was_away = True
        elif self._may_have_moved:
            return like[0]
        else:  # it stood there all the time: a second adapter of this kind
            self._only_in_place = True
        raise self._missing(present, address, like)

    def opened(self, port: Port) -> None:
        """Note that `port`, which `locate` has returned, is open: this is its socket now."""
        self._place = _place(port)
        self._was_away = False

    @property
    def _may_have_moved(self) -> bool:
        """Whether one of its kind in another USB socket is this adapter."""
        is_numbered = self._identity.serial_number is not None
        return not self._only_in_place and (is_numbered or self._was_away)

    def _like(self, present: Sequence[Port]) -> list[Port]:
        return [port for port in present if identity_of(port) == self._identity]

    def _missing(self, present: Sequence[Port], address: str, like: Sequence[Port]) -> PortNotFound:
        if like:
            names = ", ".join(port.url for port in like)
            problem = Text(
                f"an adapter of the same kind is on {names}, but in another USB socket, and may "
                "belong to another car",
                f"такой же адаптер есть на {names}, но в другом гнезде USB: он может быть от "
                "другой машины",
            )
            return AnotherAdapter(url=address, problem=problem)
        stranger = named(address, present)
        if stranger is None:
            taken = adapter_without_port(address, self._identity[:2])
            if isinstance(taken, AdapterTaken):  # without a driver it is for a moment, when new
                return taken
            return PortNotFound(url=address, found=listed(present))
        ours, theirs = self._description, stranger.description
        problem = Text(
            f"another adapter has its port {address} now ({_named(theirs, stranger, ours)})",
            f"его порт {address} теперь занял другой ({_named(theirs, stranger, ours)})",
        )
        return AnotherAdapter(url=address, problem=problem)


def is_same(before: Port | None, after: Port | None) -> bool:
    """Return whether both are one adapter in one USB socket, or both have no identity."""
    one, other = identity_of(before), identity_of(after)
    if one is None or other is None or before is None or after is None:
        return one is other
    return one == other and _place(before) == _place(after)


def _place(port: Port) -> str:
    """Return the USB socket, `1-1.4`, else the name."""
    return (port.location or "").partition(":")[0] or port.url


def _named(theirs: str, stranger: Port, ours: str) -> str:
    """Return the stranger's description, with its serial number if that is the difference."""
    if theirs == ours and stranger.serial_number:
        return f"{theirs}, {stranger.serial_number}"
    return theirs
