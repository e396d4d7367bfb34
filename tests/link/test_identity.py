"""Which port is the adapter that was opened first; values must never come from another car."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mikas.errors import AnotherAdapter, PortNotFound
from mikas.link.identity import KnownAdapter
from mikas.link.ports import Port

FIRST, SECOND = "/dev/ttyUSB0", "/dev/ttyUSB1"


def ftdi(url: str, number: str = "A1", location: str | None = "1-1") -> Port:
    return Port(url, "FT232R", vid=0x0403, pid=0x6001, serial_number=number, location=location)


def ch340(url: str, location: str | None = "1-1") -> Port:
    return Port(url, "USB Serial", vid=0x1A86, pid=0x7523, location=location)


def known(port: Port, *others: Port) -> KnownAdapter:
    adapter = KnownAdapter(port, [port, *others])
    adapter.opened(port)
    return adapter


def found(adapter: KnownAdapter, *present: Port) -> str:
    return adapter.locate(present, FIRST).url


def test_a_number_is_found_in_any_socket_under_any_name():
    adapter = known(ftdi(FIRST))
    assert found(adapter, ftdi(FIRST, "B2"), ftdi(SECOND, location="2-3.1")) == SECOND


@pytest.mark.parametrize(
    ("present", "words"),
    [
        ([ftdi(FIRST, "B2")], "another adapter has its port /dev/ttyUSB0 now (FT232R, B2)"),
        ([ch340(FIRST)], "another adapter has its port /dev/ttyUSB0 now (USB Serial)"),
        ([Port(FIRST, "built in")], "another adapter has its port /dev/ttyUSB0 now (built in)"),
    ],
)
def test_a_stranger_on_its_name_is_named(present, words):
    with pytest.raises(AnotherAdapter) as caught:
        found(known(ftdi(FIRST)), *present)
    assert words in caught.value.text.en
    assert "теперь занял другой" in caught.value.text.ru


def test_while_it_is_away_the_error_lists_the_other_ports():
    with pytest.raises(PortNotFound, match=SECOND) as caught:
        found(known(ftdi(FIRST)), ftdi(SECOND, "B2"))
    assert type(caught.value) is PortNotFound


def test_of_two_without_a_number_the_socket_decides():
    adapter = known(ch340(FIRST, "1-1"), ch340(SECOND, "1-2"))
    assert found(adapter, ch340(FIRST, "1-2"), ch340(SECOND, "1-1")) == SECOND
    for present in ([], [ch340(FIRST, "1-2")]):  # the other one alone never counts
        with pytest.raises(PortNotFound):
            found(adapter, *present)


def test_the_only_one_without_a_number_may_move_to_another_socket():
    adapter = known(ch340(FIRST, "1-1"))
    with pytest.raises(PortNotFound):
        found(adapter)
    moved = ch340(SECOND, "1-2")
    assert found(adapter, moved) == SECOND
    adapter.opened(moved)
    assert found(adapter, ch340(FIRST, "1-2")) == FIRST  # its socket now


def test_one_that_stood_in_another_socket_all_the_time_is_another_cars():
    adapter = known(ch340(FIRST, "1-1"))
    with pytest.raises(AnotherAdapter, match="on /dev/ttyUSB1, but in another USB socket"):
        found(adapter, ch340(SECOND, "1-2"))
    with pytest.raises(PortNotFound):
        found(adapter)
    with pytest.raises(AnotherAdapter):  # still: two of the kind have been seen
        found(adapter, ch340(SECOND, "1-2"))
    assert found(adapter, ch340(SECOND, "1-2"), ch340("/dev/ttyUSB2", "1-1")) == "/dev/ttyUSB2"


def test_a_number_that_two_adapters_have_is_none():
    adapter = known(ftdi(FIRST, "0001", "1-1"), ftdi(SECOND, "0001", "1-2"))
    with pytest.raises(AnotherAdapter):
        found(adapter, ftdi(FIRST, "0001", "1-2"))
    assert found(adapter, ftdi(SECOND, "0001", "1-1"), ftdi(FIRST, "0001", "1-2")) == SECOND


def test_a_number_that_a_later_one_has_too_is_none():
    adapter, ours, other = known(ftdi(FIRST)), ftdi(FIRST), ftdi(SECOND, location="1-2")
    assert found(adapter, ours, other) == FIRST
    with pytest.raises(AnotherAdapter):
        found(adapter, other)


def test_an_earlier_absence_does_not_count():
    adapter, ours = known(ch340(FIRST)), ch340(FIRST)
    with pytest.raises(PortNotFound):
        found(adapter)
    assert found(adapter, ours) == FIRST
    adapter.opened(ours)
    with pytest.raises(AnotherAdapter):
        found(adapter, ch340(SECOND, "1-2"))


def test_the_ports_of_one_adapter_are_told_apart():
    adapter = known(ftdi(FIRST, location="1-1:1.1"), ftdi(SECOND, location="1-1:1.0"))
    swapped = ftdi(FIRST, location="1-1:1.0"), ftdi(SECOND, location="1-1:1.1")
    assert found(adapter, *swapped) == SECOND


def test_ports_that_nothing_tells_apart_keep_their_names():
    one, two = ftdi(SECOND), ftdi(FIRST)
    assert found(known(two, one), one, two) == FIRST


def test_without_a_known_socket_the_name_stands_for_it():
    com5 = ch340("COM5", None)
    adapter = KnownAdapter(com5, [com5, ch340("COM6", None)])
    assert adapter.locate([ch340("COM6", None), com5], "COM5") is com5
    with pytest.raises(AnotherAdapter):
        adapter.locate([ch340("COM6", None)], "COM5")


NAMES = [f"/dev/ttyUSB{number}" for number in range(4)]
SOCKETS = [f"1-{number}" for number in range(4)]
CABLES = ["ours", "numbered", "ch340", "same number"]


@given(
    st.sampled_from(["A1", None]),
    st.lists(st.lists(st.sampled_from(CABLES), unique=True, max_size=4), min_size=1, max_size=8),
    st.randoms(use_true_random=False),
)
def test_no_other_adapter_is_ever_taken_while_ours_was_seen_with_its_like(number, looks, random):
    """Cables come and go at random, under random names; a cable keeps its socket."""

    def plugged(cables: list[str]) -> dict[str, Port]:
        names = random.sample(NAMES, len(cables))
        return {cable: port(cable, name) for cable, name in zip(cables, names, strict=True)}

    def port(cable: str, name: str) -> Port:
        socket = SOCKETS[CABLES.index(cable)]
        if cable == "numbered":
            return ftdi(name, "B2", socket)
        if cable == "ch340" or number is None:
            return ch340(name, socket)
        return ftdi(name, number, socket)

    all_cables = plugged(CABLES)
    adapter = KnownAdapter(all_cables["ours"], list(all_cables.values()))
    adapter.opened(all_cables["ours"])
    address = all_cables["ours"].url
    for cables in looks:
        present = plugged(cables)
        try:
            taken = adapter.locate(list(present.values()), address)
        except PortNotFound:
            assert "ours" not in present
            continue
        assert taken == present["ours"]
        adapter.opened(taken)
        address = taken.url
