"""What is learnt of a unit's methods: by trying, for each kind of adapter, kept and verified."""

from __future__ import annotations

import json
from contextlib import closing
from dataclasses import replace
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st
from sampling_harness import (
    SimulatedPlug,
    assert_values_are_the_units,
    ecu_factory,
    enough,
    make_sampler,
    of,
    settled,
    take,
)

from mikas.client.limits import LimitsStore, MethodTiming
from mikas.client.parameters.polling import STREAMS
from mikas.link.virtual import VirtualLink
from mikas.sampling.events import MethodChosen, Sampled
from mikas.sampling.jobs import JobQueue
from mikas.sampling.plan import Plan, PlannedParameter, select
from mikas.sampling.running.context import SamplingContext, SamplingRequest
from mikas.sampling.running.method_knowledge import (
    CANDIDATES,
    TrialResult,
    best_method,
    kind_of_adapter,
    rates_of,
    timing_of,
)
from mikas.sampling.running.method_trial import run_trial
from mikas.virtual.bus import AdapterKind, Bus
from mikas.virtual.fault_injector import FaultInjector, LineFault
from mikas.virtual.quirks import GROUPS, EcuQuirks, Unknown
from protocol_codes import SECTION_4
from virtual_harness import IDENTITY, make_bus

LUMPS = AdapterKind(latency=0.016)
ALL = tuple(map(PlannedParameter, SECTION_4.parameters))


def session(bus: Bus, *words: str, until=None, **settings: object):
    """The events of one session, from a new program's start."""
    until = until or (lambda e: len(of(Sampled, e)) >= 120)
    with closing(make_sampler(SimulatedPlug(bus), *words, **settings).run()) as events:
        return take(events, until)


def kept(folder):
    (file,) = folder.glob("*.json")
    return json.loads(file.read_text("utf-8"))


@pytest.fixture(scope="module")
def learnt(tmp_path_factory):
    """The state folder after a session that has learnt; not to be changed."""
    folder = tmp_path_factory.mktemp("learnt")
    session(make_bus(), state=folder, until=settled)
    return folder


