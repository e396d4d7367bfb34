"""The logger `mikas.tester`: frames and failures at DEBUG."""

from __future__ import annotations

import logging

from stream_cases import SEVERAL
from tester_rig import Watched, right

from mikas import commands as c
from mikas.client import connect
from mikas.virtual.fault_injector import LineFault

SIM = "sim:?clock=simulated"


def lines(caplog):
    return [record.getMessage() for record in caplog.records if record.name == "mikas.tester"]


def test_frames_are_logged_with_their_direction(caplog, tmp_path):
    with caplog.at_level(logging.DEBUG, logger="mikas.tester"), connect(SIM, state=tmp_path) as ecu:
        caplog.clear()
        raw = ecu.read("TWAT")["TWAT"].raw
    sent, received = lines(caplog)[:2]
    assert sent == "> 61 1A 85 0D"
    assert received.startswith(f"< {raw.hex().upper()} ")
    assert all(record.levelno == logging.DEBUG for record in caplog.records)


def test_a_stream_is_logged_frame_by_frame(caplog, tmp_path):
    with connect(SIM, state=tmp_path) as ecu, caplog.at_level(logging.DEBUG, logger="mikas.tester"):
        list(ecu.watch("TWAT", "FREQ", method="stream", count=3))
    assert lines(caplog)[0].startswith("> 71 ")
    assert sum(line.startswith("< ") for line in lines(caplog)) >= 3


def test_a_failure_is_logged_with_the_bytes_received(caplog, tmp_path):
    with connect(SIM, state=tmp_path) as ecu, caplog.at_level(logging.DEBUG, logger="mikas.tester"):
        ecu.tester.link.bus.fault_injector.next(LineFault.DAMAGED)
        ecu.read("TWAT")
        (damaged,) = [line for line in lines(caplog) if line.startswith("! ")]
        assert " (received " in damaged
        caplog.clear()
        ecu.tester.link.bus.fault_injector.next(LineFault.LOST)
        ecu.read("TWAT")
    assert any(line.startswith("! ") and "0.5 s" in line for line in lines(caplog))


def test_a_spoilt_echo_and_a_streams_damaged_response_are_logged(caplog):
    unit = Watched()
    tester = unit.connected()
    with caplog.at_level(logging.DEBUG, logger="mikas.tester"):
        unit.fault_injector.spoils_next_echo = True
        right(tester, 22)
        spoilt = lines(caplog)
        caplog.clear()
        with tester.stream(c.StreamCyclic(SEVERAL)) as stream:
            next(stream)
            unit.fault_injector.next(None, LineFault.DAMAGED)
            for _ in range(3):
                next(stream)
    assert spoilt[0] == "> 61 16 89 0D"
    assert spoilt[1].startswith("! The echo differs")
    assert sum(line.startswith("! damaged: ") for line in lines(caplog)) == 1


def test_the_library_is_silent_by_default(capfd, tmp_path):
    logger = logging.getLogger("mikas.tester")
    assert not logger.isEnabledFor(logging.DEBUG)
    with connect(SIM, state=tmp_path) as ecu:
        ecu.read("TWAT")
    assert any(isinstance(handler, logging.NullHandler) for handler in logger.handlers)
    assert capfd.readouterr() == ("", "")
