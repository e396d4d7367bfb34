"""The cable is pulled in the middle of an exchange, at an exact byte, and put back.

One recording goes through it all, with a gap and without a wrong value.
"""

from __future__ import annotations

import json

import pytest

from cable.recorded_rig import STILL, received, summary, wrong_values
from mikas.virtual.memory import pattern

FREQ = bytes.fromhex("61 29 76 0D")  # §3: the request, which the line echoes (D1)
MOMENTS = {
    "echo": ("single", lambda seen: seen.endswith(FREQ[:2])),
    "response": ("single", lambda seen: seen[:-1].endswith(FREQ)),
    "stream": ("stream", lambda seen: len(seen) == 37),
}
ENOUGH = 20
PACKET = 64  # bytes of a chip's packet at most
CONNECTING = bytes.fromhex("01 FF 0D")


def start_log(box, out, *options):
    return box.start("mikas", "log", "-o", str(out), "FREQ", "TWAT", "--json", *options)


def sampled(log, count=ENOUGH):
    """Wait for `count` samples of `log`, all of them right."""
    for _ in range(count):
        values = log.until(lambda line: not line["gap"])["values"]
        assert values == {name: STILL[name] for name in values}


CASES = [(chip, moment) for chip in ("FT232R", "CH340") for moment in MOMENTS]


@pytest.mark.parametrize(
    ("cable", "moment"),
    [*CASES, ("CP2102", "response"), ("PL2303HX", "response")],
    indirect=["cable"],
)
def test_the_log_goes_on_when_the_cable_is_back(box, cable, moment):
    method, condition = MOMENTS[moment]
    out = box.home / "drive.pcapng"
    log = start_log(box, out, "--method", method)
    sampled(log)
    is_taken = cable.cut_when(condition)() is not None
    log.until(lambda line: line["gap"])
    cable.plug()
    sampled(log)
    done = log.interrupt()
    assert done.status == 130
    assert "No adapter. Waiting" in done.err
    assert ", 1 gap, 0 line errors," in done.err
    assert summary(out).gaps == 1
    assert wrong_values(out) == {}
    # Nothing is lost but what was on its way through USB when the device vanished.
    before, after = cable.wire.delivered
    recorded = received(out)
    most = PACKET if is_taken else len(before)
    lost = next(n for n in range(most + 1) if recorded.startswith(before[: len(before) - n]))
    # Then the recording goes on with all that the cable brought, from the first request on. What
    # the unit streams before that reaches a terminal of Linux' while it is opened, which takes some
    # of it for keys.
    rest = recorded[len(before) - lost :]
    assert rest[rest.index(CONNECTING) :] in after


def test_a_dump_is_resumed_behind_the_last_whole_block(box, cable):
    out = box.home / "xram.bin"
    words = ("mikas", "mem", "dump", "xram", "-o", str(out), "--to", "03FF", "--block", "128")
    pull_when_cut = cable.cut_when(lambda seen: len(seen) == 500)
    dump = box.start(*words)
    pull_when_cut()
    done = dump.wait()
    assert done.status == 3
    blocks = len(out.read_bytes())
    assert f"Stopped: {blocks} of 1024 bytes" in done.err
    assert 0 < blocks < 500
    cable.plug()
    begin = len(cable.wire.sent)
    assert box.run(*words, "--resume").status == 0
    assert out.read_bytes() == pattern("xram")[:1024]
    assert b"\x23" + blocks.to_bytes(2, "little") in cable.wire.sent[begin:]  # row 23
    assert b"\x23\x00\x00" not in cable.wire.sent[begin:]


@pytest.mark.parametrize("seen", ["echo", "response"])
def test_a_memory_write_that_was_cut_is_journaled_and_can_be_read_back(box, cable, seen):
    """The unit may have written: only reading tells."""
    request = bytes.fromhex("24 00 10 04 01 02 03 04")
    end = request[:6] if seen == "echo" else request + bytes.fromhex("BE 0D 00")
    pull_when_cut = cable.cut_when(lambda seen: seen.endswith(end))
    write = box.start("mikas", "mem", "write", "xram", "1000", "01020304", "--yes")
    pull_when_cut()
    done = write.wait()
    assert done.status == 3
    assert "unknown" in done.err
    (journal,) = box.home.glob("**/journal.jsonl")
    entries = [json.loads(line) for line in journal.read_text("utf-8").splitlines()]
    assert [entry["after"] for entry in entries] == ["01 02 03 04"] * 2
    cable.plug()
    cells = cable.wire.bus.ecu.responder.memory.read("xram", 0x1000, 4)
    assert cells in {request[4:], pattern("xram")[0x1000:0x1004]}  # nothing half written
    read = box.run("mikas", "mem", "read", "xram", "1000", "4", "--json")
    assert bytes.fromhex(read.json["data"]) == cells


def test_a_parameter_write_that_was_cut_can_be_repeated(box, cable):
    words = ("mikas", "write", "RCOK", "--raw", "90", "--yes", "--json")
    pull_when_cut = cable.cut_when(lambda seen: seen.endswith(bytes.fromhex("62 42")))
    write = box.start(*words)
    pull_when_cut()
    done = write.wait()
    assert done.status == 3
    assert "Whether the change was made is unknown" in done.out
    cable.plug()
    done = box.run(*words)
    assert done.status == 0, done
    assert done.json["raw_after"] == "90"


def test_a_stranger_on_its_name_is_left_alone(box, cable):
    """The cable comes back under another name, because another one took its own."""
    stranger = box.cable(1, serial="FTG7X2QD")
    out = box.home / "drive.pcapng"
    log = start_log(box, out)
    sampled(log)
    cable.pull()
    log.until(lambda line: line["gap"])
    assert stranger.plug() == "ttyUSB0"
    log.until(lambda line: line["gap"])  # an attempt a second
    log.until(lambda line: line["gap"])
    assert cable.plug() == "ttyUSB1"
    sampled(log)
    assert log.interrupt().status == 130
    assert not stranger.wire.sent
    assert not stranger.was_opened
    assert summary(out).gaps == 1
    assert wrong_values(out) == {}
