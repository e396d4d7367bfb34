"""The words of an error fit the kind of port: a table of all of a connection, and both kinds."""

from __future__ import annotations

import re

import pytest

from mikas import errors
from mikas.cli.advice import ADVICE as TERMINAL
from mikas.dashboard.errors import ADVICE as DASHBOARD
from mikas.errors import LineError, MikasError, NoBroker, NoConnection, PortKind, met_on
from mikas.i18n import Text
from test_advice import CLASSES, example

OF_THIS_COMPUTER = (
    *(errors.PortNotFound, errors.PortDenied, errors.PortProbed),  # names of ports, and rights
    *(errors.RecordingOver, NoBroker),
)
OVER_NETWORK = [
    it
    for it in CLASSES
    if issubclass(it, NoConnection | LineError) and not issubclass(it, OF_THIS_COMPUTER)
]
NEAR = re.compile(
    r"\bUSB\b|plug (it|the adapter)|[Uu]nplug|ModemManager|dialout|разъём USB|тключите адаптер"
)
BRIDGE = re.compile(r"bridge|Wi-Fi|мост|Wi-Fi")
CAR = re.compile(r"12 V|K-Line or ground|\bground\b|12 В|\bмасс", re.IGNORECASE)


@pytest.mark.parametrize("kind", OVER_NETWORK)
@pytest.mark.parametrize(
    "table", [None, TERMINAL, DASHBOARD], ids=["text", "terminal", "dashboard"]
)
def test_over_a_network_the_bridge_comes_before_the_car_and_no_usb_at_all(kind, table) -> None:
    error = met_on(PortKind.NETWORK, example(kind))
    for words in error.text if table is None else table.text(error):
        assert not NEAR.search(words), words
        assert "{" not in words
        if (car := CAR.search(words)) is not None:
            assert BRIDGE.search(words[: car.start()]), words


@pytest.mark.parametrize("kind", OVER_NETWORK)
def test_at_a_cable_no_bridge_is_named(kind) -> None:
    plain = example(kind).text
    assert met_on(PortKind.CABLE, example(kind)).text == plain
    for words in plain:
        assert not BRIDGE.search(words), words


@pytest.mark.parametrize("kind", [NoConnection, LineError])
def test_a_subclass_has_the_words_of_its_base_unless_it_has_its_own(kind) -> None:
    for each in (it for it in OVER_NETWORK if issubclass(it, kind)):
        over = met_on(PortKind.NETWORK, example(each)).advice
        if "advice" not in each.__dict__:
            base = each.__mro__[1]
            assert over == met_on(PortKind.NETWORK, example(base)).advice or base is NoConnection


def test_advice_for_this_case_stays() -> None:
    other = Text("Do that.", "Сделайте это.")
    error = met_on(PortKind.NETWORK, errors.NoEcho(advice=other))
    assert error.advice == other
    assert DASHBOARD.advice(error) == other


def test_what_the_terminal_and_the_screens_add_stays() -> None:
    error: MikasError = met_on(PortKind.NETWORK, errors.NoEcho())
    assert "mikas doctor" in TERMINAL.text(error).en
    assert error.text.en.endswith("the ignition is off.")


@pytest.mark.parametrize("table", [TERMINAL, DASHBOARD], ids=["terminal", "dashboard"])
@pytest.mark.parametrize("kind", OVER_NETWORK)
def test_over_a_network_nothing_sends_to_the_list_of_this_computers_ports(kind, table) -> None:
    for words in table.text(met_on(PortKind.NETWORK, example(kind))):
        assert not re.search("lists the ports|mikas ports|Порты перечислены", words), words


def test_a_slow_network_is_among_the_causes_with_the_option() -> None:
    error = met_on(PortKind.NETWORK, errors.NoEcho())
    assert "network is slow" in error.text.en
    assert "медленная сеть" in error.text.ru
    assert all("--timeout" in words for words in TERMINAL.text(error))


def test_a_lost_connection_is_no_adapter_that_is_gone() -> None:
    problem = Text("closed by the other end", "закрыто другой стороной")
    error = met_on(PortKind.NETWORK, errors.LinkLost(url="socket://h:1", problem=problem))
    assert error.reason.en == "The connection to socket://h:1 is lost: closed by the other end"
    assert error.reason.ru == "Связь с socket://h:1 потеряна: закрыто другой стороной"
