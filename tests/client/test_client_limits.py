"""How many parameters one request takes (D11): found by halving, kept for the unit, no more than
that.
"""

from __future__ import annotations

import json
import os

import pytest
from client_harness import bench, ecu_on

from mikas.client import Limits, limits
from mikas.client.limits import STARTING_LIST, LimitsStore, MethodTiming
from mikas.errors import NoResponse, NotSupported
from mikas.virtual.fault_injector import LineFault
from mikas.virtual.quirks import EcuQuirks
from mikas.virtual.responder import Identity
from virtual_harness import DATA

WAYS = [("silent", "silent"), ("silent", "01"), ("short", "silent"), ("short", "01")]


@pytest.mark.parametrize(("long_list", "unknown"), WAYS)
@pytest.mark.parametrize(("takes", "learnt"), [(1, 1), (2, 2), (3, 3), (6, 6), (8, 6), (10, 10),
                                               (11, 11), (20, 11), (21, 64)])  # fmt: skip
def test_what_fits_is_found_by_halving(long_list, unknown, takes, learnt):
    it = bench(max_list=takes, long_list=long_list, unknown=unknown)
    ecu = ecu_on(it)
    readings = ecu.read()
    assert {r.parameter.code: r.raw for r in readings.values()} == DATA
    assert ecu.info().limits == Limits(max_list=learnt)
    it.forget()
    assert ecu.read().keys() == readings.keys()
    assert len(it.requests(0x61)) == -(-21 // learnt)  # no request that is too long any more
    assert ecu.info().limits == Limits(max_list=learnt)


@pytest.mark.parametrize(("long_list", "unknown"), WAYS)
def test_a_short_list_and_refused_codes_are_learnt_together(long_list, unknown):
    data = {code: raw for code, raw in DATA.items() if code not in (0x07, 0x42, 0x72)}
    it = bench(data, max_list=10, long_list=long_list, unknown=unknown)
    ecu = ecu_on(it)
    for _ in range(3):
        readings = ecu.read()
        assert {r.parameter.code: r.raw for r in readings.values()} == data
    limits = ecu.info().limits
    assert sorted(limits.refused) == [0x07, 0x42, 0x72]
    assert 5 <= limits.max_list <= 10


@pytest.mark.parametrize("takes", [1, 2, 5])
def test_what_was_learnt_holds_for_the_rest_of_the_same_list(takes):
    """A unit that is silent to what is too long: each such request is a second of waiting."""
    it = bench(max_list=takes, long_list="silent", unknown="silent")
    ecu = ecu_on(it)
    assert len(ecu.read()) == 23
    assert len([body for body in it.requests(0x61) if len(body) - 1 > takes]) <= 8
    assert ecu.tester.link.now() < 12


@pytest.mark.parametrize("losses", [1, 2])
@pytest.mark.parametrize("unknown", ["silent", "01"])
def test_lost_responses_are_no_limit(losses, unknown):
    it = bench(unknown=unknown)
    ecu = ecu_on(it)
    # Every second answer is the one that finds the step again.
    it.next_faults(*[LineFault.LOST, None] * losses)
    assert len(ecu.read()) == 23
    assert ecu.info().limits == Limits()


def test_a_lost_response_is_no_refusal():
    it = bench()
    ecu = ecu_on(it, retries=0)
    it.next_faults(LineFault.LOST)
    assert ecu.read("TWAT")["TWAT"].raw == DATA[0x1A]
    assert ecu.info().limits == Limits()


def test_a_code_that_answered_once_is_never_refused_by_silence():
    it = bench()
    ecu = ecu_on(it)
    ecu.read()
    it.next_faults(*[LineFault.LOST, None] * 40)
    for sample in ecu.watch("TWAT", method="single", count=3):
        assert sample.gap
    assert ecu.info().limits == Limits()


def test_bad_line_for_long_leaves_the_limits_alone():
    it = bench()
    it.bus.fault_injector.rates = {LineFault.LOST: 0.02, LineFault.DAMAGED: 0.02}
    ecu = ecu_on(it)
    came = list(ecu.watch(count=500))
    assert sum(not sample.gap for sample in came) > 490
    assert ecu.info().limits == Limits()


class TestKeptForTheUnit:
    def learnt(self, tmp_path, **how):
        it = bench(max_list=10, **how)
        ecu = ecu_on(it, state=tmp_path)
        ecu.read()
        ecu.close()
        return it

    def test_the_next_session_begins_with_it(self, tmp_path):
        it = self.learnt(tmp_path)
        ecu = ecu_on(it, state=tmp_path)
        assert len(ecu.read()) == 23
        assert [len(body) - 1 for body in it.requests(0x61)] == [10, 10, 1]

    def test_another_unit_begins_with_nothing(self, tmp_path):
        self.learnt(tmp_path)
        other = bench(identity=Identity(0x0A, ("ANOTHER",) + ("",) * 7))
        ecu = ecu_on(other, state=tmp_path)
        assert len(ecu.read()) == 23
        assert ecu.info().limits == Limits()
        assert len(other.requests(0x61)) == 1
        same_passport = bench(identity=Identity(0x09, bench().bus.ecu.responder.identity.passports))
        assert ecu_on(same_passport, state=tmp_path).info().limits == Limits()

    @pytest.mark.parametrize("unknown", ["silent", "01"])
    def test_units_without_a_passport_share_nothing_but_what_is_measured_anyway(
        self, tmp_path, unknown
    ):
        """They can't be distinguished: one may have the parameter that the other refuses."""
        passports = "+".join(f"{code:02X}" for code in range(0x51, 0x59))
        poor = {code: raw for code, raw in DATA.items() if code not in (0x1A, 0x3F)}
        it = bench(poor, max_list=10, missing=passports, unknown=unknown)
        ecu = ecu_on(it, state=tmp_path)
        ecu.read()
        paces = {"batch": MethodTiming(21, 0.002), "stream": MethodTiming(21, None)}
        ecu.keep_timings("cable, 2 ms", paces)
        assert ecu.limits().refused
        assert ecu.limits().methods == {"cable, 2 ms": paces}
        ecu.close()
        other = ecu_on(bench(missing=passports, unknown=unknown), state=tmp_path)
        assert other.limits() == Limits(methods={"cable, 2 ms": {"batch": MethodTiming(21, 0.002)}})
        assert len(other.read()) == 23

    def test_the_passport_is_read_only_if_there_are_limits_to_look_up(self, tmp_path):
        it = bench()
        ecu_on(it, state=tmp_path).read("TWAT")
        assert it.requests() == [b"\x61\x1a"]

    @pytest.mark.parametrize(
        "text",
        [
            "",
            "{",
            "null",
            "[]",
            "{}",
            "\x00\xff",
            '{"max_list": "many", "max_block": {}, "refused": []}',
            '{"max_list": Infinity, "max_block": {}, "refused": []}',
            '{"max_list": 10, "max_block": [], "refused": []}',
            '{"max_list": 10, "max_block": {}, "refused": 5}',
            '{"max_list": 10, "max_block": {}, "refused": [null]}',
            "[" * 5000,
        ],
    )
    def test_a_corrupt_file_counts_as_nothing_learnt(self, tmp_path, text):
        it = self.learnt(tmp_path)
        (kept,) = tmp_path.glob("*.json")
        kept.write_text(text, "latin-1")
        ecu = ecu_on(it, state=tmp_path)
        assert len(ecu.read()) == 23
        assert json.loads(kept.read_text("utf-8"))["max_list"] == 10  # learnt again

    @pytest.mark.posix
    def test_what_is_no_file_or_too_large_counts_as_nothing_learnt(self, tmp_path):
        it = self.learnt(tmp_path)
        (kept,) = tmp_path.glob("*.json")
        (tmp_path / "zero.json").symlink_to("/dev/zero")
        os.mkfifo(tmp_path / "pipe.json")
        (tmp_path / "folder.json").mkdir()
        with (tmp_path / "large.json").open("wb") as large:
            large.truncate(1 << 40)
        store = LimitsStore(tmp_path)
        assert store.limits_any
        kept.unlink()
        assert not store.limits_any
        os.mkfifo(kept)
        assert len(ecu_on(it, state=tmp_path).read()) == 23
        assert json.loads(kept.read_text("utf-8"))["max_list"] == 10  # the pipe was replaced

    def test_of_a_thousand_units_none_is_looked_into(self, tmp_path, monkeypatch):
        monkeypatch.setattr(limits, "_MOST_FILES", 3)
        for number in range(4):
            assert not LimitsStore(tmp_path).limits_any
            (tmp_path / f"{number}.json").write_text("{}")
        assert LimitsStore(tmp_path).limits_any  # so the passport is read

    def test_nonsense_numbers_are_brought_back_into_bounds(self, tmp_path):
        it = self.learnt(tmp_path)
        (kept,) = tmp_path.glob("*.json")
        stored = json.loads(kept.read_text("utf-8"))
        kept.write_text(json.dumps(stored | {"max_list": -3, "max_block": {"ram": 9999}}))
        limits = ecu_on(it, state=tmp_path).info().limits
        assert (limits.max_list, limits.block("ram")) == (1, 255)

    def test_a_folder_that_cannot_be_written_is_said_once_and_costs_nothing_else(
        self, tmp_path, said
    ):
        (tmp_path / "file").write_text("")
        it = bench(max_list=10)
        for folder in (tmp_path / "file", tmp_path / "file" / "units"):
            ecu = ecu_on(it, state=folder)
            assert len(ecu.read()) == 23
            ecu.forget_limits()  # there is nothing to forget
        (sentence,) = said
        assert f"can't be saved in {tmp_path / 'file'} (" in sentence.en
        assert "не сохраняется" in sentence.ru

    def test_limits_that_can_not_be_forgotten_are_said(self, tmp_path, said):
        it = self.learnt(tmp_path)
        (kept,) = tmp_path.iterdir()
        kept.unlink()
        kept.mkdir()
        ecu_on(it, state=tmp_path).forget_limits()
        (sentence,) = said
        assert f"can't be deleted in {tmp_path} (" in sentence.en

    def test_a_folder_that_may_not_be_looked_into_is_empty(self, tmp_path, monkeypatch):
        def denied(self, pattern):
            raise PermissionError(13, "Permission denied")

        monkeypatch.setattr("pathlib.Path.glob", denied)
        assert LimitsStore(tmp_path).empty

    def test_a_half_written_file_is_never_visible(self, tmp_path):
        self.learnt(tmp_path)
        assert [path.suffix for path in tmp_path.iterdir()] == [".json"]

    def test_what_was_read_stands_though_the_unit_does_not_say_who_it_is(self, tmp_path):
        it = bench(max_list=10, long_list="short")
        ecu = ecu_on(it, state=tmp_path)
        # 21 twice, 11, 10 … and the passport's pieces are lost
        request = it.bus.ecu.responder.answer
        it.bus.ecu.responder = Mute(it.bus.ecu.responder, request)
        assert len(ecu.read()) == 23


class Mute:
    """A responder whose passports come damaged, as far as the tester can see."""

    def __init__(self, responder, answer):
        self._responder = responder
        self._answer = answer

    def __getattr__(self, name):
        return getattr(self._responder, name)

    def answer(self, body, now):
        return b"\x00" * 5 if body[0] in range(0x51, 0x59) else self._answer(body, now)


def test_what_info_shows_is_a_copy():
    ecu = ecu_on(bench())
    shown = ecu.info().limits
    shown.refused.append(0x1A)
    shown.max_block["ram"] = 1
    shown.max_list = 1
    assert ecu.info().limits == Limits()
    assert ecu.info().limits.max_list == STARTING_LIST
    assert not ecu.info().limits.learnt


@pytest.mark.parametrize("unknown", ["silent", "01"])
@pytest.mark.parametrize("code", [0x20, 0x1A, 0x3F])
def test_a_code_that_is_refused_all_at_once_is_never_read_as_a_one(unknown, code):
    """01 is how some units refuse (D10), and it is what a datum may be as well."""
    it = bench(unknown=unknown)
    ecu = ecu_on(it)
    ecu.read()
    del it.car.data[code]
    with pytest.raises((NotSupported, NoResponse)):
        ecu.read()
    assert ecu.limits() == Limits()


@pytest.mark.parametrize(("long_list", "unknown"), WAYS)
def test_a_unit_that_takes_less_than_it_did(long_list, unknown):
    it = bench(unknown=unknown)
    ecu = ecu_on(it)
    ecu.read()
    it.bus.ecu.responder.quirks = EcuQuirks().with_options(
        {"max_list": "6", "long_list": long_list, "unknown": unknown}
    )
    for _ in range(4):
        assert {r.parameter.code: r.raw for r in ecu.read().values()} == DATA
    assert ecu.limits() == Limits(max_list=6)
    it.forget()
    ecu.read()
    assert [len(body) - 1 for body in it.requests(0x61)] == [6, 6, 6, 3]
