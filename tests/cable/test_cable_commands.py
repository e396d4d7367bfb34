"""An owner's commands with the cable plugged in, over Linux' own driver of each chip."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from cable.recorded_rig import STILL, received, summary, wrong_values
from mikas.virtual.memory import pattern
from tester.tester_rig import case
from usb.chips.named import FOUR

LATENCY = Path("/sys/bus/usb-serial/devices/ttyUSB0/latency_timer")


CHIPS = {"FT232R": "FT232R", "CH340": "CH340", "CP2102": "CP210x", "PL2303HX": "PL2303"}
"""The name that the program has for each."""
each_chip = pytest.mark.parametrize("cable", FOUR, indirect=True)
LONG = ("FT232R", "CH340")
"""The chips of the long tests."""
two_chips = pytest.mark.parametrize("chip", LONG)


@each_chip
def test_ports_names_chip_and_serial_number(box, cable):
    (port, *others) = box.run("mikas", "ports", "--json").json["ports"]
    chip = CHIPS[cable.kind]
    assert (port["url"], port["chip"], port["likely"]) == ("/dev/ttyUSB0", chip, True)
    assert port["serial_number"] == (cable.serial or None)
    has_timer = any("latency timer" in it for it in map(str, port["quirks"]))
    assert has_timer == (cable.kind == "FT232R")
    assert not any(other["likely"] for other in others)


@each_chip
def test_doctor_finds_nothing_wrong_and_lowers_the_timer_of_an_ftdi(box, cable):
    timed = {"baud", "latency"}  # on an emulated computer, which may be slow
    for _ in range(2):
        done = box.run("mikas", "doctor", "--json")
        steps = {step["name"]: step for step in done.json["steps"]}
        wrong = [step for step in steps.values() if step["ok"] is False]
        if {step["name"] for step in wrong} - timed or not wrong:
            break
    assert not wrong
    assert done.status == 0
    assert all(steps[name]["ok"] for name in steps.keys() - timed), steps
    if cable.kind == "FT232R":
        assert box.run("cat", str(LATENCY)).out == "1\n"
    assert ("low latency" in str(steps["port"]["detail"])) == (cable.kind == "FT232R")


@each_chip
def test_read_gives_the_values_of_the_unit(box, cable):
    done = box.run("mikas", "read", "--json")
    assert done.status == 0, done
    readings = done.json["readings"]
    assert len(readings) == 23
    assert {name: readings[name]["value"] for name in STILL} == STILL


@each_chip
def test_log_records_every_byte_without_a_line_error(box, cable):
    out, count = box.home / "drive.pcapng", 100 if cable.kind in LONG else 30
    done = box.run("mikas", "log", "-o", str(out), "FREQ", "TWAT", "--count", str(count), "--json")
    assert done.status == 0, done
    assert ", 0 gaps, 0 line errors," in done.err
    assert sum(not json.loads(line)["gap"] for line in done.out.splitlines()) == count
    assert received(out) == cable.wire.delivered[0]
    assert summary(out).gaps == 0
    assert wrong_values(out) == {}


@pytest.mark.parametrize("chip", FOUR)
def test_a_break_reaches_the_wire_and_ends_a_stream_that_nothing_else_ends(box, chip):
    """D12: the tester's last means."""
    cable = box.cable(chip=chip, stream_end="break")
    cable.plug()
    done = box.run("mikas", "watch", "FREQ", "TWAT", "--method", "stream", "--count", "20")
    assert done.status == 0, done
    assert cable.wire.breaks > 0
    assert box.run("mikas", "read", "TWAT").status == 0


@two_chips
def test_a_whole_memory_comes_over_the_cable(box, chip):
    cable = box.cable(chip=chip, baud="115200")
    cable.plug()
    out = box.home / "code.bin"
    port = "/dev/ttyUSB0?baud=115200"
    done = box.run("mikas", "--port", port, "mem", "dump", "code", "-o", str(out))
    assert done.status == 0, done
    assert out.read_bytes() == pattern("code")


@pytest.mark.parametrize("chip", ["CP2102", "PL2303HX"])
def test_a_part_of_a_memory_comes_over_the_other_chips(box, chip):
    box.cable(chip=chip, baud="115200").plug()
    out = box.home / "xram.bin"
    words = ("mem", "dump", "xram", "-o", str(out), "--to", "07FF")
    done = box.run("mikas", "--port", "/dev/ttyUSB0?baud=115200", *words)
    assert done.status == 0, done
    assert out.read_bytes() == pattern("xram")[:2048]


def test_a_cp2102_at_10400_baud_is_named_as_the_reason(box):
    cable = box.cable(chip="CP2102", lost="1")
    cable.plug()
    done = box.run("mikas", "--port", "/dev/ttyUSB0?baud=10400", "doctor", "--json")
    assert done.status == 3, done
    assert cable.chip.uart.settings.rate == 14400
    steps = {step["name"]: step for step in done.json["steps"]}
    if steps["baud"]["ok"] is False:  # else the emulated computer was too slow to measure it
        assert "CP2101, CP2102, CP2103 or CP2108" in str(steps["baud"]["detail"])


def test_a_copy_that_linux_refuses_is_named_with_what_to_do(box):
    box.cable(chip="PL2303 unknown").put_in()
    box.run("sh", "-c", "until [ -e /sys/bus/usb/devices/1-1:1.0 ]; do sleep 0.1; done; sleep 0.3")
    for words, status in (("read", "TWAT"), 3), (("doctor",), 3), (("ports",), 0):
        with case(*words):
            done = box.run("mikas", *words)
            assert done.status == status, done
            assert "PL2303" in done.out + done.err
            assert "refuses copies of this chip" in done.out + done.err


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