class TestKept:
    def test_the_next_session_begins_with_the_best_at_once(self, tmp_path):
        first = session(make_bus(), state=tmp_path, until=settled)
        then = session(make_bus(), state=tmp_path)
        _, second, *_ = of(Sampled, then)  # the first came before the unit was identified
        assert isinstance(then[then.index(second) - 2], MethodChosen)
        assert [c.method for c in of(MethodChosen, then)] == ["stream"]
        rates = of(MethodChosen, then)[0].rates
        assert rates == pytest.approx(dict(of(MethodChosen, first)[0].rates), rel=0.01)

    def test_measured_methods_show_in_info(self, tmp_path):
        session(make_bus(), state=tmp_path, until=settled)
        ecu = ecu_factory(tmp_path)(VirtualLink(make_bus()))
        ecu.tester.connect()
        (paces,) = ecu.info().limits.methods.values()
        assert list(paces) == ["stream", "list", "batch"]
        assert all(pace.delay is not None and pace.delay < 0.01 for pace in paces.values())
        assert ecu.info().limits.learnt

    def test_a_refused_method_is_not_tried_again(self, tmp_path):
        lacking = EcuQuirks(missing=GROUPS["stream"])
        session(make_bus(quirks=lacking), state=tmp_path, until=settled)
        bus = make_bus(quirks=lacking)
        heard = []
        bus.ecu.watcher = heard.append
        reported = session(bus, state=tmp_path)
        assert [c.method for c in of(MethodChosen, reported)] == ["list"]
        assert of(MethodChosen, reported)[0].rates["stream"] == 0
        assert not [h for h in heard if h.kind == "request" and h.data[0] == 0x71]

    def test_a_refused_method_is_tried_with_a_shorter_list(self, tmp_path):
        short = EcuQuirks(max_list=8)
        session(make_bus(quirks=short), state=tmp_path, until=settled)
        reported = session(make_bus(quirks=short), "FREQ", "INJ", state=tmp_path, until=settled)
        assert of(MethodChosen, reported)[-1].method == "stream"

    def test_another_plan_is_known_without_measuring(self, tmp_path):
        session(make_bus(), state=tmp_path, until=settled)
        # What is wanted seldom is better asked for than streamed all the time.
        slow = ["UACC/20", "TWAT/20", "TAIR/20", "INJ/20", "JAIR/20", "UGB/20", "VALF/20", "SSM/20"]
        reported = session(make_bus(), "FREQ", *slow, state=tmp_path)
        assert [c.method for c in of(MethodChosen, reported)] == ["batch"]
        assert reported.index(of(MethodChosen, reported)[0]) < reported.index(
            of(Sampled, reported)[1]
        )

    def test_relearn_measures_again_and_reports_the_method(self, tmp_path):
        plug = SimulatedPlug(make_bus())
        sampler = make_sampler(plug, state=tmp_path)
        with closing(sampler.run()) as events:
            take(events, settled)
            before = kept(tmp_path)
            plug.bus.ecu.responder.quirks = EcuQuirks(
                missing=GROUPS["stream"], unknown=Unknown.ERROR
            )
            sampler.relearn()
            reported = take(events, settled)
        assert of(MethodChosen, reported)[0].method == "list"
        assert kept(tmp_path)["methods"] != before["methods"]

    def test_forgetting_leaves_other_units_alone(self, tmp_path):
        store = LimitsStore(tmp_path)
        session(make_bus(), state=tmp_path, until=settled)
        store.forget(0x0A, ("ANOTHER", *IDENTITY.passports[1:]))
        assert not store.empty
        store.forget(0x0A, IDENTITY.passports)
        assert store.empty
        store.forget(0x0A, IDENTITY.passports)

    @pytest.mark.parametrize(
        "methods",
        [
            "null",
            "[]",
            '{"adapter": 5}',
            '{"adapter": {"stream": 5}}',
            '{"adapter": {"stream": {"codes": 1}}}',
            '{"adapter": {"stream": {"codes": 1, "delay": "fast"}}}',
            '{"adapter": {"stream": {"codes": 1, "delay": -1}}}',
            '{"adapter": {"stream": {"codes": 1, "delay": NaN}}}',
            '{"adapter": {"stream": {"codes": null, "delay": 1}}}',
        ],
    )
    def test_a_corrupt_file_is_nothing_learnt(self, tmp_path, learnt, methods):
        stored = kept(learnt) | {"methods": json.loads(methods)}
        (file,) = learnt.glob("*.json")
        (tmp_path / file.name).write_text(json.dumps(stored), "utf-8")
        assert LimitsStore(tmp_path).load(0x0A, IDENTITY.passports).methods == {}
        reported = session(make_bus(), state=tmp_path, until=settled)
        assert of(MethodChosen, reported)[0].method == "stream"
        assert len(kept(tmp_path)["methods"]) == 1

    def test_a_file_without_methods_is_valid(self, tmp_path):
        session(make_bus(), state=tmp_path, until=settled)
        (file,) = tmp_path.glob("*.json")
        stored = kept(tmp_path) | {"max_list": 5}
        del stored["methods"]
        file.write_text(json.dumps(stored), "utf-8")
        assert LimitsStore(tmp_path).load(0x0A, IDENTITY.passports).max_list == 5

    def test_a_folder_that_cannot_be_written_costs_nothing_else(self, tmp_path):
        (tmp_path / "file").write_text("")
        assert_values_are_the_units(session(make_bus(), state=tmp_path / "file", until=settled))


