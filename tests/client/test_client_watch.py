"""`watch`: every method, its pace, its gaps and its end; never a value twice, never a spin."""

from __future__ import annotations

from contextlib import closing
from itertools import islice, pairwise

import pytest
from client_bench import bench, ecu_on

from mikas.client import METHODS
from mikas.errors import (
    DamagedResponse,
    EchoOnly,
    EcuRefused,
    LinkLost,
    NoResponse,
    NotConfirmed,
    NotSupported,
    UnknownParameter,
    UsageError,
    WriteRefused,
    WrongLength,
)
from mikas.virtual.disturbance import Trouble
from mikas.virtual.table_car import TableCar
from virtual_bench import DATA

STROKES = [m for m in METHODS if m.startswith("stroke")]
STREAMS = ["stream", *STROKES]
ASKED = [m for m in METHODS if m not in STREAMS]


class CountingCar(TableCar):
    """Every datum is one more than the one before, so that a repeated one shows."""

    def __init__(self):
        super().__init__(DATA, rpm=850.0)
        self.count = 0

    def raw(self, code, now):
        self.count += 1
        return (self.count % 65536).to_bytes(2, "little")[: len(self._data[code])]


@pytest.mark.parametrize("method", METHODS)
class TestEveryMethod:
    def test_gives_what_was_asked_for(self, method):
        it = bench()
        ecu = ecu_on(it)
        samples = list(ecu.watch("TWAT", "INJ", "RXX", method=method, count=4))
        assert [list(s.readings) for s in samples] == [["TWAT", "INJ", "RXX"]] * 4
        assert all(r.raw == DATA[r.parameter.code] for s in samples for r in s.readings.values())
        assert not any(s.gap for s in samples)
        times = [s.time for s in samples]
        assert times == sorted(set(times))
        assert ecu.read("TWAT")  # and the unit is free

    def test_gives_all_of_the_catalog_with_no_names(self, method):
        (sample,) = ecu_on(bench()).watch(method=method, count=1)
        assert {r.parameter.code: r.raw for r in sample.readings.values()} == DATA

    def test_never_gives_a_value_twice(self, method):
        it = bench(car=CountingCar())
        ecu = ecu_on(it)
        seen = []
        for n, sample in enumerate(ecu.watch("INJ", "JAIR", method=method, count=60)):
            if n % 7 == 3:
                it.trouble(Trouble.DAMAGED)
            if n % 11 == 5 and method in ASKED:  # a stream's responses come without a request
                it.trouble(Trouble.DOUBLED)
            if n % 13 == 6:
                it.trouble(Trouble.LATE)
            seen += [r.raw for r in sample.readings.values()]
        assert len(seen) > 80
        assert len(set(seen)) == len(seen)

    def test_goes_on_after_the_supply_was_off(self, method):
        it = bench()
        ecu = ecu_on(it)
        states = []
        for sample in ecu.watch("TWAT", "INJ", method=method, count=12):
            states.append("gap" if sample.gap else "data")
            assert bool(sample.readings) is not sample.gap
            assert (sample.reason is None) is not sample.gap
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
                reasons.append(type(sample.reason))
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
        assert ecu.read("FREQ")  # nobody has had to ask for a third
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

    def test_a_misspelt_name_is_told_at_once(self, method):
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
def test_bad_settings_are_told_at_once(settings):
    it = bench()
    with pytest.raises(UsageError):
        ecu_on(it).watch("TWAT", **settings)
    assert it.requests() == []


def test_requests_by_method():
    def heard(method):
        it = bench()
        list(ecu_on(it).watch("TWAT", "FREQ", method=method, count=2))
        return [body.hex() for body in it.requests() if body != b"\x01"]

    assert heard("auto") == heard("batch") == ["611a29"] * 2
    assert heard("single") == ["611a", "6129"] * 2
    assert heard("list") == ["641a29", "63", "63"]
    assert heard("stream") == ["711a29"]
    assert [heard(m) for m in STROKES] == [
        [f"{code:02x}1a29"] for code in (0x7F, *range(0x80, 0x84))
    ]


