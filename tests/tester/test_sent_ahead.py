"""A request that goes out as soon as the response before it is there: `announce`, `settle`.

Sent by the tester, or by a link that sees the response earlier (`Link.write_after`).
"""

from __future__ import annotations

from contextlib import suppress
from itertools import pairwise

import pytest
import tester_rig
from hypothesis import given
from hypothesis import strategies as st
from tester_rig import (
    DATA,
    SILENT_ADAPTER,
    Fate,
    SelfWriting,
    StrikingLink,
    Watched,
    answering,
    case,
    make,
    read,
    right,
)

from mikas import commands as c
from mikas import tester as package
from mikas.errors import LineError, LinkLost, MikasError, WrongAddress, WrongLength
from mikas.framing import encode
from mikas.link import CaptureTee, Link
from mikas.virtual.fault_injector import LineFault

CODES = sorted(DATA)


@pytest.fixture(params=[Link, SelfWriting], ids=["tester", "link"], scope="module", autouse=True)
def _sender(request):
    """Whatever link these tests give a tester, it may write requests itself."""

    def made(link: Link, **settings: object) -> package.Tester:
        wrapped = link if isinstance(link, SelfWriting) else SelfWriting(link)
        return package.Tester(wrapped, **settings)

    with pytest.MonkeyPatch.context() as patch:
        if request.param is SelfWriting:
            patch.setattr(tester_rig, "Tester", made)
        yield


class Requests:
    """The bodies that the unit has heard since now."""

    def __init__(self, unit: Watched) -> None:
        self._unit = unit
        self._before = len(unit.happenings)

    def __iter__(self):
        heard = self._unit.happenings[self._before :]
        return (it.data for it in heard if it.kind == "request")


def bodies(*codes: int) -> list[bytes]:
    return [read(code).body() for code in codes]


def test_an_announced_request_is_sent_before_the_answer_is_returned():
    unit = Watched()
    tester = unit.connected()
    written = []
    write = unit.link.write

    def watched(data: bytes) -> None:
        written.append(unit.link.now())
        write(data)

    unit.link.write = watched
    tester.announce(read(17))
    _, reply = tester.exchange(read(16))
    assert written[1:] == [reply.ended]
    assert tester.request(read(17)) == (DATA[17],)
    assert len(written) == 2
    assert tester.statistics.requests == 2
    assert tester.statistics.failed == 0


def test_nothing_is_lost_of_the_wires_time():
    """From request to request: the bytes, and the unit's turn-round (§5)."""
    unit = Watched()
    tester = unit.connected()
    times = []
    for _ in range(5):
        tester.announce(read(67))
        times.append(tester.exchange(read(67))[1].ended)
    steps = {round(after - before, 4) for before, after in pairwise(times)}
    assert len(steps) == 1
    tester.settle()
    slow = [tester.exchange(read(67))[1].ended for _ in range(3)]
    assert slow[2] - slow[1] == pytest.approx(steps.pop(), abs=0.001)


def test_another_request_awaits_and_drops_its_response():
    unit = Watched()
    tester = unit.connected()
    heard = Requests(unit)
    for other in (lambda: right(tester, 22), lambda: tester.raw(b"\x01"), tester.settle,
                  lambda: tester.wait(tester.link.now() + 0.1)):  # fmt: skip
        tester.announce(read(17))
        right(tester, 16)
        other()
    right(tester, 16)
    pair = bodies(16, 17)
    assert list(heard) == [*pair, *bodies(22), *pair, b"\x01", *pair, *pair, *bodies(16)]
    assert tester.sync.found_again == 0
    assert tester.statistics.failed == 0


def test_an_announcement_holds_for_one_exchange():
    unit = Watched()
    tester = unit.connected()
    heard = Requests(unit)
    tester.announce(read(17))
    right(tester, 16, 17, 16, 22)
    assert list(heard) == bodies(16, 17, 16, 22)
    tester.announce(read(17))
    tester.settle()
    right(tester, 16)
    assert list(heard) == bodies(16, 17, 16, 22, 16)


def test_a_stream_begins_on_a_line_without_a_pending_response():
    tester = Watched().connected()
    tester.announce(read(17))
    right(tester, 16)
    with tester.stream(c.StreamCyclic((c.Datum(22, 1),))) as stream:
        assert next(stream).data == (DATA[22],)
    right(tester)


def test_nothing_follows_a_change_by_itself():
    """The two writes that erase the faults stay together (§3)."""
    unit = Watched()
    tester = unit.connected()
    heard = Requests(unit)
    tester.announce(read(17))
    tester.request(c.WriteParameter(16, DATA[16]))
    tester.announce(read(17))
    tester.in_a_row(*c.ERASE_FAULTS)
    right(tester, 22)
    writes = [command.body() for command in (c.WriteParameter(16, DATA[16]), *c.ERASE_FAULTS)]
    assert list(heard) == [*writes, *bodies(22)]


def test_without_an_echo_nothing_is_sent_ahead():
    unit = Watched(adapter=SILENT_ADAPTER)
    tester = unit.connected()
    heard = Requests(unit)
    tester.announce(read(17))
    right(tester, 16)
    tester.settle()
    assert list(heard) == bodies(16)


def test_a_response_that_waited_for_long_is_not_used():
    """Its bytes came together, so nothing says when it began."""
    unit = Watched()
    tester = unit.connected()
    heard = Requests(unit)
    tester.announce(read(17))
    right(tester, 16)
    unit.link.gather(unit.link.now() + 0.3)
    _, reply = tester.exchange(read(17))
    assert list(heard) == bodies(16, 17, 17)
    assert reply.ended - reply.began < 0.02