class TestAdapters:
    def test_an_adapter_with_latency_is_measured_not_assumed(self):
        (plain,) = of(MethodChosen, session(make_bus(), until=settled))
        (chosen,) = of(MethodChosen, session(make_bus(adapter=LUMPS), until=settled))
        assert chosen.method == max(chosen.rates, key=lambda name: chosen.rates[name])
        assert chosen.rates["list"] < 0.9 * plain.rates["list"]  # its lumps cost what they cost
        assert chosen.rates["stream"] > 0.97 * plain.rates["stream"]

    def test_an_adapter_inherits_no_measurement_from_another(self, tmp_path):
        (plain,) = of(MethodChosen, session(make_bus(), state=tmp_path, until=settled))
        (reported,) = of(
            MethodChosen, session(make_bus(adapter=LUMPS), state=tmp_path, until=settled)
        )
        assert reported.rates["list"] < 0.9 * plain.rates["list"]
        assert len(kept(tmp_path)["methods"]) == 2
        back = session(make_bus(), state=tmp_path)
        assert of(MethodChosen, back)[0].rates == pytest.approx(dict(plain.rates), rel=0.01)

    def test_each_adapter_keeps_its_own_choice(self, tmp_path):
        """What is worth streaming by one is not by the other."""
        words = ["FREQ", "INJ", "JAIR/3", "TWAT/20", "TAIR/20", "UACC/20"]
        by = {}
        for adapter in (AdapterKind(), LUMPS):
            reported = session(make_bus(adapter=adapter), *words, state=tmp_path, until=settled)
            (chosen,) = of(MethodChosen, reported)
            assert chosen.method == max(chosen.rates, key=lambda name: chosen.rates[name])
            by[adapter.latency] = chosen.rates
        assert by[0.016]["list"] < 0.7 * by[0.0]["list"]

    def test_a_rate_estimate_that_is_not_reached_is_measured_again(self, tmp_path):
        """An adapter that looks like the other one, but is slower."""
        session(make_bus(), state=tmp_path, until=settled)
        (file,) = tmp_path.glob("*.json")
        stored = kept(tmp_path)
        (paces,) = stored["methods"].values()
        paces["list"]["delay"], paces["stream"]["delay"] = -0.0, 0.05
        file.write_text(json.dumps(stored), "utf-8")
        paces_before = LimitsStore(tmp_path).load(0x0A, IDENTITY.passports).methods
        bus = make_bus(quirks=EcuQuirks(turn_round=0.0028, stream_gap=0.0004))
        reported = session(bus, state=tmp_path, until=lambda e: len(of(Sampled, e)) > 300)
        assert [c.method for c in of(MethodChosen, reported)] in (["list"], ["list", "stream"])
        assert paces_before
        bus = make_bus(quirks=EcuQuirks(turn_round=0.0027))
        paces["list"]["delay"], paces["stream"]["delay"] = 0.002, 0.0
        file.write_text(json.dumps(stored), "utf-8")
        slow = make_bus(quirks=EcuQuirks(stream_gap=0.03))
        reported = session(slow, state=tmp_path, until=lambda e: len(of(Sampled, e)) > 300)
        assert [c.method for c in of(MethodChosen, reported)] == ["stream", "list"]

    def test_the_kind_is_found_by_response_times(self):
        def kind(**settings):
            bus = make_bus(**settings)
            ecu = ecu_factory()(VirtualLink(bus))
            ecu.tester.connect()
            return kind_of_adapter(ecu)

        assert kind() == "virtual ECU, 2 ms"
        assert kind(adapter=AdapterKind(latency=0.001)) == "virtual ECU, 2 ms"
        assert kind(adapter=LUMPS) == "virtual ECU, 8 ms"

    def test_the_number_of_saved_kinds_is_limited(self, tmp_path):
        bus = make_bus()
        ecu = ecu_factory(tmp_path)(VirtualLink(bus))
        ecu.tester.connect()
        for number in range(20):
            ecu.keep_timings(f"adapter {number}", {"batch": MethodTiming(21, 0.002)})
        assert list(ecu.limits().methods) == [f"adapter {n}" for n in range(12, 20)]


def test_on_a_bad_line_a_method_is_chosen_and_no_value_is_wrong():
    rates = {LineFault.LOST: 0.03, LineFault.DAMAGED: 0.15, LineFault.LATE: 0.02}
    for seed in range(3):
        bus = make_bus(fault_injector=FaultInjector(rates, seed=seed))
        reported = session(bus, until=settled)
        assert of(MethodChosen, reported)
        assert_values_are_the_units(reported)


