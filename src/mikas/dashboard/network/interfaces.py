"""The kinds of this computer's network interfaces, by which its addresses are put in order.

Linux says of its interfaces what they are (/sys/class/net), Windows the type and the description;
elsewhere the name and the flag of a point-to-point link have to do.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from enum import IntEnum
from pathlib import Path
from typing import Final


class InterfaceKind(IntEnum):
    """The kind of an interface, the likeliest to share a network with a phone first."""

    WIRELESS = 0
    OTHER = 1
    VIRTUAL = 2


@dataclass(frozen=True, slots=True)
class Address:
    """An address of an interface that is up."""

    number: str
    interface: str
    kind: InterfaceKind


_SYSTEM: Final = Path("/sys/class/net")
_ETHERNET: Final = range(1, 3), range(801, 804)  # ARPHRD_*: and of Wi-Fi
_VIRTUAL_NAME: Final = re.compile(
    "^(u?tun|tap|wg|ppp|ipsec|gif|stf|gre|sit|ip6tnl|vti|xfrm|vpn|tailscale|zt|ham[0-9]|nordlynx|"
    "nordtun|proton|pvpn|mullvad|cscotun|gpd|cloudflarewarp|outline|docker|br-|veth|virbr|vmnet|"
    "vmenet|vnet|vnic|vboxnet|lxc|lxd|incus|cni|flannel|cali|cilium|podman|kube|dummy)",
    re.IGNORECASE,
)
_VIRTUAL_DESCRIPTION: Final = re.compile(
    r"\b(vpn|openvpn|tap|wintun|wireguard|tunnel|tailscale|zerotier|hamachi|radmin|anyconnect|"
    r"fortinet|pangp|juniper|nordlynx|hyper-v virtual|vethernet|vmware|virtualbox|docker|wsl)\b",
    re.IGNORECASE,
)


def kind_of(name: str, *, is_point_to_point: bool = False, system: Path = _SYSTEM) -> InterfaceKind:
    """Return the kind of an interface of Linux, macOS or BSD."""
    folder = system / name
    if (folder / "device").exists():
        return InterfaceKind.WIRELESS if (folder / "phy80211").exists() else InterfaceKind.OTHER
    if (folder / "bridge").exists():  # it is what its ports are
        ports = [each.name for each in (folder / "brif").glob("*")]
        real = [each for each in ports if (system / each / "device").exists()]
        return min((kind_of(each, system=system) for each in real), default=InterfaceKind.VIRTUAL)
    with suppress(OSError, ValueError):
        kind = int((folder / "type").read_text())
        if not any(kind in known for known in _ETHERNET) or (folder / "tun_flags").exists():
            return InterfaceKind.VIRTUAL
    if is_point_to_point or _VIRTUAL_NAME.match(name):
        return InterfaceKind.VIRTUAL
    return InterfaceKind.WIRELESS if name.startswith("wl") else InterfaceKind.OTHER


def kind_of_windows(kind: int, texts: Sequence[str]) -> InterfaceKind:
    """Return the kind of an interface of Windows by IF_TYPE_* and its names.

    Its own hotspot is a “Wi-Fi Direct Virtual Adapter” of the type of Wi-Fi.
    """
    if kind == 71:
        return InterfaceKind.WIRELESS
    if kind in (23, 53, 131) or any(map(_VIRTUAL_DESCRIPTION.search, texts)):
        return InterfaceKind.VIRTUAL  # PPP, virtual, tunnel
    return InterfaceKind.OTHER