@pytest.mark.parametrize("line_fault", LineFault)
def test_a_fault_of_either_response_is_no_other_value(line_fault):
    for at in range(3):
        unit = Watched()
        tester = unit.connected()
        unit.bus.fault_injector = Fate([(None, 0.0)] * at + [(line_fault, 0.7)])
        with case(at):
            for code in (16, 17, 22, 67):
                tester.announce(read(code + 1 if code + 1 in DATA else 16))
                right(tester, code)
            tester.settle()
            right(tester)


def test_a_response_of_another_length_is_awaited_before_the_line_is_trusted_again():
    link = answering({b"\x61\x10": b"\x0a\x09\xed\x0d", b"\x61\x11": b"\x09\xf7\x0d"})
    tester = make(link, retries=0)
    tester.connect()
    tester.announce(read(17))
    with pytest.raises(WrongLength):
        tester.request(read(16))
    assert tester.request(read(17)) == (b"\x09",)
    assert tester.sync.found_again == 1


def test_an_adapter_that_goes_away_with_it_is_reported_once():
    for at in range(1, 60):
        unit = Watched()
        link = StrikingLink(unit.bus, at, lambda link: link.unplug())
        tester = unit.tester(link)
        with case(at), suppress(LinkLost):
            tester.connect()
            tester.announce(read(17))
            tester.request(read(16))
            tester.settle()
            tester.announce(read(17))
            tester.request(read(16))
            tester.request(read(17))
        tester.settle()
        tester.close()


class Interrupted(StrikingLink):
    """Ctrl-C before its operation number `at`, or, once a request is written, `behind` it."""

    def __init__(self, unit: Watched, at: int, *, behind: bool) -> None:
        super().__init__(unit.bus, at, lambda link: link.interrupt())
        self._behind = behind

    def interrupt(self) -> None:
        if not self._behind:
            raise KeyboardInterrupt

    def write(self, data: bytes) -> None:
        super().write(data)
        if self._behind and self.operations == self.at:
            raise KeyboardInterrupt


@pytest.mark.parametrize("behind", [False, True])
def test_an_interrupt_leaves_no_response_that_passes_for_another(behind):
    """Both data have one byte, so no length shows whose it is."""
    for at in range(1, 60):
        unit = Watched()
        link = Interrupted(unit, at, behind=behind)
        tester = unit.tester(link)
        with case(at):
            with suppress(KeyboardInterrupt):
                tester.connect()
                tester.announce(read(17))
                right(tester, 16)
                tester.settle()
                tester.announce(read(17))
                right(tester, 16, 17)
            link.at = 0
            if tester.version_code is not None:
                right(tester, 22, 16, 17)


@given(
    st.lists(st.tuples(st.sampled_from(CODES), st.sampled_from([None, *CODES])), max_size=12),
    st.lists(st.sampled_from([None, None, None, *LineFault]), max_size=12),
    st.sets(st.integers(0, 12)),
)
def test_whatever_is_announced_each_value_is_that_of_its_own_parameter(turns, faults, settled):
    unit = Watched()
    tester = unit.connected()
    unit.bus.fault_injector = Fate((fault, 0.6) for fault in faults)
    for number, (code, announced) in enumerate(turns):
        if announced is not None:
            tester.announce(read(announced))
        with suppress(LineError, MikasError):
            assert tester.request(read(code)) == (DATA[code],)
        if number in settled:
            tester.settle()
    tester.settle()
    unit.bus.fault_injector = Fate([])
    right(tester)


class Tee(list):
    """A recording of what passed: direction, bytes and time."""

    def record(self, direction, data, time):
        self.append((direction.value, data, time))


def recorded(unit: Watched) -> Tee:
    """Return what is recorded while two requests go out ahead."""
    tester = unit.connected()
    tee = Tee()
    tester.wrap_link(lambda link: CaptureTee(link, tee))
    for code in (16, 17, 67):
        tester.announce(read(code + 1 if code < 67 else 16))
        right(tester, code)
    tester.settle()
    return tee


def test_what_the_link_sends_is_recorded_with_its_time_and_before_its_echo():
    tee = recorded(Watched())
    times = [time for *_, time in tee]
    assert times == sorted(times)
    sent = [data for direction, data, _ in tee if direction == "sent"]
    assert sent == [encode(body) for body in bodies(16, 17, 18, 67, 16)]
    heard = b"".join(data for direction, data, _ in tee if direction == "received")
    for wire in sent:  # each is heard after it was recorded
        at = next(n for n, it in enumerate(tee) if it[:2] == ("sent", wire))
        assert wire in b"".join(data for _, data, _ in tee[at + 1 :])
    assert len(heard) > sum(map(len, sent))


def test_a_link_sends_what_is_announced_and_never_a_change():
    unit = Watched()
    link = SelfWriting(unit.link)
    tester = make(link)
    tester.connect()
    for code in (16, 17):
        tester.announce(read(code + 1))
        right(tester, code)
    assert link.wrote == [encode(body) for body in bodies(17, 18)]
    tester.settle()
    heard = Requests(unit)
    tester.announce(c.WriteParameter(16, DATA[16]))
    right(tester, 17)
    assert list(heard) == bodies(17)


def test_after_a_response_that_the_link_takes_for_the_answer_another_is_dropped():
    """The link has sent before the tester knows that the response is of another address."""
    wrong = encode(b"\x21\x07")
    link = SelfWriting(answering({b"\x11\x20": wrong[:-1] + b"\x0d", b"\x61\x11": encode(b"\x09")}))
    tester = make(link, retries=0)
    tester.connect()
    tester.announce(read(17))
    with pytest.raises(WrongAddress):
        tester.request(c.ReadRamByte(0x20))
    assert link.wrote == [encode(read(17).body())]
    assert tester.request(read(17)) == (b"\x09",)
    assert tester.sync.found_again == 1
