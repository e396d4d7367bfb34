"""The whole way: `mikas dash` and `mikas sim`, two processes with a pty between them."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from contextlib import contextmanager

import pytest
from playwright.sync_api import expect

from browser.rig import CAR

pytestmark = pytest.mark.realtime


@contextmanager
def mikas(*argv, folder):
    environment = {**os.environ, "HOME": str(folder), "XDG_STATE_HOME": str(folder / "state")}
    process = subprocess.Popen(
        [sys.executable, "-m", "mikas", *argv],
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        env=environment,
    )
    try:
        yield process.stdout.readline().decode().strip()
    finally:
        process.kill()
        process.communicate()


def test_a_cable_that_is_pulled_and_a_program_that_ends_come_back(visitor, tmp_path):
    (tmp_path / "car.toml").write_text(CAR, "utf-8")
    cable = tmp_path / "ttyUSB0"
    sim = ("sim", "--scenario", str(tmp_path / "car.toml"))
    dash = ("dash", "--no-browser", "--json", "--record", str(tmp_path))
    with mikas(*dash, folder=tmp_path) as said:
        url = json.loads(said)["url"]
        tab = visitor(url).show("connection")
        with mikas(*sim, folder=tmp_path) as pty:
            cable.symlink_to(pty)
            tab.find("summary", has_text="Another port").click()
            tab.find("form input").fill(str(cable))
            tab.find("form [type=submit]").click()
            tab.is_line("sampling")
            tab.show("live")
            expect(tab.value("UACC")).to_have_text("13.8")
            cable.unlink()
        tab.is_line("no-port")
        expect(tab.find("header [role=alert]")).to_be_visible()
        with mikas(*sim, folder=tmp_path) as pty:
            cable.symlink_to(pty)
            tab.is_line("sampling")
            expect(tab.value("UACC")).to_have_text("13.8")
    tab.refused = True
    tab.is_line("lost")
    tab.says("Program does not answer")
    port = url.rstrip("/").rpartition(":")[2]
    with mikas(*dash, "--host-port", port, folder=tmp_path):
        tab.is_line("off")
