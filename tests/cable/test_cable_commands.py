"""An owner's commands with the cable plugged in, over Linux' own driver."""

from __future__ import annotations

import json
from pathlib import Path

from cable.recorded_rig import STILL, received, summary, wrong_values
from mikas.virtual.memory import pattern

LATENCY = Path("/sys/bus/usb-serial/devices/ttyUSB0/latency_timer")


def test_ports_names_chip_and_serial_number(box, cable):
    (port, *others) = box.run("mikas", "ports", "--json").json["ports"]
    assert (port["url"], port["chip"], port["likely"]) == ("/dev/ttyUSB0", "FT232R", True)
    assert port["serial_number"] == cable.serial
    assert not any(other["likely"] for other in others)


def test_doctor_finds_nothing_wrong_and_lowers_the_latency_timer(box, cable):
    box.run("sh", "-c", f"echo 16 >{LATENCY}")  # as a real chip begins; QEMU's has 0
    done = box.run("mikas", "doctor", "--json")
    assert done.status == 0, done
    verdicts = {step["name"]: step["ok"] for step in done.json["steps"]}
    timed = {"baud", "latency"}  # of an emulated computer, which may be slow
    assert all(verdicts[name] for name in verdicts.keys() - timed), done
    assert not any(verdicts[name] is False for name in timed), done
    assert box.run("cat", str(LATENCY)).out == "1\n"


def test_read_gives_the_values_of_the_unit(box, cable):
    done = box.run("mikas", "read", "--json")
    assert done.status == 0, done
    readings = done.json["readings"]
    assert len(readings) == 23
    assert {name: readings[name]["value"] for name in STILL} == STILL


def test_log_records_every_byte_without_a_line_error(box, cable):
    out = box.home / "drive.pcapng"
    done = box.run("mikas", "log", "-o", str(out), "FREQ", "TWAT", "--count", "100", "--json")
    assert done.status == 0, done
    assert ", 0 gaps, 0 line errors," in done.err
    assert sum(not json.loads(line)["gap"] for line in done.out.splitlines()) == 100
    assert received(out) == cable.wire.delivered[0]
    assert summary(out).gaps == 0
    assert wrong_values(out) == {}


def test_a_break_reaches_the_wire_and_ends_a_stream_that_nothing_else_ends(box):
    """D12: the tester's last means."""
    cable = box.cable(stream_end="break")
    cable.plug()
    done = box.run("mikas", "watch", "FREQ", "TWAT", "--method", "stream", "--count", "20")
    assert done.status == 0, done
    assert cable.wire.breaks > 0
    assert box.run("mikas", "read", "TWAT").status == 0


def test_a_whole_memory_comes_over_the_cable(box):
    cable = box.cable(baud="115200")
    cable.plug()
    out = box.home / "code.bin"
    port = "/dev/ttyUSB0?baud=115200"
    done = box.run("mikas", "--port", port, "mem", "dump", "code", "-o", str(out))
    assert done.status == 0, done
    assert out.read_bytes() == pattern("code")


def test_two_cables_at_once_give_the_values_of_their_units(box):
    cables = [
        box.cable(0, serial="A50285BI", model="7.1"),
        box.cable(1, serial="FTG7X2QD", model="5.4"),
    ]
    names = [cable.plug() for cable in cables]
    assert box.run("mikas", "read", "TWAT").status == 3  # which of them?
    files = [box.home / f"{name}.pcapng" for name in names]
    logs = [
        box.start(
            "mikas", "--port", f"/dev/{name}", "log", "-o", str(file), "FREQ", "--count", "60"
        )
        for name, file in zip(names, files, strict=True)
    ]
    for log, cable, file, model in zip(logs, cables, files, ("7.1", "5.4"), strict=True):
        done = log.wait()
        assert done.status == 0, done
        assert ", 0 gaps, 0 line errors," in done.err
        assert received(file) == cable.wire.delivered[0]
        assert model in summary(file).model.en
