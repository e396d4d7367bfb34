"""A broker whose network goes without a word, and comes back: Mosquitto in its own namespace."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from contextlib import contextmanager

import pytest

import netns_rig
from netns_rig import IP, run, two_namespaces

CAR, BROKER = "10.77.0.2", "10.77.0.1"
MOSQUITTO = shutil.which("mosquitto", path=f"{os.environ.get('PATH', '')}:/usr/sbin:/sbin")
pytestmark = [
    *netns_rig.marks,
    pytest.mark.skipif(
        not os.environ.get("MIKAS_REQUIRE_NETNS") and MOSQUITTO is None, reason="needs Mosquitto"
    ),
]


@contextmanager
def started(name, *words, **more):
    with subprocess.Popen([IP, "netns", "exec", name, *words], **more) as process:
        try:
            yield process
        finally:
            process.terminate()
            process.wait(120)


def next_change(process):
    """The next change of the broker; a publisher that ends fails here."""
    for line in process.stdout:
        if "connected" in (found := json.loads(line)).get("broker", found):
            return found.get("broker", found)
    raise AssertionError("publishing has ended")


def test_a_silent_broker_is_called_dead_and_is_back_with_its_network(tmp_path):
    """There is no FIN: only the silence says it."""
    config = tmp_path / "mosquitto.conf"
    config.write_text(f"listener 1883 {BROKER}\nallow_anonymous true\nuser root\n")
    publish = (sys.executable, "-m", "mikas", "publish", f"mqtt://{BROKER}", "TWAT", "--json",
               "--port", "sim:")  # fmt: skip
    with (
        two_namespaces("car", "broker") as (car, broker),
        started(broker, MOSQUITTO, "-c", str(config), stderr=subprocess.DEVNULL),
        started(car, *publish, stdout=subprocess.PIPE, text=True) as process,
    ):
        while not next_change(process)["connected"]:
            pass  # it begins before the broker listens
        silence = ("blackhole", f"{CAR}/32")  # nothing of the broker's end leaves it, no ACK either
        run(IP, "-n", broker, "route", "add", *silence)
        lost = next_change(process)
        assert not lost["connected"]
        assert "no answer within seconds" in lost["reason"]["en"]
        run(IP, "-n", broker, "route", "del", *silence)
        while not next_change(process)["connected"]:
            pass
