"""70-mikas.rules in the hands of a real udev, when a cable is plugged in."""

from __future__ import annotations

import pytest

from cable.image_rig import find_udev

RULES = "/etc/udev/rules.d/70-mikas.rules"
# In the place of ModemManager's and brltty's rules, which come later and compare the same.
LATER = """\
ACTION=="remove", GOTO="end"
SUBSYSTEM=="tty", ENV{ID_MM_DEVICE_IGNORE}!="1", ENV{SEEN_BY_MODEM_MANAGER}="1"
SUBSYSTEM=="usb", ENV{PRODUCT}=="403/6001/*", ENV{SEEN_BY_BRLTTY}="1"
LABEL="end"
"""
START = """
mkdir -p /run/udev/rules.d
cp "$1"/*.rules /run/udev/rules.d/
cp later.rules /run/udev/rules.d/85-later.rules
ln -sf "$0" /run/systemd-udevd
exec /run/systemd-udevd
"""


@pytest.fixture
def udevadm(box):
    """`udevadm`, with the daemon running."""
    program, rules = find_udev()
    (box.home / "later.rules").write_text(LATER)
    daemon = box.start("sh", "-c", START, str(program), str(rules))

    def udevadm(*words):
        assert daemon.status is None, daemon.err
        return box.run(str(program), *words)

    box.run("sh", "-c", "until [ -S /run/udev/control ]; do sleep 0.1; done")
    done = udevadm("control", "--ping")
    assert done.status == 0, done
    yield udevadm
    box.run("rm", "-f", RULES)
    box.run("rm", "-r", "/run/udev")


def properties(udevadm, path):
    done = udevadm("info", "--query=property", path)
    assert done.status == 0, done
    return dict(line.split("=", 1) for line in done.out.splitlines())


def plugged(box, udevadm):
    """Plug a cable in; return what udev knows of its port and its device, and the timer."""
    name = box.cable().plug()
    assert udevadm("settle").status == 0
    timer = box.run("cat", f"/sys/bus/usb-serial/devices/{name}/latency_timer").out.strip()
    device = box.run("readlink", "-f", f"/sys/bus/usb-serial/devices/{name}/../..").out.strip()
    return properties(udevadm, f"/sys/class/tty/{name}"), properties(udevadm, device), timer


def test_the_rules_keep_others_off_and_lower_the_latency_timer(box, udevadm):
    port, device, timer = plugged(box, udevadm)
    box.unplug_cables()
    assert (port["SEEN_BY_MODEM_MANAGER"], device["SEEN_BY_BRLTTY"]) == ("1", "1")
    assert "uaccess" not in port.get("TAGS", "")
    assert timer != "1"

    done = box.run("mikas", "ports", "--install-rules", "--yes")
    assert done.status == 0, done
    assert udevadm("control", "--reload").status == 0
    port, device, timer = plugged(box, udevadm)
    assert port["ID_MM_DEVICE_IGNORE"] == device["ID_MM_DEVICE_IGNORE"] == "1"
    assert "SEEN_BY_MODEM_MANAGER" not in port
    assert "SEEN_BY_BRLTTY" not in device
    assert ":uaccess:" in port["TAGS"]
    assert timer == "1"


def test_udev_has_nothing_to_say_against_the_rules(box, udevadm):
    name = box.cable().plug()
    assert box.run("mikas", "ports", "--install-rules", "--yes").status == 0
    done = udevadm("test", f"/sys/class/tty/{name}")
    assert done.status == 0, done
    assert f"Reading rules file: {RULES}" in done.err
    about = [line for line in done.err.splitlines() if line.startswith(f"{RULES}:")]
    assert about == []
