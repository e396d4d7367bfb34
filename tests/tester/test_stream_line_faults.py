"""Streams that are refused, fall silent, are cut off or damaged: reported, and ended."""

from __future__ import annotations

from contextlib import suppress
from random import Random

import pytest
from stream_cases import (
    BY_STROKES,
    CYCLIC,
    ONE,
    SEVERAL,
    each_adapter,
    each_end,
    each_stream,
    expected,
)
from tester_rig import (
    ECHOING,
    ONE_BYTE,
    SILENT_ADAPTER,
    SLOW,
    SLOW_AND_SILENT,
    VERSION,
    BreaklessLink,
    ScriptedLink,
    Watched,
    make,
    read,
    right,
)

from mikas import commands as c
from mikas.errors import (
    DamagedResponse,
    EchoOnly,
    LineError,
    LineNotQuiet,
    LinkLost,
    MikasError,
    NoConnection,
    NoResponse,
    NotSupported,
    WriteRefused,
    WrongLength,
)
from mikas.framing import encode
from mikas.tester import Statistics
from mikas.virtual.fault_injector import FaultInjector, LineFault
from mikas.virtual.quirks import StreamEnd, Unknown


@each_adapter
@pytest.mark.parametrize("code", [0x71, 0x7F])
@pytest.mark.parametrize("data", [ONE, SEVERAL, (c.Datum(19, 1),)])
def test_a_refused_stream_is_not_supported(code, data, adapter):
    command = c.StreamCyclic(data) if code == 0x71 else c.StreamAtStroke(data, 0)
    unit = Watched(adapter=adapter, missing=frozenset({code}), unknown=Unknown.ERROR)
    tester = unit.connected()
    with pytest.raises(NotSupported) as caught, tester.stream(command) as stream:
        next(stream)
    assert caught.value.request == encode(command.body())
    assert caught.value.received == b"\x01"
    right(tester)


@each_adapter
@pytest.mark.parametrize("code", [0x71, 0x7F])
def test_silence_to_a_stream_is_no_response(code, adapter):
    command = c.StreamCyclic(SEVERAL) if code == 0x71 else c.StreamAtStroke(SEVERAL, 0)
    unit = Watched(adapter=adapter, missing=frozenset({code}))
    tester = unit.connected()
    began = unit.link.now()
    with pytest.raises(NoResponse) as caught, tester.stream(command) as stream:
        next(stream)
    assert caught.value.request == encode(command.body())
    assert caught.value.fields["seconds"] == stream.silence == (0.5 if code == 0x71 else 2.0)
    assert caught.value.time == pytest.approx(began + stream.silence, abs=0.03)
    assert unit.link.now() - began < 9
    right(tester)


@pytest.mark.parametrize(
    ("parameters", "sent", "given"),
    [
        (ONE, [b"\x01", b"\x02", b"\x03"], [b"\x01", b"\x02", b"\x03"]),
        (SEVERAL, [b"abcd", b"\x01", b"efgh"], [b"abcd", b"efgh"]),
    ],
)
def test_only_the_one_response_01_is_a_refusal(parameters, sent, given):
    """A datum may be 01, and a response of another length is another request's (D10, D13)."""
    command = c.StreamCyclic(parameters)

    def answer(wire: bytes) -> list[tuple[float, bytes]]:
        if wire != encode(command.body()):
            return [(0.005, encode(bytes([VERSION])))]
        return [(0.02 * number, encode(body)) for number, body in enumerate(sent, 1)]

    tester = make(ScriptedLink(answer))
    tester.connect()
    with tester.stream(command) as stream:
        assert [next(stream).body for _ in given] == given
    failures = [failure.code for failure in tester.statistics.failures]
    assert failures == ["WrongLength"] * (len(sent) - len(given))


@each_end
@pytest.mark.parametrize("command", BY_STROKES, ids=lambda s: s.body().hex())
def test_with_the_engine_standing_nothing_comes_until_it_turns(command, end):
    unit = Watched(rpm=0.0, stream_end=end)
    tester = unit.connected()
    with tester.stream(command) as stream:
        assert stream.read(unit.link.now() + 4) is None
        unit.car.rpm = 850.0
        assert next(stream).data == expected(command)
        unit.car.rpm = 0.0
        stream.read(unit.link.now() + 0.3)  # one was due already
        began = stream._heard  # noqa: SLF001
        with pytest.raises(NoResponse):
            next(stream)
        assert unit.link.now() - began == pytest.approx(2, abs=0.1)
    unit.car.rpm = 850.0
    right(tester)
    assert unit.count_of("stream-end") == 1


@each_stream
@each_end
def test_a_car_that_goes_off_during_a_stream_is_an_error(command, end):
    unit = Watched(stream_end=end)
    tester = unit.connected()
    with (  # noqa: PT012  (the error passes through both)
        pytest.raises((NoResponse, NoConnection)),
        tester.stream(command) as stream,
    ):
        next(stream)
        unit.car.on = False
        for _ in stream:
            pass
    with pytest.raises(EchoOnly):
        tester.request(read(16))
    unit.car.on = True
    right(tester)


