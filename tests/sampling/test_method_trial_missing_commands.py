"""Units without 71 and 63/64 (D10): found out once, while values go on; the line is not blamed."""

from __future__ import annotations

from contextlib import closing
from itertools import pairwise

import pytest
from sampling_harness import (
    SimulatedPlug,
    assert_values_are_the_units,
    make_sampler,
    of,
    settled,
    take,
)

from mikas.sampling.events import CycleFailed, MethodChosen, ParameterDropped, PlanChanged, Sampled
from mikas.virtual.bus import AdapterKind
from mikas.virtual.quirks import GROUPS, EcuQuirks, Unknown
from virtual_harness import make_bus

MANY = ("FREQ", "FREQX", "TWAT", "UACC", "TAIR", "INJ", "JAIR", "UGB", "VALF", "SSM")
POOR = GROUPS["stream"] | GROUPS["list"]
METHODS = {0x71, 0x63, 0x64}


def poor(unknown: Unknown, *, missing: frozenset[int] = POOR, **others: object):
    return make_bus(quirks=EcuQuirks(missing=missing, unknown=unknown, **others))


def asked_of(bus) -> list[int]:
    """The codes of what is asked from now on."""
    asked: list[int] = []

    def hear(heard) -> None:
        if heard.kind == "request":
            asked.append(heard.data[0])

    bus.ecu.watcher = hear
    return asked


def longest_pause(events) -> float:
    times = [sample.time for sample in of(Sampled, events)]
    return max(after - before for before, after in pairwise(times))


def some(count: int):
    return lambda events: len(of(Sampled, events)) >= count


@pytest.mark.parametrize("unknown", Unknown)
@pytest.mark.parametrize("max_list", [255, 4])
def test_other_lists_cost_nothing_whatever_their_length(unknown, max_list):
    bus = poor(unknown, max_list=max_list)
    sampler = make_sampler(SimulatedPlug(bus), *MANY)
    with closing(sampler.run()) as events:
        take(events, settled)
        asked = asked_of(bus)
        for count in (4, 3, 5, 2, 1, 10):
            sampler.reconfigure(MANY[:count])
            reported = take(events, some(100))
            assert longest_pause(reported) < 0.2
            assert not of(CycleFailed, reported)
            assert_values_are_the_units(reported)
    assert not METHODS.intersection(asked)


@pytest.mark.parametrize("unknown", Unknown)
def test_missing_commands_are_saved_for_every_adapter(unknown, tmp_path):
    with closing(make_sampler(SimulatedPlug(poor(unknown)), *MANY, state=tmp_path).run()) as events:
        take(events, settled)
    bus = make_bus(
        adapter=AdapterKind(latency=0.016), quirks=EcuQuirks(missing=POOR, unknown=unknown)
    )
    asked = asked_of(bus)
    with closing(make_sampler(SimulatedPlug(bus), "TWAT", state=tmp_path).run()) as events:
        (chosen,) = of(MethodChosen, take(events, settled))
    assert chosen.method == "batch"
    assert not METHODS.intersection(asked)


def test_values_come_during_the_trials():
    with closing(make_sampler(SimulatedPlug(poor(Unknown.SILENT)), *MANY).run()) as events:
        reported = take(events, settled)
    stream, set_list = of(CycleFailed, reported)
    between = reported[reported.index(stream) : reported.index(set_list)]
    assert len(of(Sampled, between)) == 2  # before the shortest stream is tried, and after it
    assert longest_pause(reported) < 3


@pytest.mark.parametrize("unknown", Unknown)
@pytest.mark.parametrize("max_list", [255, 4])
def test_a_missing_command_is_no_line_error(unknown, max_list):
    bus = poor(unknown, max_list=max_list)
    del bus.ecu.responder.car.data[0x21]
    sampler = make_sampler(SimulatedPlug(bus), *MANY)
    with closing(sampler.run()) as events:
        reported = take(events, settled)
        assert sampler.ecu.tester.statistics.failed == 0
    assert [each.name for each in of(ParameterDropped, reported)] == ["JAIR"]


def test_a_method_with_a_refused_long_list_is_kept_for_shorter_ones():
    bus = make_bus(quirks=EcuQuirks(max_list=8))
    sampler = make_sampler(SimulatedPlug(bus), *MANY)
    with closing(sampler.run()) as events:
        assert of(MethodChosen, take(events, settled))[-1].method == "batch"
        asked, most = asked_of(bus), sampler.plan.max_list
        assert most >= 4
        sampler.reconfigure(MANY[: most + 1])  # 61 has shown that these are too many
        reported = take(events, some(60))
        assert not METHODS.intersection(asked)
        assert not of(CycleFailed, reported)
        sampler.reconfigure(MANY[:most])
        assert of(MethodChosen, take(events, settled))[-1].method == "stream"


def refusing(bus, code: int) -> None:
    """From now on the unit refuses this parameter, alone, in a list and in the list that is set."""
    responder = bus.ecu.responder
    through = type(responder).answer

    class Picky(type(responder)):
        __slots__ = ()

        def answer(self, body: bytes, now: float):
            named = bytes(d.code for d in self._list) if body == b"\x63" else body[1:]
            if body[0] in (0x61, 0x63, 0x64, 0x71) and code in named:
                return self._unknown()
            return through(self, body, now)

    responder.__class__ = Picky


@pytest.mark.parametrize("missing", ["stream", "stream and list"])
@pytest.mark.parametrize("unknown", Unknown)
class TestOneIsRefusedInTheMiddle:
    def events_with(self, missing: str, unknown: Unknown, tmp_path, asked: list[int]):
        groups = frozenset().union(*(GROUPS[group] for group in missing.split(" and ")))
        bus = poor(unknown, missing=groups)
        plug = SimulatedPlug(bus)
        sampler = make_sampler(plug, "FREQ", "TWAT", "JAIR", "UACC", "TAIR", state=tmp_path)
        with closing(sampler.run()) as events:
            take(events, settled)
            heard = asked_of(bus)
            refusing(bus, 0x21)
            reported = take(events, lambda e: bool(of(ParameterDropped, e)))
            reported += take(events, some(100))
        asked += heard
        return reported

    def test_the_timings_of_methods_stay(self, missing, unknown, tmp_path):
        asked: list[int] = []
        reported = self.events_with(missing, unknown, tmp_path, asked)
        assert [each.name for each in of(ParameterDropped, reported)] == ["JAIR"]
        assert 0x71 not in asked
        assert longest_pause(reported[reported.index(of(ParameterDropped, reported)[0]) :]) < 0.2
        names = [wanted.parameter.name for wanted in of(PlanChanged, reported)[-1].plan.parameters]
        assert names == ["FREQ", "TWAT", "UACC", "TAIR"]
        assert_values_are_the_units(reported)

    def test_the_gap_names_the_refused_parameter(self, missing, unknown, tmp_path):
        (gap,) = of(CycleFailed, self.events_with(missing, unknown, tmp_path, []))
        text = gap.error.reason
        if unknown is Unknown.SILENT:
            assert text.en.startswith("The ECU did not answer")
        elif missing == "stream":
            assert text.en == "This ECU does not know a list (63) of these parameters (5)"
            assert text.ru == "Этот блок не знает списка (63) из этих параметров (5)"
        else:
            assert text.en == "This ECU does not know parameter JAIR (61 21)"
            assert text.ru == "Этот блок не знает параметра JAIR (61 21)"
        assert gap.error.received is not None
