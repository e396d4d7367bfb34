"""This computer's addresses: their order, and the links as they change while the program runs."""

from __future__ import annotations

import socket
import subprocess
import sys
import time

import pytest

from dashboard.rig import ME, OTHER, rig
from mikas.dashboard.network.addresses import _of_default_route, in_order, own_addresses
from mikas.dashboard.network.interfaces import Address, InterfaceKind, kind_of, kind_of_windows
from mikas.dashboard.network.temporary import (
    ifconfig,
    in_ifconfig,
    in_list,
    is_temporary_windows,
)
from mikas.dashboard.security.access import Access

WIFI, CABLE, VPN = InterfaceKind.WIRELESS, InterfaceKind.OTHER, InterfaceKind.VIRTUAL


def order(*found):
    return in_order([Address(number, f"if{at}", kind) for at, (number, kind) in enumerate(found)])


@pytest.mark.parametrize(
    ("found", "wanted"),
    [
        ([], []),
        ([("10.77.0.2", CABLE)], ["10.77.0.2"]),
        ([("10.8.0.6", VPN), ("192.168.1.5", WIFI)], ["192.168.1.5", "10.8.0.6"]),
        ([("172.17.0.1", VPN), ("8.8.4.4", CABLE)], ["8.8.4.4", "172.17.0.1"]),
        ([("10.0.0.3", CABLE), ("192.168.43.1", WIFI)], ["192.168.43.1", "10.0.0.3"]),
        ([("10.0.0.9", WIFI), ("10.0.1.9", WIFI)], ["10.0.0.9", "10.0.1.9"]),
        ([("fe80::1", WIFI), ("2a00::1", WIFI), ("fd00::1", WIFI)], ["fd00::1", "2a00::1"]),
        ([("169.254.3.4", CABLE), ("100.64.0.1", CABLE)], ["100.64.0.1", "169.254.3.4"]),
        ([("fd00::9", VPN), ("169.254.3.4", CABLE)], ["169.254.3.4", "fd00::9"]),
        ([("127.0.0.1", CABLE), ("::1", CABLE), ("0.0.0.0", CABLE)], []),
    ],
)
def test_what_a_phone_can_reach_comes_first(found, wanted):
    assert list(order(*found)) == wanted


def test_the_system_says_what_an_interface_is(tmp_path):
    for path in (
        "wlan0/device", "wlan0/phy80211", "eth0/device", "br0/bridge", "br0/brif/eth0",
        "hot/bridge", "hot/brif/wlan0", "own/bridge", "own/brif/veth1", "tap-a",
    ):  # fmt: skip
        (tmp_path / path).mkdir(parents=True)
    (tmp_path / "office").mkdir()
    (tmp_path / "office/type").write_text("65534\n")
    (tmp_path / "tap-a/type").write_text("1\n")
    names = {
        "wlan0": WIFI, "eth0": CABLE, "br0": CABLE, "hot": WIFI, "own": VPN, "office": VPN,
        "tap-a": VPN, "en0": CABLE, "utun3": VPN, "tailscale0": VPN, "docker0": VPN,
        "br-0123456789ab": VPN, "virbr0": VPN, "wg0": VPN, "bridge100": CABLE,
    }  # fmt: skip
    assert {name: kind_of(name, system=tmp_path) for name in names} == names
    assert kind_of("corp", is_point_to_point=True, system=tmp_path) is VPN


@pytest.mark.parametrize(
    ("kind", "texts", "wanted"),
    [
        (71, ("Microsoft Wi-Fi Direct Virtual Adapter", "Local Area Connection* 2"), WIFI),
        (6, ("Intel(R) Ethernet Connection I219-V", "Ethernet"), CABLE),
        (6, ("Hyper-V Virtual Ethernet Adapter", "vEthernet (WSL)"), VPN),
        (6, ("TAP-Windows Adapter V9", "Ethernet 3"), VPN),
        (53, ("WireGuard Tunnel", "office"), VPN),
    ],
)
def test_windows_says_what_an_interface_is(kind, texts, wanted):
    assert kind_of_windows(kind, texts) is wanted


IF_INET6 = """\
20010db80001000200000000000000a5 02 40 00 80     eth0
20010db8000100027d1ac04ff0e3b29d 02 40 00 01     eth0
fd00000000000000e4c29a1f08b7d356 03 40 00 21    wlan0
fe80000000000000020c29fffe3b1c2d 02 40 20 80     eth0
00000000000000000000000000000001 01 80 10 80       lo
"""
IFCONFIG = """\
lo0: flags=8049<UP,LOOPBACK,RUNNING,MULTICAST> mtu 16384
\tinet6 ::1 prefixlen 128
\tinet6 fe80::1%lo0 prefixlen 64 scopeid 0x1
en0: flags=8863<UP,BROADCAST,SMART,RUNNING,SIMPLEX,MULTICAST> mtu 1500
\tether 02:00:5e:10:00:01
\tinet6 fe80::c4:1f2e:9a0b:77d1%en0 prefixlen 64 secured scopeid 0xb
\tinet6 2001:db8:1:2:10af:83c2:55e0:91b4 prefixlen 64 autoconf secured
\tinet6 2001:db8:1:2:7d1a:c04f:f0e3:b29d prefixlen 64 autoconf temporary
\tinet6 2001:db8:1:2:0:0:0:c5b3 prefixlen 64 dynamic
\tinet6 fd00::e4c2:9a1f:8b7:d356 prefixlen 64 deprecated autoconf temporary
\tnd6 options=201<PERFORMNUD,DAD>
utun3: flags=8051<UP,POINTOPOINT,RUNNING,MULTICAST> mtu 1380
\tinet6 fe80::8d2c:4e51:17a9:f03b%utun3 prefixlen 64 scopeid 0x10
"""
PASSING = {"2001:db8:1:2:7d1a:c04f:f0e3:b29d", "fd00::e4c2:9a1f:8b7:d356"}