@pytest.mark.parametrize("unknown", ["silent", "01"])
class TestRefused:
    @pytest.mark.parametrize("method", STREAMS)
    def test_a_stream_that_the_unit_does_not_have(self, unknown, method):
        it = bench(missing="stream,stroke", unknown=unknown)
        ecu = ecu_on(it)
        with pytest.raises(NotSupported) as told:
            next(ecu.watch("TWAT", "FREQ", method=method))
        assert told.value.request
        assert ecu.read("TWAT")

    def test_a_stream_of_too_many(self, unknown):
        for long_list in ("silent", "short"):
            it = bench(max_list=5, long_list=long_list, unknown=unknown)
            ecu = ecu_on(it)
            with pytest.raises(NotSupported):
                next(ecu.watch(method="stream"))
            assert next(ecu.watch("TWAT", method="stream", count=1)).readings

    def test_a_list_that_the_unit_does_not_have(self, unknown):
        for missing in ("list", "64", "63"):
            ecu = ecu_on(bench(missing=missing, unknown=unknown))
            with pytest.raises(EcuRefused):
                next(ecu.watch("TWAT", "FREQ", method="list"))
            assert ecu.read("TWAT")

    def test_a_list_of_too_many_says_what_to_do(self, unknown):
        ecu = ecu_on(bench(max_list=5, unknown=unknown))
        with pytest.raises(WriteRefused, match="too long"):
            next(ecu.watch(method="list"))

    def test_a_unit_without_61(self, unknown):
        for method in ("auto", "single"):
            ecu = ecu_on(bench(missing="61", unknown=unknown))
            with pytest.raises(NotSupported):
                next(ecu.watch("TWAT", method=method))

    @pytest.mark.parametrize("method", ["auto", "batch", "single"])
    def test_all_parameters_refused_is_an_error_not_an_empty_log(self, unknown, method):
        data = {code: raw for code, raw in DATA.items() if code not in (0x42, 0x72)}
        ecu = ecu_on(bench(data, unknown=unknown))
        ecu.read("TWAT")
        for _ in range(2):
            with pytest.raises(NotSupported, match="RCOK"):
                list(ecu.watch("RCOK", "MINERR", method=method, count=3))

    @pytest.mark.parametrize("method", ["auto", "batch", "single"])
    def test_some_parameters_refused_are_missing(self, unknown, method):
        data = {code: raw for code, raw in DATA.items() if code != 0x42}
        it = bench(data, unknown=unknown)
        ecu = ecu_on(it)
        ecu.read("TWAT")
        samples = list(ecu.watch("TWAT", "RCOK", method=method, count=3))
        assert [list(s.readings) for s in samples] == [["TWAT"]] * 3
        assert len([b for b in it.requests(0x61) if 0x42 in b]) <= 8  # asked about once


@pytest.mark.parametrize("unknown", ["silent", "01"])
@pytest.mark.parametrize("method", STREAMS)
def test_a_lost_beginning_of_a_stream_is_no_refusal(unknown, method, monkeypatch):
    it = bench(unknown=unknown)
    ecu = ecu_on(it)
    answer = it.bus.ecu.responder.answer
    deaf = iter([True])  # once the unit does not hear

    class Deaf:
        def __getattr__(self, name):
            return getattr(responder, name)

        def answer(self, body, now):
            if body[0] in (0x71, 0x7F, 0x80, 0x81, 0x82, 0x83) and next(deaf, False):
                return None
            return answer(body, now)

    responder = it.bus.ecu.responder
    it.bus.ecu.responder = Deaf()
    assert next(ecu.watch("TWAT", "INJ", method=method, count=1)).readings


@pytest.mark.parametrize("method", STROKES)
def test_a_standing_engine_gives_gaps_that_say_so(method):
    ecu = ecu_on(bench(DATA | {0x29: b"\x00"}, rpm=0.0))
    samples = list(ecu.watch("TWAT", method=method, count=3))
    assert all(isinstance(s.reason, NoResponse) for s in samples)
    assert "engine turns" in str(samples[0].reason)
    assert samples[2].time - samples[0].time > 9  # it waits for the engine, 5 s each


