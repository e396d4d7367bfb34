"""Streams: started, read, and ended from any state (D12, D15)."""

from __future__ import annotations

from itertools import pairwise, product

import pytest
from stream_cases import CYCLIC, SEVERAL, STREAMS, each_adapter, each_end, each_stream, expected
from tester_rig import ECHOING, SILENT_ADAPTER, Fate, Watched, adapter_name, case, read, right

from mikas import commands as c
from mikas.errors import MikasError, UsageError
from mikas.virtual.fault_injector import LineFault
from mikas.virtual.quirks import StreamEnd


def at_once(unit, stream):
    pass


def some_later(unit, stream):
    for _ in range(4):
        next(stream)


def mid_response(unit, stream):
    next(stream)
    gap = unit.link.now() + 0.002 + 1.5 * unit.link.byte_time
    if isinstance(stream.command, c.StreamAtStroke):
        gap = unit.car.next_stroke(stream.command.stroke, gap) + 1.5 * unit.link.byte_time
    stream.read(gap)


def after_damage(unit, stream):
    unit.fault_injector.next(
        LineFault.DAMAGED, LineFault.CUT, LineFault.FOREIGN, LineFault.MISSING_BYTE
    )
    for _ in range(3):
        next(stream)


def engine_stalls(unit, stream):
    next(stream)
    unit.car.rpm = 0.0


@each_adapter
@each_end
@pytest.mark.parametrize("state", [at_once, some_later, mid_response, after_damage, engine_stalls])
def test_ended_from_any_state_the_next_value_is_right(end, adapter, state):
    for command in STREAMS:
        with case(command):
            unit = Watched(adapter=adapter, stream_end=end)
            tester = unit.connected()
            with tester.stream(command) as stream:
                state(unit, stream)
                began = unit.link.now()
            assert unit.link.now() - began < 5
            assert unit.count_of("stream") == unit.count_of("stream-end") == 1
            if end is StreamEnd.BREAK:
                assert tester.sync.breaks == 1
            elif end is StreamEnd.BYTE and state is not after_damage:
                assert tester.sync.breaks <= isinstance(command, c.StreamAtStroke)
            right(tester)
            with tester.stream(command) as again:
                if state is not engine_stalls:
                    assert next(again).data == expected(command)
            right(tester)


@each_adapter
@each_stream
def test_every_response_is_an_item(command, adapter):
    unit = Watched(adapter=adapter)
    tester = unit.connected()
    with tester.stream(command) as stream:
        items = [next(stream) for _ in range(12)]
    assert {item.data for item in items} == {expected(command)}
    times = [item.time for item in items]
    assert times == sorted(times)
    if isinstance(command, c.StreamAtStroke) and not adapter.latency:
        gaps = [b - a for a, b in pairwise(times)]
        assert gaps == pytest.approx([120 / 850] * 11, abs=1e-3)  # D15: one an engine cycle
    assert tester.statistics.failed == 0
    right(tester)


@pytest.mark.parametrize("adapter", [ECHOING, SILENT_ADAPTER], ids=adapter_name)
def test_ending_a_cyclic_stream_of_several_bytes_takes_no_time(adapter):
    unit = Watched(adapter=adapter)
    tester = unit.connected()
    for _ in range(3):
        with tester.stream(c.StreamCyclic(SEVERAL)) as stream:
            next(stream)
            began = unit.link.now()
        assert unit.link.now() - began < 0.25
        right(tester)
    assert tester.sync.breaks == 0


@each_end
@each_stream
def test_line_faults_at_the_end_of_a_stream_give_no_wrong_value(command, end):
    for late, position in product((0.3, 0.7), range(3)):
        with case(late, position):
            unit = Watched(stream_end=end)
            tester = unit.connected()
            for fate in (LineFault.LATE, LineFault.LOST, LineFault.DAMAGED, LineFault.DOUBLED):
                try:
                    with tester.stream(command) as stream:
                        next(stream)
                        healthy = [(None, 0.0)] * position
                        unit.bus.fault_injector = Fate([*healthy, (fate, late), (fate, late)])
                    unit.bus.fault_injector = Fate([(LineFault.LOST, 0)])
                    right(tester)
                except MikasError:
                    pass  # reported, and never a wrong value
                unit.bus.fault_injector = Fate([])
                right(tester)


def test_damaged_and_foreign_responses_are_counted_and_left_out():
    unit = Watched()
    tester = unit.connected()
    with tester.stream(c.StreamCyclic(SEVERAL)) as stream:
        next(stream)
        unit.fault_injector.next(None, LineFault.DAMAGED, None, LineFault.FOREIGN)
        for _ in range(8):
            assert next(stream).data == expected(stream.command)
    failures = [failure.code for failure in tester.statistics.failures]
    assert failures == ["DamagedResponse", "WrongLength"]
    right(tester)


def test_an_exception_in_the_loop_ends_it_and_goes_on_up():
    tester = Watched().connected()
    with (  # noqa: PT012  (the error passes through both)
        pytest.raises(ZeroDivisionError),
        tester.stream(CYCLIC[1]) as stream,
    ):
        for _ in stream:
            raise ZeroDivisionError
    right(tester)


def test_a_generator_over_it_that_is_closed_ends_it():
    tester = Watched().connected()

    def values():
        with tester.stream(CYCLIC[1]) as stream:
            for item in stream:
                yield item.data

    generator = values()
    assert next(generator) == expected(CYCLIC[1])
    generator.close()
    right(tester)


def test_closing_twice_is_closing_once_and_it_then_gives_nothing():
    unit = Watched()
    tester = unit.connected()
    stream = tester.stream(CYCLIC[1])
    next(stream)
    assert stream.running
    stream.close()
    assert not stream.running
    carried = unit.bus.bytes_carried
    stream.close()
    assert list(stream) == []
    assert stream.read(unit.link.now() + 9) is None
    assert unit.bus.bytes_carried == carried


def test_closed_while_it_waits_it_just_ends():
    """By another thread, or by a signal's handler."""
    unit = Watched()
    tester = unit.connected()
    stream = tester.stream(CYCLIC[1])
    next(stream)
    read_line = unit.link.read

    def close_first(deadline):
        unit.link.read = read_line
        stream.close()
        return read_line(deadline)

    unit.link.read = close_first
    assert list(stream) == []
    right(tester)


@each_stream
def test_closing_the_tester_ends_the_stream(command):
    unit = Watched()
    tester = unit.connected()
    next(tester.stream(command))
    tester.close()
    assert unit.count_of("stream-end") == 1


def test_this_thread_asks_for_nothing_else_meanwhile():
    tester = Watched().connected()
    with tester.stream(CYCLIC[1]) as stream:
        for use in (
            lambda: tester.request(read(16)),
            lambda: tester.raw(b"\x01"),
            lambda: tester.stream(CYCLIC[0]),
            lambda: tester.wait(9),
            tester.connect,
        ):
            with pytest.raises(UsageError):
                use()
        assert next(stream).data == expected(stream.command)
    right(tester)
