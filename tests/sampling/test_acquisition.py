"""All of sampling behind one iterator: derived channels, alarms, other wishes, prices."""

from __future__ import annotations

import threading
from contextlib import closing

import pytest
from sampling_harness import (
    SimulatedPlug,
    assert_values_are_the_units,
    ecu_factory,
    enough,
    of,
    take,
)

from mikas.catalog import AlarmLimits
from mikas.errors import NotSupported, UnknownParameter, UsageError
from mikas.sampling.acquisition import Acquisition
from mikas.sampling.events import (
    AlarmChanged,
    CycleFailed,
    LineState,
    ParameterDropped,
    PlanChanged,
    Sampled,
    StateChanged,
    UnitFound,
)
from mikas.sampling.plan import Plan, select
from mikas.virtual.fault_injector import FaultInjector, LineFault
from mikas.virtual.quirks import EcuQuirks
from mikas.virtual.responder import Identity
from protocol_codes import SECTION_4, with_limits
from virtual_harness import DATA, PASSPORTS, make_bus


def acquisition(plug: SimulatedPlug, *names: str, **settings: object) -> Acquisition:
    settings.setdefault("method", "batch")
    catalog = with_limits(SECTION_4, **settings.pop("limits", {}))
    return Acquisition(plug, ecu_factory(), catalog, names, **settings)


def test_the_plan_is_reported_once_before_the_first_sample():
    made = acquisition(SimulatedPlug(make_bus()), "FREQ", "FUEL_FLOW", "TWAT/10")
    assert [c.name for c in made.channels] == ["FREQ", "FUEL_FLOW", "TWAT"]
    assert (made.plan, made.ecu, made.method) == (None, None, None)
    with closing(made.run()) as events:
        reported = take(events, enough)
        assert of(StateChanged, reported)[-1].state is LineState.SAMPLING
        assert made.ecu.model.text.en
        assert made.ecu.tester.statistics.requests > 40
    (plan,) = of(PlanChanged, reported)
    assert reported.index(plan) < reported.index(of(Sampled, reported)[0])
    assert made.plan is plan.plan
    assert made.method == "batch"
    assert {w.parameter.name: w.divisor for w in plan.plan.parameters} == {
        "FREQ": 1,
        "INJ": 1,
        "TWAT": 10,
    }


@pytest.mark.parametrize("method", ["batch", "list", "stream"])
def test_a_derived_channel_has_a_value_only_where_all_of_it_is_fresh(method):
    made = acquisition(SimulatedPlug(make_bus()), "FREQ", "FUEL_FLOW/5", method=method)
    with closing(made.run()) as events:
        samples = of(Sampled, take(events, enough))
    with_flow = [s for s in samples if "FUEL_FLOW" in s.derived]
    for sample in samples:
        both = {"FREQ", "INJ"} <= set(sample.fresh)
        assert ("FUEL_FLOW" in sample.derived) == both
        if both:
            assert sample.derived["FUEL_FLOW"].time == sample.time
            assert "INJ" in sample.derived["FUEL_FLOW"].inputs["FUEL_STROKE"].inputs
        elif samples.index(sample) > 5:
            assert sample.stale["INJ"].time < sample.time
    assert len(with_flow) == len(samples) if method == "stream" else 7 <= len(with_flow) <= 9


def test_what_is_added_up_goes_on_when_other_channels_are_wanted_but_not_in_another_car():
    plug = SimulatedPlug(make_bus())
    made = acquisition(plug, "FUEL_USED")

    def used(events):
        return of(Sampled, take(events, enough))[-1].derived["FUEL_USED"]

    with closing(made.run()) as events:
        first = used(events)
        made.reconfigure(["FUEL_USED", "TWAT", "FUEL_FLOW"], "batch")
        second = used(events)
        assert second.value > first.value > 0
        assert second.since == first.since
        made.reconfigure(["TWAT"], "batch")
        assert not of(Sampled, take(events, enough))[-1].derived
        made.reconfigure(["FUEL_USED"], "batch")
        third = used(events)
        assert third.value > second.value
        assert (third.since, third.gaps) == (first.since, 1)  # and that is counted
        made.reconfigure(["FREQ"], "batch")
        take(events, enough)
        plug.bus.ecu.responder.car.on = False
        take(events, lambda e: bool(of(StateChanged, e)))
        plug.bus.ecu.responder.identity = Identity(0x09, PASSPORTS)
        plug.bus.ecu.responder.car.on = True
        assert of(UnitFound, take(events, enough))[0].another
        made.reconfigure(["FUEL_USED"], "batch")
        assert used(events).since > third.time