def test_a_line_that_is_dead_for_a_while_makes_nothing_refused(tmp_path):
    plug = SimulatedPlug(make_bus())
    with closing(make_sampler(plug, state=tmp_path).run()) as events:
        take(events, settled)
        plug.bus.fault_injector.rates = {LineFault.DAMAGED: 1.0}
        plug.at(plug.now() + 30, lambda: setattr(plug.bus.fault_injector, "rates", {}))
        reported = take(events, lambda e: plug.now() > 60 and enough(e))
    assert_values_are_the_units(reported)
    assert len(of(Sampled, reported)[-1].fresh) == 23
    (paces,) = kept(tmp_path)["methods"].values()
    assert all(pace["delay"] is not None for pace in paces.values())


@pytest.mark.parametrize("method", CANDIDATES)
def test_one_lost_response_does_not_change_the_rate(method):
    def measured(*line_faults):
        bus = make_bus()
        ecu = ecu_factory()(VirtualLink(bus))
        ecu.tester.connect()
        ecu.read()
        request = SamplingRequest(select(SECTION_4, []))
        context = SamplingContext(request, JobQueue("sim:"), strict=False)
        found = run_trial(context, ecu, Plan(ALL, method))
        for _ in range(4):
            next(found)
        bus.fault_injector.next(*line_faults)
        *_, result = found
        return result.rate

    assert measured(LineFault.LOST) == pytest.approx(measured(), rel=0.05)


class TestEnough:
    """A rate that every method gives is got by the one that does least to the unit."""

    def test_a_slow_rate_needs_no_stream(self):
        reported = session(make_bus(), rate=2.0, until=lambda e: len(of(Sampled, e)) >= 30)
        assert [c.method for c in of(MethodChosen, reported)] == ["batch"]
        times = [s.time for s in of(Sampled, reported)]
        assert min(later - before for before, later in pairwise(times)) > 0.4

    def test_a_fast_rate_needs_a_stream(self):
        reported = session(make_bus(), rate=26.0, until=lambda e: len(of(Sampled, e)) >= 160)
        assert [c.method for c in of(MethodChosen, reported)] == ["stream"]
        samples = of(Sampled, reported[reported.index(of(MethodChosen, reported)[0]) :])[-50:]
        took = samples[-1].time - samples[0].time
        assert took / 49 == pytest.approx(1 / 26, rel=0.02)


@pytest.mark.parametrize("method", CANDIDATES)
@given(st.floats(0.0, 0.05), st.integers(1, 21))
def test_a_measured_timing_gives_the_rate_of_its_plan(method, delay, count):
    plan = Plan(ALL[:count], method)
    price = plan.price(turn_round=delay, pause=delay)
    pace = timing_of(TrialResult(method, price.rate), plan, 9600)
    assert pace is not None
    assert rates_of(plan, {method: pace}, 9600)[method] == pytest.approx(price.rate)
    assert pace.delay == pytest.approx(delay, abs=1e-9)


@given(st.dictionaries(st.sampled_from(CANDIDATES), st.floats(0, 200)), st.floats(0.1, 100))
def test_the_best_is_never_one_that_does_not_work_nor_slower_than_it_needs_to_be(rates, enough):
    fastest = best_method(rates)
    if fastest is None:
        assert not any(rates.values())
    else:
        assert rates[fastest] == max(rates.values()) > 0
    found = best_method(rates, enough)
    assert (found is None) == (fastest is None)
    if found is not None and rates[found] < max(rates.values()):
        assert rates[found] > enough
        assert found not in STREAMS or max(rates.values()) > enough


def test_prices_use_the_measured_delay():
    sampler = make_sampler(SimulatedPlug(make_bus(adapter=LUMPS)))
    assumed = sampler.price([], "batch")
    assert sampler.price([]).seconds == assumed.seconds  # nothing is known yet
    with closing(sampler.run()) as events:
        take(events, settled)
        measured = sampler.price([], "batch")
        assert measured.seconds > assumed.seconds + 0.003
        assert sampler.price([]).rate > measured.rate  # by stream
        assert replace(measured, seconds=0) == replace(assumed, seconds=0)
