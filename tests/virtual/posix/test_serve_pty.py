"""A served unit on a pty, for real; and the whole product over one, with echo and pacing."""

from __future__ import annotations

import asyncio
import os
import select
from contextlib import contextmanager, suppress
from time import monotonic

import pytest

import mikas
from mikas.errors import LinkLost
from mikas.framing import encode
from mikas.virtual import serve
from mikas.virtual.build import build_bus
from mikas.virtual.memory import pattern
from protocol_codes import NAMES, SECTION_4, SIMULATED
from virtual_harness import DATA

from ..serving import PATIENCE, a_pty_port, read_until, serving

pytestmark = pytest.mark.realtime

BYTE, TURN = 10 / 9600, 0.002
ASKED = b"\x01\xff\x0d"
ANSWERED = ASKED + b"\x0a\xf6\x0d"


@contextmanager
def opened(path: str):
    port = os.open(path, os.O_RDWR | os.O_NOCTTY)
    try:
        yield port
    finally:
        os.close(port)


def some(port: int, seconds: float) -> bytes:
    ready, _, _ = select.select([port], [], [], seconds)
    return os.read(port, 4096) if ready else b""


def ask(port: int, wire: bytes = ASKED, count: int = len(ANSWERED)) -> bytes:
    os.write(port, wire)
    return read_until(lambda seconds: some(port, seconds), lambda data: len(data) >= count)


def test_the_tester_receives_the_echo_and_the_answer():
    with serving(a_pty_port) as server, opened(server.url) as port:
        assert ask(port) == ANSWERED


def test_bytes_are_no_faster_than_the_wire():
    request = encode(b"\x61" + bytes(DATA))
    size = len(request) + 27
    with serving(a_pty_port) as server, opened(server.url) as port:
        began = monotonic()
        heard = ask(port, request, size)
        assert monotonic() - began >= size * BYTE + TURN - 1e-3
        assert heard.startswith(request)


def test_control_characters_are_bytes_like_any_other():
    every = bytes(range(256))
    with serving(a_pty_port) as server, opened(server.url) as port:
        assert ask(port, every, 256)[:256] == every


def test_a_tester_may_reconnect():
    with serving(a_pty_port) as server:
        for _ in range(3):
            with opened(server.url) as port:
                assert ask(port) == ANSWERED


def test_a_tester_that_does_not_read_loses_bytes_and_the_unit_goes_on():
    """A stream that fills the pty; then the tester, or another one, takes up again."""
    with serving(a_pty_port, {"baud": "1000000", "turn_round": "0"}) as server:
        with opened(server.url) as port:
            os.write(port, encode(b"\x71" + bytes(DATA)))
            full = read_until(lambda seconds: some(port, seconds), lambda data: len(data) > 100)
            assert full
        with opened(server.url) as port:
            deadline = monotonic() + PATIENCE
            heard = b""
            while not heard.endswith(ANSWERED[3:]):
                assert monotonic() < deadline
                os.write(port, ASKED)  # the first one only ends the stream
                heard = b""
                while piece := some(port, 0.2):
                    heard = (heard + piece)[-64:]


def test_closing_takes_the_port_away():
    with serving(a_pty_port) as server, opened(server.url) as port:
        assert ask(port) == ANSWERED
        server.close()
        with suppress(OSError):  # EIO, or an end of file
            assert os.read(port, 1) == b""


def test_closing_is_an_adapter_unplugged(tmp_path):
    with (
        serving(a_pty_port) as server,
        mikas.connect(server.url, journal=tmp_path / "journal", state=tmp_path) as ecu,
    ):
        server.close()
        with pytest.raises(LinkLost):
            ecu.faults()


def test_many_ptys_on_one_loop_answer_as_themselves():
    models = ["5.4", "7.1"] * 2
    with serving(a_pty_port, *({"model": model} for model in models)) as server:
        for model, url in zip(models, server.urls, strict=True):
            with opened(url) as port:
                assert ask(port)[3] == (0x09 if model == "5.4" else 0x0A)


@pytest.fixture
def pinned(tmp_path):
    """A scenario whose every datum is the exchange vectors' one."""
    lines = ["duration = 3600", "faults = [13, 53, 64]", 'passports = ["МИКАС 7.1"]']
    lines += ["[start]", "running = true", "[timeline]", "throttle = 0", "[raw]"]
    lines += [f'"0x{code:02X}" = "{raw.hex()}"' for code, raw in DATA.items()]
    path = tmp_path / "pinned.toml"
    path.write_text("\n".join(lines), "utf-8")
    return str(path)


def test_all_values_are_read_over_a_pty_with_echo_and_pacing(pinned, tmp_path):
    expected = {p.name: p.decode(DATA[p.code]) for p in SECTION_4.parameters}
    assert len(expected) == 23
    with (
        serving(a_pty_port, {"scenario": pinned}) as server,
        mikas.connect(
            server.url, confirm=lambda _: True, journal=tmp_path / "journal", state=tmp_path
        ) as ecu,
    ):
        assert ecu.tester.line.echo
        info = ecu.info()
        assert info.version_code == 0x0A
        assert info.parameter_count == SIMULATED
        assert info.passport.program[0] == "МИКАС 7.1"
        # §5: seconds that a full set takes at least, by the wire alone.
        for method, least in (("single", 0.200), ("batch", 0.056), ("list", 0.033)):
            began = monotonic()
            (sample,) = ecu.watch(*NAMES, method=method, count=1)
            assert monotonic() - began >= least * 0.99, method
            assert not sample.gap
            assert {name: r.value for name, r in sample.readings.items()} == expected, method
        with ecu.stream(*NAMES) as readings:
            began = monotonic()
            samples = [next(readings) for _ in range(5)]
            assert monotonic() - began >= 4 * 27 * BYTE * 0.9  # the first was under way
        for sample in samples:
            assert {name: r.value for name, r in sample.items()} == expected
        everything = ecu.read()
        assert {name: everything[name].value for name in NAMES} == expected
        assert [fault.code for fault in ecu.faults()] == [13, 53, 64]
        began = monotonic()
        assert ecu.memory.code.read_block(0x8000, 300) == pattern("code")[0x8000:0x812C]
        assert monotonic() - began >= 300 * BYTE
        assert ecu.erase_faults().after == ()


def test_a_flood_waits_at_its_sender():
    """Writing to the port blocks, as on a real one; 1 KiB waits for the wire, and none is lost."""

    async def main():
        now = 0.0
        bus = build_bus({"baud": "2000000"}, start=now)
        port = serve.PtyPort(bus, lambda: now)
        waiting = bus.tester.queue
        with opened(port.url) as tester:
            os.set_blocking(tester, False)
            sent, heard, blocked = 0, 0, False
            while not (blocked and len(waiting) >= 1024):  # the wire stands still
                try:
                    sent, blocked = sent + os.write(tester, bytes(4096)), False
                except BlockingIOError:  # by what the port has not read
                    blocked = True
                await asyncio.sleep(0)
            total = sent + 2048
            while heard < total:
                with suppress(BlockingIOError):
                    sent += os.write(tester, bytes(total - sent)) if sent < total else 0
                with suppress(BlockingIOError):
                    heard += len(os.read(tester, 4096))
                now += 0.001
                await asyncio.sleep(0)
                assert len(waiting) <= 1024
        port.close()

    serve.run(main())