def test_a_gap_is_counted_where_something_is_added_up():
    plug = SimulatedPlug(make_bus())
    with closing(acquisition(plug, "FUEL_USED").run()) as events:
        take(events, enough)
        plug.bus.ecu.responder.car.on = False
        plug.at(plug.now() + 5, lambda: setattr(plug.bus.ecu.responder.car, "on", True))
        reported = take(events, enough)
    assert of(CycleFailed, reported)
    assert of(Sampled, reported)[-1].derived["FUEL_USED"].gaps == 1


@pytest.mark.parametrize("method", ["batch", "stream"])
def test_a_damaged_response_does_not_interrupt_accumulation(method):
    fault_injector = FaultInjector({LineFault.DAMAGED: 0.05}, seed=4)
    made = acquisition(
        SimulatedPlug(make_bus(fault_injector=fault_injector)), "FUEL_USED", method=method
    )
    with closing(made.run()) as events:
        reported = take(events, lambda e: len(of(Sampled, e)) == 600)
    samples = of(Sampled, reported)
    used = samples[-1].derived["FUEL_USED"]
    flow = samples[-1].derived["FUEL_USED"].inputs["FUEL_FLOW"].value
    assert bool(of(CycleFailed, reported)) == (method == "stream")
    assert used.gaps == 0
    assert used.value == pytest.approx(flow * (used.time - used.since) / 3600, rel=1e-6)


def test_values_of_a_cycle_are_fresh_however_long_it_lasts():
    """One request a parameter and a slow unit: the last response is seconds after the first."""
    limits = {"TAIR": AlarmLimits(warning_high=-30), "DUTY": AlarmLimits(warning_high=0.1)}
    made = acquisition(
        SimulatedPlug(make_bus(quirks=EcuQuirks(turn_round=0.3))),
        *(each.name for each in SECTION_4.parameters),
        "DUTY",
        method="single",
        limits=limits,
    )
    with closing(made.run()) as events:
        reported = take(events, lambda e: len(of(AlarmChanged, e)) >= 3, most=30)
    (first, *_) = of(Sampled, reported)
    assert first.fresh["TAIR"].time > first.time + 2
    assert first.derived["DUTY"].value > 0
    assert {alarm.name for alarm in of(AlarmChanged, reported)} >= {"TAIR", "DUTY"}


def test_has_more_while_alarms_follow_a_sample():
    """So that whoever has had enough still gets them, and sends nothing more."""
    plug = SimulatedPlug(make_bus())
    limits = {
        "TWAT": AlarmLimits(warning_high=-30, hysteresis=2),
        "FREQ": AlarmLimits(warning_high=1, hysteresis=0.5),
    }
    made = acquisition(plug, "FREQ", "TWAT", limits=limits)
    assert not made.has_more
    with closing(made.run()) as events:
        take(events, lambda e: bool(of(Sampled, e)))
        asked, behind = plug.bus.bytes_carried, []
        while made.has_more:
            behind.append(next(events))
        assert {alarm.name for alarm in behind} == {"TWAT", "FREQ"}
        assert plug.bus.bytes_carried == asked
        take(events, lambda e: bool(of(Sampled, e)))
        assert not made.has_more


def test_alarms_follow_their_sample():
    plug = SimulatedPlug(make_bus())
    limits = {"TWAT": AlarmLimits(warning_high=100, danger_high=110, hysteresis=2)}
    made = acquisition(plug, "FREQ", "TWAT/3", limits=limits)
    data = plug.bus.ecu.responder.car.data
    with closing(made.run()) as events:
        data[0x1A] = bytes([40 + 90])
        assert not [a for a in of(AlarmChanged, take(events, enough)) if a.name == "TWAT"]
        data[0x1A] = bytes([40 + 112])
        reported = take(events, enough)
        (alarm,) = [a for a in of(AlarmChanged, reported) if a.name == "TWAT"]
        before = reported[reported.index(alarm) - 1]
        assert isinstance(before, Sampled)
        assert before.fresh["TWAT"].value == alarm.value == 112
        assert alarm.time == before.time
        assert alarm.level.value == "danger"
        plug.pull()
        reported = take(events, lambda e: bool(of(StateChanged, e)))
        assert not of(AlarmChanged, reported)  # unknown without a port


