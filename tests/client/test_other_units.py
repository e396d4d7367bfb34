"""What is found on a line where no Mikas answers, and that it is named (`doctor --other-units`)."""

from __future__ import annotations

import socket
import threading
from contextlib import contextmanager

import pytest

from mikas import kwp2000
from mikas.client.connecting import ConnectionOptions
from mikas.client.doctor import examine
from mikas.client.other_units import NAMES, OTHER_BAUDS, other_units
from mikas.link import open_link
from mikas.link.base import LinkWrapper
from mikas.link.virtual import VirtualLink
from mikas.virtual.build import build_bus
from mikas.virtual.kwp2000_unit import Kwp2000Bus


def a_link(**settings: str) -> VirtualLink:
    return VirtualLink(build_bus(settings))


def examined(link):
    """Every step of the doctor, with the other units."""
    return {
        step.name: step
        for step in examine(
            lambda: link, ConnectionOptions(virtual_units=False).create_ecu, others=other_units
        )
    }


@pytest.mark.parametrize("echo", ["1", "0"])
@pytest.mark.parametrize("latency", ["0", "1", "16"])
@pytest.mark.parametrize(
    ("protocol", "found"),
    [
        ("kwp2000", {"kwp2000-fast", "kwp2000-slow"}),
        ("kwp2000-fast", {"kwp2000-fast"}),
        ("kwp2000-slow", {"kwp2000-slow"}),
    ],
)
def test_a_unit_that_speaks_kwp2000_is_named(protocol, found, latency, echo):
    link = a_link(protocol=protocol, latency_ms=latency, echo=echo)
    steps = examined(link)
    assert tuple(steps)[-4:] == NAMES
    assert not any(steps[name].ok is False for name in NAMES)
    assert {name for name in NAMES if steps[name].ok} == found
    for name in found:
        detail = steps[name].detail
        assert "this unit speaks KWP2000" in detail.en
        assert "EF 8F" in detail.en
        assert "TesterPresent" in detail.en  # the session was open
        assert "7.6, 10.3, 11" in detail.ru
    assert link.baud == link.bus.baud == 9600  # put back


def test_nothing_but_the_wake_ups_goes_to_the_unit():
    """StartCommunication, TesterPresent, StopCommunication, and it sleeps afterwards."""
    link = a_link(protocol="kwp2000")
    bus = link.bus
    assert isinstance(bus, Kwp2000Bus)
    heard = []
    answer = bus.kwp2000._answer  # noqa: SLF001  (every message that the unit takes)

    def watched(message, end):
        heard.append(message.data)
        answer(message, end)

    bus.kwp2000._answer = watched  # noqa: SLF001
    list(other_units(link))
    services = kwp2000.START, kwp2000.PRESENT, kwp2000.STOP
    assert heard == [*services, *services[1:]]
    assert not bus.kwp2000.awake


def test_the_wake_ups_have_the_standards_times():
    """To the microsecond, on simulated time: ISO 14230-2 allows 1 ms, and 5 % at 5 baud."""
    link = a_link(protocol="kwp2000")
    bus = link.bus
    assert isinstance(bus, Kwp2000Bus)
    lows, requests = [], []
    low, send = bus.kwp2000.low, bus.send

    def watched(begin, end):
        lows.append((begin, end))
        low(begin, end)

    def sent(data, now):
        if link.baud == kwp2000.BAUD:
            requests.append((now, data))
        send(data, now)

    bus.kwp2000.low, bus.send = watched, sent
    list(other_units(link))
    (begin, end), *slow = lows
    assert end - begin == pytest.approx(0.025, abs=1e-6)
    started = next(now for now, data in requests if data == kwp2000.encode(kwp2000.START))
    assert started - begin == pytest.approx(0.05, abs=1e-6)
    # 33 at 5 baud, the lowest bit first: low are the start bit and the bits 2, 3, 6, 7.
    first = slow[0][0]
    bits = [(round((a - first) / 0.2, 6), round((b - first) / 0.2, 6)) for a, b in slow]
    assert bits == [(0, 1), (3, 5), (7, 9)]