def test_linux_names_temporary_addresses():
    assert in_list(IF_INET6) == PASSING


def test_macos_names_temporary_addresses():
    assert in_ifconfig(IFCONFIG) == PASSING
    assert in_ifconfig("\tinet6 2001:db8::5/64 autoconf temporary\n") == {"2001:db8::5"}
    assert in_ifconfig("") == set()


@pytest.mark.parametrize(
    ("prefix", "suffix", "wanted"),
    [
        (4, 5, True),  # by router advertisement, random
        (4, 4, False),  # by router advertisement, of the link layer: the stable one
        (2, 5, False),  # link-local
        (3, 3, False),  # by DHCP
        (1, 1, False),  # by hand
    ],
)
def test_windows_names_temporary_addresses(prefix, suffix, wanted):
    assert is_temporary_windows(prefix, suffix) is wanted


@pytest.mark.skipif(sys.platform != "darwin", reason="others have no such ifconfig")
def test_macos_has_an_ifconfig_of_this_form():
    assert "inet6 ::1" in ifconfig()


def test_the_address_of_the_default_route_is_among_those_that_are_found():
    assert {*_of_default_route()} <= {*own_addresses()}


def test_an_ipv6_link_has_brackets_and_names_are_only_links_without_an_address():
    access = Access(8071, lan=True, hosts=("192.168.1.5", "fd00::5", "car", "car.local"), token="t")
    assert [link.url for link in access.lan_links] == [
        "http://192.168.1.5:8071/?token=t",
        "http://[fd00::5]:8071/?token=t",
    ]
    access.follow(("car",), None)
    assert access.lan_url == "http://car:8071/?token=t"


@pytest.fixture
def it(tmp_path):
    with rig(tmp_path, None) as it:
        it.server.guard.clock = lambda: 0.0
        yield it


def about_when(it, accepted):
    deadline = time.monotonic() + 60
    while not accepted(about := it.get("/about")):
        assert time.monotonic() < deadline, about
    return about


def refused(it, host, token):
    headers = {**OTHER, "Authorization": f"Bearer {token}", "Host": f"{host}:{it.port}"}
    return it.client.get("/api/about", headers=headers).status_code == 403


def test_a_hotspot_that_comes_later_gets_its_link_and_what_has_gone_is_refused(it):
    settings = it.dashboard.settings

    def here(*found):
        object.__setattr__(settings, "addresses", lambda: found)

    here("127.0.0.2", "car")
    asked = it.client.put("/api/network", json={"on": True}, headers=ME).json()
    token = it.access.token
    assert [link["address"] for link in asked["lan_links"]] == ["127.0.0.2"]
    assert refused(it, "127.0.0.3", token)
    here("127.0.0.3", "127.0.0.2", "car")
    about = about_when(it, lambda it: len(it["lan_links"]) == 2)
    assert about["lan_url"].startswith(f"https://127.0.0.3:{it.port}/?token={token}#")
    assert about["fingerprint"] != asked["fingerprint"]  # made anew, with the address
    assert not any(link["reached"] for link in about["lan_links"])
    assert not refused(it, "127.0.0.3", token)
    (first, second) = it.get("/about")["lan_links"]
    assert (first["reached"], second["reached"]) == (True, False)
    here("127.0.0.3", "car")
    about_when(it, lambda it: len(it["lan_links"]) == 1)
    assert refused(it, "127.0.0.2", token)
    with pytest.raises(ConnectionRefusedError):  # its socket is closed
        socket.create_connection(("127.0.0.2", it.port), 60)
    here("127.0.0.2", "127.0.0.3", "car")
    about_when(it, lambda it: len(it["lan_links"]) == 2)
    socket.create_connection(("127.0.0.2", it.port), 60).close()
    here("127.0.0.3", "car")
    about_when(it, lambda it: len(it["lan_links"]) == 1)
    for foreign in ("example.com", "[::ffff:127.0.0.3]", "127.0.0.3.nip.io", "[fd00::3]", "car."):
        assert refused(it, foreign, token), foreign
    assert it.client.get("/api/about/qr.svg", params={"address": "127.0.0.3"}).status_code == 200
    assert it.client.get("/api/about/qr.svg", params={"address": "10.1.1.1"}).status_code == 404


def test_ctypes_is_loaded_only_for_the_list_and_need_not_be_there():
    """Pyodide may have none."""
    line = (
        "import sys, mikas.dashboard.settings, mikas.dashboard.security.access\n"
        "assert 'mikas.dashboard.network.system' not in sys.modules\n"
        "sys.modules['ctypes'] = None\n"
        "from mikas.dashboard.network.addresses import own_addresses\n"
        "assert own_addresses()\n"
    )
    subprocess.run([sys.executable, "-c", line], check=True)