class TestWanting:
    def test_another_selection_is_sampled_from_the_next_cycle_on(self):
        plug = SimulatedPlug(make_bus())
        made = acquisition(plug, "FREQ", "TWAT")
        with closing(made.run()) as events:
            take(events, enough)
            made.reconfigure(["INJ", "JAIR/2"], "list", 20.0)
            reported = take(events, enough)
        (plan,) = of(PlanChanged, reported)
        assert reported[0] is plan
        assert (plan.plan.method, made.method) == ("list", "list")
        assert [c.name for c in made.channels] == ["INJ", "JAIR"]
        samples = of(Sampled, reported)
        assert {name for s in samples for name in (*s.fresh, *s.stale)} == {"INJ", "JAIR"}
        took = samples[-1].time - samples[10].time
        assert took / (len(samples) - 11) == pytest.approx(1 / 20, rel=0.05)
        assert_values_are_the_units(reported)

    def test_the_same_selection_again_is_reported(self):
        made = acquisition(SimulatedPlug(make_bus()), "FREQ")
        with closing(made.run()) as events:
            take(events, enough)
            made.reconfigure(["FREQ"], "batch")
            assert of(PlanChanged, take(events, enough))

    def test_a_slow_rate_does_not_hold_it_up(self):
        plug = SimulatedPlug(make_bus())
        made = acquisition(plug, "FREQ", rate=0.01)
        with closing(made.run()) as events:
            take(events, lambda e: bool(of(Sampled, e)))
            plug.at(plug.now() + 5, lambda: made.reconfigure(["INJ"], "batch"))
            take(events, enough)
            assert plug.now() < 15

    @pytest.mark.parametrize(
        ("names", "method", "rate"),
        [
            (["TWTA"], "auto", None),
            (["FREQ/x"], "auto", None),
            (["FREQ"], "fastest", None),
            (["FREQ"], "auto", 0),
            (["FREQ"], "auto", float("nan")),
        ],
    )
    def test_what_makes_no_sense_changes_nothing(self, names, method, rate):
        made = acquisition(SimulatedPlug(make_bus()), "TWAT")
        with closing(made.run()) as events:
            take(events, enough)
            with pytest.raises((UnknownParameter, UsageError)):
                made.reconfigure(names, method, rate)
            reported = take(events, enough)
        assert [c.name for c in made.channels] == ["TWAT"]
        assert not of(PlanChanged, reported)
        with pytest.raises((UnknownParameter, UsageError)):
            acquisition(SimulatedPlug(make_bus()), *names, method=method, rate=rate)

    def test_other_threads_change_the_selection_while_it_runs(self):
        plug = SimulatedPlug(make_bus())
        made = acquisition(plug, "FREQ")
        sets = [["FREQ"], ["INJ", "FUEL_FLOW"], ["TWAT", "FUEL_STROKE/2"], ["THR"]]
        over = threading.Event()

        def change():
            for turn in range(300):
                made.reconfigure(sets[turn % len(sets)], ["batch", "list", "stream"][turn % 3])
                made.price(sets[turn % len(sets)])
            over.set()

        thread = threading.Thread(target=change)
        with closing(made.run()) as events:
            thread.start()
            reported = take(events, lambda e: over.is_set(), most=10**6)
            thread.join()
            reported += take(events, enough)
        assert list(of(Sampled, reported)[-1].fresh) == ["THR"]
        assert not of(CycleFailed, reported)
        assert_values_are_the_units(reported)

    def test_a_refused_parameter_is_requested_again_when_named_again(self):
        plug = SimulatedPlug(make_bus())
        data = plug.bus.ecu.responder.car.data
        del data[0x1A]
        made = acquisition(plug, "FREQ", "TWAT")
        with closing(made.run()) as events:
            assert [d.name for d in of(ParameterDropped, take(events, enough))] == ["TWAT"]
            data[0x1A] = DATA[0x1A]
            made.reconfigure(["FREQ", "TWAT"], "batch")
            reported = take(events, enough)
        assert set(of(Sampled, reported)[-1].fresh) == {"FREQ", "TWAT"}
        assert not of(ParameterDropped, reported)


