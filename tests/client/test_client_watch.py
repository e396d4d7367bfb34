"""`watch`: every method, its pace, its gaps and its end; never a value twice, never a spin."""

from __future__ import annotations

from itertools import islice, pairwise

import pytest
from client_harness import ASKED, STROKES, bench, ecu_on

from mikas.client.parameters.polling import FIXED_METHODS as METHODS
from mikas.errors import EchoOnly, LinkLost, UnknownParameter, UsageError
from mikas.virtual.fault_injector import LineFault
from virtual_harness import DATA, TableCar


class CountingCar(TableCar):
    """Every datum is one more than the one before, so that a repeated one shows."""

    def __init__(self):
        super().__init__(DATA, rpm=850.0)
        self.count = 0

    def raw(self, code, now):
        self.count += 1
        return (self.count % 65536).to_bytes(2, "little")[: len(self.data[code])]


@pytest.mark.parametrize("method", METHODS)
class TestEveryMethod:
    def test_watch_gives_the_requested_parameters(self, method):
        it = bench()
        ecu = ecu_on(it)
        samples = list(ecu.watch("TWAT", "INJ", "RXX", method=method, count=4))
        assert [list(s.readings) for s in samples] == [["TWAT", "INJ", "RXX"]] * 4
        assert all(r.raw == DATA[r.parameter.code] for s in samples for r in s.readings.values())
        assert not any(s.gap for s in samples)
        times = [s.time for s in samples]
        assert times == sorted(set(times))
        assert ecu.read("TWAT")  # and the unit is free

    def test_watch_gives_all_of_the_catalog_with_no_names(self, method):
        (sample,) = ecu_on(bench()).watch(method=method, count=1)
        assert {r.parameter.code: r.raw for r in sample.readings.values()} == DATA

    def test_watch_never_gives_a_value_twice(self, method):
        it = bench(car=CountingCar())
        ecu = ecu_on(it)
        observed = []
        for n, sample in enumerate(ecu.watch("INJ", "JAIR", method=method, count=60)):
            if n % 7 == 3:
                it.next_faults(LineFault.DAMAGED)
            if n % 11 == 5 and method in ASKED:  # a stream's responses come without a request
                it.next_faults(LineFault.DOUBLED)
            if n % 13 == 6:
                it.next_faults(LineFault.LATE)
            observed += [r.raw for r in sample.readings.values()]
        assert len(observed) > 80
        assert len(set(observed)) == len(observed)

    def test_watch_goes_on_after_the_supply_was_off(self, method):
        it = bench()
        ecu = ecu_on(it)
        states = []
        for sample in ecu.watch("TWAT", "INJ", method=method, count=12):
            states.append("gap" if sample.gap else "data")
            assert bool(sample.readings) is not sample.gap
            assert (sample.error is None) is not sample.gap
            if len(states) == 3:
                it.car.on = False
            if len(states) == 6:
                it.car.on = True
        assert states[:3] == ["data"] * 3
        assert states[3:6].count("gap") >= 2
        assert states[-3:] == ["data"] * 3
        assert ecu.read("TWAT")

    def test_a_gap_says_why(self, method):
        it = bench()
        ecu = ecu_on(it)
        reasons = []
        for n, sample in enumerate(ecu.watch("TWAT", method=method, count=4)):
            it.car.on = False
            if n:
                reasons.append(type(sample.error))
        assert EchoOnly in reasons

    def test_every_cycle_takes_time_whatever_happens(self, method):
        it = bench()
        ecu = ecu_on(it)
        ecu.read("TWAT")
        it.car.on = False
        times = [s.time for s in ecu.watch("TWAT", method=method, count=5)]
        assert all(later > earlier for earlier, later in pairwise(times))

    def test_the_adapter_pulled_out_ends_it(self, method):
        it = bench()
        ecu = ecu_on(it)
        samples = ecu.watch("TWAT", method=method)
        next(samples)
        it.link.unplug()
        with pytest.raises(LinkLost):
            list(islice(samples, 3))

    def test_closing_it_frees_the_unit(self, method):
        it = bench()
        ecu = ecu_on(it)
        samples = ecu.watch("TWAT", method=method)
        next(samples)
        next(samples)
        samples.close()
        assert ecu.read("FREQ")
        assert ecu.tester.link.now() < 4

    def test_with_a_count_it_is_over_with_the_last(self, method):
        ecu = ecu_on(bench())
        samples = ecu.watch("TWAT", method=method, count=2)
        next(samples)
        next(samples)
        assert ecu.read("FREQ")  # without a third request
        assert list(samples) == []

    def test_no_count_at_all_sends_nothing(self, method):
        it = bench()
        ecu = ecu_on(it)
        assert list(ecu.watch("TWAT", method=method, count=0)) == []
        assert it.requests() == []

    def test_nothing_is_sent_before_the_first_is_wanted(self, method):
        it = bench()
        ecu_on(it).watch("TWAT", method=method)
        assert it.requests() == []

    def test_a_rate_is_kept(self, method):
        ecu = ecu_on(bench(rpm=3000))
        times = [s.time for s in ecu.watch("TWAT", method=method, rate=5, count=51)]
        assert (times[-1] - times[0]) / 50 == pytest.approx(0.2, rel=0.02)
        steps = [later - earlier for earlier, later in pairwise(times)]
        assert max(steps) < 0.26

    def test_a_missed_beat_is_not_caught_up(self, method):
        it = bench(rpm=3000)
        ecu = ecu_on(it)
        samples = ecu.watch("TWAT", method=method, rate=10)
        next(samples)
        it.car.on = False
        next(samples)
        while next(samples).gap:
            it.car.on = True
        times = [next(samples).time for _ in range(10)]
        steps = [later - earlier for earlier, later in pairwise(times)]
        assert min(steps[1:]) > 0.07  # it goes on from now, at once
        samples.close()

    def test_a_misspelt_name_is_an_error_at_once(self, method):
        it = bench()
        with pytest.raises(UnknownParameter):
            ecu_on(it).watch("TWATT", method=method)
        assert it.requests() == []


