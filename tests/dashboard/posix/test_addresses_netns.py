"""A program in a network of its own: no default route, a VPN in front, IPv6, a new hotspot."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from contextlib import contextmanager

import pytest

import netns_rig
from netns_rig import IP, run, two_namespaces

pytestmark = netns_rig.marks


@pytest.fixture
def computer():
    """Two namespaces: a computer, and a phone at the other end."""
    with two_namespaces("computer", "phone") as names:
        yield names


def link(computer, name, address, *route):
    """Give the computer another interface that is up."""
    run(IP, "-n", computer, "link", "add", name, "type", "veth", "peer", f"{name}-end")
    run(IP, "-n", computer, "addr", "add", address, "dev", name)
    for end in (name, f"{name}-end"):
        run(IP, "-n", computer, "link", "set", end, "up")
    if route:
        run(IP, "-n", computer, "route", "add", "default", "via", *route, "dev", name)


@contextmanager
def served(computer, folder, *options):
    environment = {
        **os.environ,
        **{f"XDG_{name}_HOME": str(folder) for name in ("STATE", "CONFIG")},
    }
    command = [IP, "netns", "exec", computer, sys.executable, "-m", "mikas", "demo", "--no-browser",
               "--record", str(folder / "recordings"), *options]  # fmt: skip
    with (
        (folder / "errors").open("w") as errors,
        subprocess.Popen(
            command, stdout=subprocess.PIPE, stderr=errors, text=True, env=environment
        ) as process,
    ):
        try:
            yield process
        finally:
            process.terminate()
            process.wait(120)


@contextmanager
def dashboard(computer, folder, *options):
    with served(computer, folder, "--json", *options) as process:
        yield json.loads(process.stdout.readline())


def status(who, url):
    """The status of the page at `url`, seen from a namespace."""
    code = (
        "import sys, httpx; c = httpx.Client(verify=False, timeout=60);"
        "print(c.get(sys.argv[1], follow_redirects=True).status_code)"
    )
    return int(run(IP, "netns", "exec", who, sys.executable, "-c", code, url))


def asked(computer, url, method="GET", body=None):
    code = (
        "import sys, httpx; h = {'X-Mikas-Client': 'tester-0001'};"
        "print(httpx.request(sys.argv[2], sys.argv[1], headers=h, timeout=60,"
        " json=eval(sys.argv[3])).text)"
    )
    words = sys.executable, "-c", code, url, method, repr(body)
    return json.loads(run(IP, "netns", "exec", computer, *words))


def test_without_a_default_route_and_behind_a_vpn_a_phone_comes_in(computer, tmp_path):
    here, phone = computer
    link(here, "tun9", "10.8.0.6/24", "10.8.0.1")
    link(here, "docker0", "172.17.0.1/16")
    with dashboard(here, tmp_path, "--lan") as shown:
        addresses = [url.split("//")[1].split("/")[0] for url in shown["lan_urls"]]
        port = shown["url"].rsplit(":", 1)[1].strip("/")
        wanted = ["10.77.0.2", "[fd77::2]", "10.8.0.6", "172.17.0.1"]
        assert addresses == [f"{host}:{port}" for host in wanted]
        assert shown["lan_url"] == shown["lan_urls"][0]
        for url in shown["lan_urls"][:2]:
            assert status(phone, url.partition("#")[0]) == 200
        bare = f"https://[fd77:0:0::2]:{port}/"
        assert status(phone, bare) == 401
        about = asked(here, f"{shown['url']}api/about")
        assert [it["reached"] for it in about["lan_links"]] == [True, True, False, False]


def test_an_address_that_comes_while_the_switch_is_on_is_opened(computer, tmp_path):
    here, phone = computer
    with dashboard(here, tmp_path) as shown:
        opened = asked(here, f"{shown['url']}api/network", "PUT", {"on": True})
        assert [it["address"] for it in opened["lan_links"]] == ["10.77.0.2", "fd77::2"]
        run(IP, "-n", here, "addr", "add", "10.78.0.2/24", "dev", "lan")
        run(IP, "-n", phone, "addr", "add", "10.78.0.1/24", "dev", "lan")
        run(IP, "-n", here, "addr", "del", "10.77.0.2/24", "dev", "lan")
        deadline = time.monotonic() + 120
        while True:
            about = asked(here, f"{shown['url']}api/about")
            if [it["address"] for it in about["lan_links"]] == ["10.78.0.2", "fd77::2"]:
                break
            assert time.monotonic() < deadline, about
        for it in about["lan_links"]:
            assert status(phone, it["url"].partition("#")[0]) == 200


def test_a_temporary_address_is_not_offered(computer, tmp_path):
    """It changes daily, and made a new certificate each time."""
    here, _ = computer
    run(IP, "netns", "exec", here, "sysctl", "-qw", "net.ipv6.conf.lan.use_tempaddr=2")
    stable = "fd78::2"
    run(IP, "-n", here, "addr", "add", f"{stable}/64", "dev", "lan", "nodad", "mngtmpaddr")
    deadline = time.monotonic() + 120
    while "temporary" not in run(IP, "-n", here, "-6", "addr", "show", "dev", "lan", "temporary"):
        assert time.monotonic() < deadline
    with dashboard(here, tmp_path, "--lan") as shown:
        hosts = {url.split("//")[1].split("]")[0].strip("[") for url in shown["lan_urls"]}
        assert {host for host in hosts if ":" in host and "." not in host} == {"fd77::2", stable}


def test_a_terminal_shows_the_links_of_a_new_address(computer, tmp_path):
    here, _ = computer
    with served(here, tmp_path, "--lan") as process:
        for line in process.stdout:
            if "10.77.0.2" in line:
                break
        run(IP, "-n", here, "addr", "add", "10.78.0.2/24", "dev", "lan")
        run(IP, "-n", here, "addr", "del", "10.77.0.2/24", "dev", "lan")
        deadline = time.monotonic() + 120
        while "//10.78.0.2:" not in (tmp_path / "errors").read_text():
            assert time.monotonic() < deadline, (tmp_path / "errors").read_text()
        assert "10.77.0.2" not in (tmp_path / "errors").read_text().partition("addresses have")[2]
