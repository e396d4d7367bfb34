"""What a careless program finds out all the same: a recorder that fails, paths, wrong options."""

from __future__ import annotations

import errno
import os
from pathlib import PurePosixPath

import pytest

import mikas
from mikas.errors import BadPortUrl, LinkClosed, UsageError
from mikas.recording import CaptureWriter
from mikas.virtual.build import SETTINGS

SIM = "sim:?clock=simulated"


class Full(Exception):
    pass


class Sink:
    """Takes so many records, then fails."""

    def __init__(self, records):
        self.left = records

    def record(self, direction, data, time):
        self.left -= 1
        if self.left < 0:
            raise Full("no room")


class TestAFailingSink:
    def test_is_raised_by_each_request_from_then_on(self):
        with mikas.connect(SIM, sink=Sink(40)) as ecu:
            with pytest.raises(Full):
                ecu.memory.code.read_block(0, 0x4000)
            for _ in range(2):
                with pytest.raises(Full):
                    ecu.read("TWAT")

    def test_costs_no_memory_however_often_it_is_met(self):
        depths = []
        with mikas.connect(SIM, sink=Sink(40)) as ecu:
            for _ in range(5):
                with pytest.raises(Full) as caught:
                    ecu.memory.code.read_block(0, 0x4000)
                depths.append(len(caught.traceback))
        assert depths[-1] == depths[-2] <= depths[0]

    def test_while_connecting_leaves_no_port_open(self):
        with pytest.raises(Full):
            mikas.connect(SIM, sink=Sink(1))

    def test_calls_back_once_and_the_session_goes_on(self):
        failures = []
        with mikas.connect(SIM, sink=Sink(40), on_sink_failure=failures.append) as ecu:
            assert len(ecu.memory.code.read_block(0, 0x4000)) == 0x4000
            assert ecu.read("TWAT")
        assert [type(failure) for failure in failures] == [Full]

    def test_may_be_refused_by_the_callback(self):
        def refuse(error):
            raise KeyError("stop") from error

        with mikas.connect(SIM, sink=Sink(40), on_sink_failure=refuse) as ecu:
            for _ in range(2):
                with pytest.raises(KeyError, match="stop"):
                    ecu.memory.code.read_block(0, 0x4000)


@pytest.mark.parametrize("kind", [str, os.fspath, lambda path: path, PurePosixPath])
class TestPaths:
    def test_of_catalogs_journal_and_state(self, kind, tmp_path):
        own = tmp_path / "mine.toml"
        own.write_text("[parameter.TWAT]\ntext = { en = 'Mine', ru = 'Моё' }\n")
        for catalogs in (kind(own), [kind(own)]):
            with mikas.connect(
                SIM,
                catalogs=catalogs,
                journal=kind(tmp_path / "kept" / "journal"),
                state=kind(tmp_path / "units"),
            ) as ecu:
                assert ecu.catalog.parameter("TWAT").text.en == "Mine"
                ecu.set_list("TWAT")
        assert (tmp_path / "kept" / "journal").is_file()

    def test_of_recordings(self, kind, tmp_path):
        path = tmp_path / "drive.pcapng"
        with CaptureWriter(path, url=SIM) as sink, mikas.connect(SIM, sink=sink) as ecu:
            ecu.read("TWAT")
        assert mikas.open(kind(path)) is not None


def test_a_virtual_unit_leaves_the_users_journal_alone(tmp_path, monkeypatch):
    monkeypatch.delenv("MIKAS_STATE", raising=False)
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    monkeypatch.setenv("HOME", str(tmp_path))
    with mikas.connect(SIM) as ecu:
        ecu.memory.ram.write(0x40, 1)
    assert not list(tmp_path.rglob("journal*"))
    monkeypatch.setenv("MIKAS_STATE", str(tmp_path / "named"))
    with mikas.connect(SIM) as ecu:
        ecu.memory.ram.write(0x40, 1)
    assert (tmp_path / "named" / "journal.jsonl").is_file()


def test_an_unknown_option_lists_all(tmp_path):
    with pytest.raises(BadPortUrl) as caught:
        mikas.connect("sim:?bogus=1")
    for name in ("clock", *SETTINGS):
        assert f" {name}" in str(caught.value)


@pytest.mark.parametrize("url", [SIM, "sim:"])
def test_after_close_nothing_speaks_of_plugs(url):
    ecu = mikas.connect(url)
    ecu.close()
    for use in (lambda: ecu.read("TWAT"), ecu.faults, lambda: ecu.raw(b"\x01")):
        with pytest.raises(LinkClosed, match=r"is closed\. Connect again") as caught:
            use()
        assert "USB" not in str(caught.value)
        assert caught.value.errno in (None, errno.EBADF)


class HalfALink:
    """It has what is sent and read, and nothing else of the interface."""

    url = "half:"

    def write(self, data):
        pass

    read = now = send_break = close = write


@pytest.mark.parametrize(
    ("link", "why"),
    [
        ("sim:", r"an address comes first: connect\('sim:'\)"),
        (object(), r"has no url, baud, byte_time, can_break …"),
        (HalfALink(), r"derived from mikas.link.Link; .* has no baud"),
    ],
)
def test_what_is_no_link_is_a_type_error(link, why):
    with pytest.raises(TypeError, match=why):
        mikas.connect(link=link)


@pytest.mark.parametrize(
    "call",
    [
        lambda ecu: ecu.raw("01"),
        lambda ecu: ecu.raw([1]),
        lambda ecu: ecu.write_parameter("UOZ", raw="19"),
        lambda ecu: ecu.memory.ram.write(0x40, "FF"),
        lambda ecu: ecu.memory.ram.write(0x40, b"\x01"),
        lambda ecu: ecu.memory.ram.write_block(0x40, "0102"),
        lambda ecu: ecu.memory.ram.write_block(0x40, [1, 2]),
        lambda ecu: ecu.memory.ram.read("40"),
        lambda ecu: ecu.memory.code.read_block(0.5, 1),
        lambda ecu: ecu.goto("8000"),
    ],
)
def test_a_wrong_type_is_a_usage_error_before_a_byte_is_sent(call):
    with mikas.connect(SIM, confirm=lambda change: True) as ecu:
        before = ecu.tester.statistics.requests
        with pytest.raises(UsageError, match=r"needed, (as|such as) .* not"):
            call(ecu)
        assert ecu.tester.statistics.requests == before


def test_any_kind_of_bytes_is_sent():
    with mikas.connect(SIM) as ecu:
        assert ecu.raw(bytearray(b"\x01")) == ecu.raw(memoryview(b"\x01")) == b"\x0a"
        assert ecu.memory.ram.write_block(0x40, bytearray(b"\x05")).after == b"\x05"


def test_a_unit_shows_its_model_and_its_port():
    with mikas.connect(SIM) as ecu:
        assert repr(ecu) == f"<Ecu Mikas 7.1 on {SIM}>"
    assert repr(ecu) == f"<Ecu Mikas 7.1 on {SIM}>"