@pytest.mark.parametrize(
    "settings",
    [
        {"rate": 0},
        {"rate": -1},
        {"rate": float("nan")},
        {"rate": float("inf")},
        {"count": -1},
        {"method": "fastest"},
        {"method": "stroke5"},
        {"method": ""},
    ],
)
def test_bad_settings_are_an_error_at_once(settings):
    it = bench()
    with pytest.raises(UsageError):
        ecu_on(it).watch("TWAT", **settings)
    assert it.requests() == []


def test_auto_is_the_sessions_choice_and_is_refused_with_what_to_use():
    it = bench()
    with pytest.raises(UsageError, match=r"mikas\.session.*batch"):
        ecu_on(it).watch("TWAT", method="auto")
    assert it.requests() == []


def test_each_method_sends_its_own_requests():
    def heard(method):
        it = bench()
        list(ecu_on(it).watch("TWAT", "FREQ", method=method, count=2))
        return [body.hex() for body in it.requests() if body != b"\x01"]

    assert heard("batch") == ["611a29"] * 2
    assert heard("single") == ["611a", "6129"] * 2
    assert heard("list") == ["641a29", "63", "63"]
    assert heard("stream") == ["711a29"]
    assert [heard(m) for m in STROKES] == [
        [f"{code:02x}1a29"] for code in (0x7F, *range(0x80, 0x84))
    ]


def test_a_true_01_is_a_value_by_every_method():
    for method in METHODS:
        for unknown in ("silent", "01"):
            ecu = ecu_on(bench(DATA | {0x20: b"\x01"}, unknown=unknown))
            values = [s.readings["THR"].value for s in ecu.watch("THR", method=method, count=3)]
            assert values == [1, 1, 1]


@pytest.mark.parametrize("method", ASKED)
def test_no_rate_means_as_fast_as_the_wire_gives(method):
    plain = {code: bytes(len(raw)) for code, raw in DATA.items()}  # nothing to be stuffed
    ecu = ecu_on(bench(plain))
    times = [s.time for s in ecu.watch(method=method, count=21)]
    limit = {"single": 5.0, "list": 30}.get(method, 17.8)  # sets a second, §5
    assert 20 / (times[-1] - times[0]) > 0.95 * limit