@pytest.mark.parametrize(
    ("inside", "outside"),
    [(None, LineNotQuiet), (ZeroDivisionError(), LineNotQuiet), (WriteRefused(), WriteRefused)],
)
def test_a_stream_that_can_not_be_ended_is_reported_unless_the_product_failed_before(
    inside, outside
):
    unit = Watched(stream_end=StreamEnd.BREAK)
    tester = unit.connected(BreaklessLink(unit.bus))
    with pytest.raises(outside), tester.stream(CYCLIC[1]) as stream:  # noqa: PT012
        next(stream)
        if inside:
            raise inside


@pytest.mark.parametrize("inside", [None, ZeroDivisionError()])
def test_a_unit_gone_at_the_end_is_reported_unless_another_error_came_first(inside):
    unit = Watched()
    tester = unit.connected()
    outside = type(inside) if inside else EchoOnly
    with pytest.raises(outside), tester.stream(CYCLIC[1]) as stream:  # noqa: PT012
        next(stream)
        unit.car.on = False
        if inside:
            raise inside


@each_stream
def test_an_adapter_pulled_out_during_a_stream_is_a_lost_link(command):
    unit = Watched()
    tester = unit.connected()
    with (  # noqa: PT012  (the error passes through both)
        pytest.raises(LinkLost),
        tester.stream(command) as stream,
    ):
        next(stream)
        unit.link.unplug()
        next(stream)
    with pytest.raises(LinkLost):
        tester.request(read(16))
    tester.close()


@each_stream
def test_without_a_break_a_deaf_unit_is_reported(command):
    unit = Watched(stream_end=StreamEnd.BREAK)
    tester = unit.connected(BreaklessLink(unit.bus))
    with pytest.raises(LineNotQuiet), tester.stream(command) as stream:
        next(stream)
    assert tester.sync.breaks
    with pytest.raises(LineNotQuiet):
        tester.request(read(16))
    assert tester.link.now() < 40


@each_end
def test_a_request_lost_on_the_way_in_does_not_leave_it_running(end):
    """The stream's own request comes back damaged: the unit may or may not stream."""
    unit = Watched(stream_end=end)
    tester = unit.connected()
    for command in CYCLIC + BY_STROKES:
        unit.fault_injector.spoils_next_echo = True
        with pytest.raises(MikasError):
            tester.stream(command)
        right(tester)
    assert unit.count_of("stream-end") == unit.count_of("stream") == len(CYCLIC + BY_STROKES)


class HeavyWeather(FaultInjector):
    """Half of all responses have a line fault; each late one has another delay."""

    def __init__(self, random: Random) -> None:
        super().__init__(seed=random.randrange(1000))
        self.random = random

    def respond(self, wire):
        self.late_by = self.random.uniform(0.05, 0.95)
        self.next(self.random.choice([*LineFault, *[None] * len(LineFault)]))
        return super().respond(wire)


@pytest.mark.parametrize("seed", [3, 4, 7, 13, 19, 27, 30, 36])
def test_reads_and_streams_by_turns_are_never_wrong_in_heavy_weather(seed):
    random = Random(seed)
    unit = Watched(
        adapter=random.choice([ECHOING, SLOW, SILENT_ADAPTER, SLOW_AND_SILENT]),
        stream_end=random.choice(list(StreamEnd)),
        rpm=random.choice([300.0, 850.0, 5200.0]),
    )
    tester = unit.connected(retries=random.randrange(3))
    unit.bus.fault_injector = HeavyWeather(random)
    for _ in range(25):
        with suppress(MikasError):
            if random.random() < 0.1:
                tester.raw(bytes([random.choice([0x71, 0x7F, 0x82]), 16]))
            elif random.random() < 0.3:
                with tester.stream(random.choice(CYCLIC + BY_STROKES)) as stream:
                    for _ in range(random.randrange(4)):
                        next(stream)
            right(tester, random.choice(sorted(ONE_BYTE)))


def test_raise_errors_raises_for_each_response_left_out():
    unit = Watched()
    tester = unit.connected()
    with tester.stream(c.StreamCyclic(SEVERAL)) as stream:
        next(stream)
        unit.fault_injector.next(None, LineFault.DAMAGED, None, LineFault.FOREIGN)
        reported, began = [], unit.link.now()
        for _ in range(8):
            try:
                assert stream.read(unit.link.now() + 1, raise_errors=True).data == expected(
                    stream.command
                )
            except LineError as error:
                reported.append(error)
        assert next(stream).data == expected(stream.command)
    assert [type(error) for error in reported] == [DamagedResponse, WrongLength]
    assert all(error.request == encode(stream.command.body()) for error in reported)
    assert began < reported[0].time < reported[1].time < unit.link.now()
    counted = Statistics()
    for error in reported:
        counted.fail(error)
    assert tester.statistics.failures == counted.failures
    assert tester.statistics.failed == 2
