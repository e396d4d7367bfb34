"""`watch` by the methods one by one: what a unit refuses, the list that it keeps, its streams."""

from __future__ import annotations

from contextlib import closing
from itertools import islice

import pytest
from client_harness import STREAMS, STROKES, bench, ecu_on

from mikas.errors import (
    DamagedResponse,
    EcuRefused,
    EngineStopped,
    LinkLost,
    NoResponse,
    NotConfirmed,
    NotSupported,
    UsageError,
    WriteRefused,
    WrongLength,
)
from mikas.virtual.fault_injector import LineFault
from virtual_harness import DATA


@pytest.mark.parametrize("unknown", ["silent", "01"])
class TestRefused:
    @pytest.mark.parametrize("method", STREAMS)
    def test_a_stream_that_the_unit_does_not_have_is_an_error(self, unknown, method):
        it = bench(missing="stream,stroke", unknown=unknown)
        ecu = ecu_on(it)
        with pytest.raises(NotSupported) as caught:
            next(ecu.watch("TWAT", "FREQ", method=method))
        assert caught.value.request
        assert ecu.read("TWAT")

    def test_a_stream_of_too_many_parameters_is_refused(self, unknown):
        for long_list in ("silent", "short"):
            it = bench(max_list=5, long_list=long_list, unknown=unknown)
            ecu = ecu_on(it)
            with pytest.raises(NotSupported):
                next(ecu.watch(method="stream"))
            assert next(ecu.watch("TWAT", method="stream", count=1)).readings

    def test_a_list_that_the_unit_does_not_have_is_an_error(self, unknown):
        for missing in ("list", "64", "63"):
            ecu = ecu_on(bench(missing=missing, unknown=unknown))
            with pytest.raises(EcuRefused):
                next(ecu.watch("TWAT", "FREQ", method="list"))
            assert ecu.read("TWAT")

    def test_a_list_of_too_many_says_what_to_do(self, unknown):
        ecu = ecu_on(bench(max_list=5, unknown=unknown))
        with pytest.raises(WriteRefused, match="too long"):
            next(ecu.watch(method="list"))

    def test_a_unit_without_61_can_not_be_watched(self, unknown):
        for method in ("batch", "single"):
            ecu = ecu_on(bench(missing="61", unknown=unknown))
            with pytest.raises(NotSupported):
                next(ecu.watch("TWAT", method=method))

    @pytest.mark.parametrize("method", ["batch", "single"])
    def test_all_parameters_refused_is_an_error_not_an_empty_log(self, unknown, method):
        data = {code: raw for code, raw in DATA.items() if code not in (0x42, 0x72)}
        ecu = ecu_on(bench(data, unknown=unknown))
        ecu.read("TWAT")
        for _ in range(2):
            with pytest.raises(NotSupported, match="RCOK"):
                list(ecu.watch("RCOK", "MINERR", method=method, count=3))

    @pytest.mark.parametrize("method", ["batch", "single"])
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


class TestTheList:
    def test_a_list_is_set_again_after_an_unnoticed_power_cycle(self):
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
        it.next_faults(LineFault.LOST)
        assert next(ecu.watch("TWAT", method="list", count=1)).readings


@pytest.mark.parametrize("method", STROKES)
def test_a_standing_engine_gives_gaps_that_say_so(method):
    ecu = ecu_on(bench(DATA | {0x29: b"\x00"}, rpm=0.0))
    samples = list(ecu.watch("TWAT", method=method, count=3))
    assert all(isinstance(s.error, EngineStopped) for s in samples)
    assert samples[0].error.reason.en == "No stroke for 2 s: the engine is not turning"
    assert "двигатель не вращается" in samples[0].error.text.ru
    assert samples[2].time - samples[0].time > 4  # it waits for the engine, 2 s each


@pytest.mark.parametrize("method", STREAMS)
def test_a_stream_that_falls_silent_gives_the_length_of_the_wait(method):
    it = bench()
    ecu = ecu_on(it)
    with closing(ecu.watch("TWAT", method=method)) as samples:
        before = next(samples)
        it.power_cycle(ecu)
        gap = next(sample for sample in samples if sample.gap)
        assert next(samples).readings
    assert isinstance(gap.error, NoResponse)
    seconds = gap.error.fields["seconds"]
    assert seconds == (0.5 if method == "stream" else 2)
    assert gap.time - before.time >= seconds
    assert f"within {seconds:g} s" in gap.error.reason.en


@pytest.mark.parametrize("method", STREAMS)
def test_during_a_stream_this_thread_can_send_no_other_request(method):
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


def test_a_damaged_response_of_a_stream_is_a_gap_and_the_stream_goes_on():
    it = bench()
    with closing(ecu_on(it).watch("FREQ", "TWAT", method="stream")) as samples:
        next(samples)
        it.next_faults(None, LineFault.DAMAGED, None, LineFault.FOREIGN)
        came = list(islice(samples, 12))
    assert [type(s.error) for s in came if s.gap] == [DamagedResponse, WrongLength]
    assert all(s.error.received for s in came if s.gap)
    assert len(it.requests(0x71)) == 1  # it was not started again