def test_a_mikas_that_answers_ends_the_search():
    """The wake-ups would be noise to it."""
    steps = examined(a_link())
    assert not steps.keys() & set(NAMES)
    assert steps["ecu"].ok


@pytest.mark.parametrize("baud", OTHER_BAUDS)
def test_a_mikas_of_another_baud_rate_is_named(baud):
    link = a_link(baud=str(baud), adapter_baud="9600")
    steps = examined(link)
    assert steps["other-baud"].ok
    assert f"`01` is answered at {baud} baud" in steps["other-baud"].detail.en
    assert f"?baud={baud}" in steps["other-baud"].detail.ru
    assert link.baud == 9600


def test_silence_stays_silence():
    """An adapter's echo alone is no answer of a unit."""
    for settings in ({"supplied": "1"}, {"supplied": "0"}):
        link = a_link(**settings)
        link.bus.ecu.responder.car.powered = lambda now: False
        for step in other_units(link):
            assert step.ok is None, step
            assert step.detail.en in ("no answer", "no bytes come unasked")


class Unable(LinkWrapper):
    """A port that can do neither, or only one of both."""

    def __init__(self, link, *, low: bool, baud: bool) -> None:
        super().__init__(link)
        self._low, self._baud = low, baud

    @property
    def can_break(self) -> bool:
        return self._low

    def set_baud(self, baud: int) -> bool:
        return self._baud and super().set_baud(baud)


@pytest.mark.parametrize(("low", "baud"), [(False, True), (True, False), (False, False)])
def test_a_port_that_can_not_says_so_and_is_not_called_silent(low, baud):
    link = Unable(a_link(protocol="kwp2000"), low=low, baud=baud)
    steps = {step.name: step for step in other_units(link)}
    for name in NAMES[2:]:
        assert steps[name].ok is None
        why = "can't be changed from here" if not baud else "can't hold the line low"
        assert why in steps[name].detail.en
    assert ("not tried" in steps["other-baud"].detail.en) is not baud
    assert link.baud == 9600


@contextmanager
def talker(*, every: float, data: bytes):
    """A device behind a TCP bridge that talks by itself, and answers nothing."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        over = threading.Event()

        def run() -> None:
            connection, _ = server.accept()
            with connection:
                while not over.wait(every):
                    try:
                        connection.sendall(data)
                    except OSError:
                        return

        thread = threading.Thread(target=run)
        thread.start()
        try:
            yield f"socket://127.0.0.1:{server.getsockname()[1]}"
        finally:
            over.set()
            thread.join()


@pytest.mark.realtime
def test_a_unit_that_talks_by_itself_is_named_through_a_real_socket():
    with talker(every=0.05, data=b"\x55\xaa\x12") as url, open_link(url) as link:
        steps = {step.name: step for step in other_units(link)}
    assert steps["unasked"].ok
    assert "bytes come unasked: 55 AA 12" in steps["unasked"].detail.en
    assert "перепрошитый" in steps["unasked"].detail.ru
    for name in NAMES[1:]:
        assert "over plain TCP the baud rate is the other end's" in steps[name].detail.en


def test_a_line_that_is_never_silent_is_not_woken_up():
    link = a_link(protocol="kwp2000")
    bus = link.bus

    def talk(value: int = 0x33) -> None:
        for number in range(200):
            bus.adapter.receive(value, number * 0.2)

    talk()
    steps = {step.name: step for step in other_units(link)}
    assert steps["unasked"].ok
    assert "bytes keep coming" in steps["kwp2000-fast"].detail.en


def test_an_unplugged_adapter_ends_the_search_with_its_error():
    link = a_link(protocol="kwp2000")
    steps = []
    for step in examine(
        lambda: link, ConnectionOptions(virtual_units=False).create_ecu, others=other_units
    ):
        steps.append(step)
        if step.name == "unasked":
            link.unplug()
    assert steps[-1].ok is False
    assert "unplugged" in steps[-1].detail.en