class TestTheList:
    def test_it_is_set_again_after_a_power_cycle_that_nobody_noticed(self):
        it = bench()
        ecu = ecu_on(it)
        for names in (("TWAT", "INJ"), ("TWAT",)):  # one byte: 01 could pass for a datum
            samples = ecu.watch(*names, method="list", rate=0.1)
            assert next(samples).readings
            it.power_cycle(ecu)
            after = [next(samples) for _ in range(3)]
            values = [r.raw for s in after for r in s.readings.values()]
            assert set(values) <= {DATA[0x1A], DATA[0x3F]}
            assert not after[-1].gap
            samples.close()

    def test_another_list_in_between_is_noticed(self):
        it = bench()
        ecu = ecu_on(it)
        samples = ecu.watch("TWAT", method="list")
        next(samples)
        ecu.set_list("FREQ")
        assert list(next(samples).readings) == ["TWAT"]
        ecu.raw(bytes([0x64, 0x20, 0x20]))
        assert next(samples).readings["TWAT"].raw == DATA[0x1A]

    def test_two_watches_by_list_do_not_mix(self):
        ecu = ecu_on(bench())
        one = ecu.watch("TWAT", method="list")
        two = ecu.watch("FREQ", method="list")
        for _ in range(3):
            assert next(one).readings["TWAT"].raw == DATA[0x1A]
            assert next(two).readings["FREQ"].raw == DATA[0x29]

    def test_setting_it_is_a_change_that_may_be_refused(self):
        it = bench()
        ecu = ecu_on(it, confirm=lambda change: False)
        with pytest.raises(NotConfirmed):
            next(ecu.watch("TWAT", method="list"))
        assert it.requests() == []

    def test_a_lost_answer_to_setting_it_is_no_refusal(self):
        it = bench()
        ecu = ecu_on(it)
        it.trouble(Trouble.LOST)
        assert next(ecu.watch("TWAT", method="list", count=1)).readings


@pytest.mark.parametrize("method", STREAMS)
def test_during_a_stream_nothing_else_can_be_asked_in_this_thread(method):
    ecu = ecu_on(bench())
    samples = ecu.watch("TWAT", method=method)
    next(samples)
    with pytest.raises(UsageError, match="stream"):
        ecu.read("TWAT")
    with pytest.raises(UsageError, match="stream"):
        next(ecu.watch("TWAT"))
    samples.close()
    assert ecu.read("TWAT")


@pytest.mark.parametrize("method", STREAMS)
def test_closing_the_ecu_ends_a_stream_that_runs(method):
    it = bench()
    ecu = ecu_on(it)
    samples = ecu.watch("TWAT", method=method)
    next(samples)
    ecu.close()
    assert any(h.kind == "stream-end" for h in it.happenings)
    with pytest.raises((LinkLost, StopIteration)):
        next(samples)
    samples.close()


@pytest.mark.parametrize("stream_end", ["byte", "request", "break"])
def test_a_stream_ends_however_the_unit_wants_it(stream_end):
    it = bench(stream_end=stream_end)
    ecu = ecu_on(it)
    assert len(list(ecu.watch("TWAT", "FREQ", method="stream", count=5))) == 5
    assert any(h.kind == "stream-end" for h in it.happenings)
    assert ecu.read("FREQ")["FREQ"].raw == DATA[0x29]


def test_a_parameter_that_is_a_true_01_in_every_method():
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


def test_a_damaged_response_of_a_stream_is_a_gap_and_the_stream_goes_on():
    it = bench()
    with closing(ecu_on(it).watch("FREQ", "TWAT", method="stream")) as samples:
        next(samples)
        it.trouble(None, Trouble.DAMAGED, None, Trouble.FOREIGN)
        came = list(islice(samples, 12))
    assert [type(s.reason) for s in came if s.gap] == [DamagedResponse, WrongLength]
    assert all(s.reason.received for s in came if s.gap)
    assert len(it.requests(0x71)) == 1  # it was not begun again