def test_a_price_is_that_of_the_plan():
    made = acquisition(SimulatedPlug(make_bus()))
    assert (
        made.price(["FREQ"], "stream")
        == Plan(select(SECTION_4, ["FREQ"]).parameters, "stream").price()
    )
    assert made.price(["FUEL_FLOW"], "batch") == made.price(["FREQ", "INJ"], "batch")
    assert made.price([]).rate == pytest.approx(17.8, rel=0.025)  # nothing better is known yet
    with pytest.raises(UnknownParameter):
        made.price(["TWTA"])
    with pytest.raises(UsageError):
        made.price(["FREQ"], "fastest")


def test_relearning_and_stopping_are_passed_on():
    plug = SimulatedPlug(make_bus())
    made = acquisition(plug, "FREQ", method="auto")
    plug.at(8, made.relearn)
    plug.at(20, made.stop)
    reported = list(made.run())
    methods = [e.method for e in reported if type(e).__name__ == "MethodChosen"]
    assert methods == ["stream", "stream"]
    assert plug.now() < 23


def test_calls_are_passed_on():
    made = acquisition(SimulatedPlug(make_bus()), "FREQ")
    asked = made.call(lambda ecu: ecu.read("THR")["THR"].raw)
    with closing(made.run()) as events:
        take(events, enough)
    assert asked.result(0) == DATA[0x20]


def test_a_selection_that_the_unit_lacks_is_an_error():
    with pytest.raises(NotSupported):
        list(acquisition(SimulatedPlug(make_bus()), "0x99").run())


def test_what_is_refused_midway_takes_its_derived_channel_along():
    plug = SimulatedPlug(make_bus())
    made = acquisition(plug, "FREQ", "FUEL_FLOW")
    with closing(made.run()) as events:
        take(events, enough)
        made.call(lambda ecu: plug.bus.ecu.responder.car.data.pop(0x3F))
        reported = take(events, enough)
    assert [d.name for d in of(ParameterDropped, reported)] == ["INJ"]
    assert not of(Sampled, reported)[-1].derived
    assert list(of(Sampled, reported)[-1].fresh) == ["FREQ"]


@pytest.mark.parametrize("method", ["single", "batch", "list", "stream"])
@pytest.mark.parametrize("names", [["UOZ", "FUEL_FLOW/10"], ["UOZ", "FREQ/3", "FUEL_FLOW/10"]])
def test_slow_derived_channels_have_values(method, names):
    made = acquisition(SimulatedPlug(make_bus()), *names, "TWAT/10", method=method)
    with closing(made.run()) as events:
        samples = of(Sampled, take(events, enough))
    assert sum("FUEL_FLOW" in sample.derived for sample in samples) >= len(samples) // 10


def test_a_second_run_reports_its_plan():
    made = acquisition(SimulatedPlug(make_bus()), "FREQ", "TWAT/10")
    for _ in range(2):
        with closing(made.run()) as events:
            reported = take(events, enough)
        assert len(of(PlanChanged, reported)) == 1


def test_other_threads_may_want_ask_and_forget_as_they_like():
    made = acquisition(SimulatedPlug(make_bus()), "FREQ", "TWAT/10", method="auto")
    over = threading.Event()
    asked, failed = [], []
    wishes = [["FREQ"], ["UOZ/3", "FUEL_FLOW/10"], [], ["RXX", "RDET/5"], ["FUEL_USED/7", "FREQ"]]

    def others(turn):
        try:
            while not over.wait(0.0003):
                turn += 1
                match turn % 3:
                    case 0:
                        made.reconfigure(
                            wishes[turn % 5], ["auto", "stream", "list", "batch"][turn % 4]
                        )
                    case 1:
                        asked.append(made.call(lambda ecu: ecu.read("TWAT")))
                    case _ if turn % 31 == 0:
                        made.relearn()
                assert made.price(["FREQ"]).rate > 0
        except Exception as error:  # raised again in the test's own thread
            failed.append(error)

    threads = [threading.Thread(target=others, args=(turn,)) for turn in range(2)]
    for thread in threads:
        thread.start()
    try:
        with closing(made.run()) as events:
            reported = take(events, lambda e: len(of(Sampled, e)) >= 1000, 10_000)
    finally:
        over.set()
        for thread in threads:
            thread.join()
    assert not failed
    assert all(future.done() for future in asked)
    assert_values_are_the_units(reported)
    samples = of(Sampled, reported)
    assert [s.time for s in samples] == sorted(s.time for s in samples)
    fresh = [(name, r.time) for sample in samples for name, r in sample.fresh.items()]
    assert len(fresh) == len(set(fresh))  # none passed off as new
