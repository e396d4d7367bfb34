"""The report of the running connection: the part of its history that counts."""

from __future__ import annotations

import numpy as np

from dashboard.rig import rig
from mikas.catalog import shipped
from mikas.client import Passport
from mikas.dashboard.api.library.report import _pauses, of_this_unit, without_other_readings
from mikas.i18n import Text
from mikas.recording.table.channels import Rows
from mikas.sampling.events import Gap, LineState, Marker, StateChanged, UnitFound


def unit(time, *, another=False):
    return UnitFound(time, 10, Passport(("A", "B"), ()), another)


ROWS = Rows(np.arange(10.0), {"TWAT": np.arange(10.0), "UACC": np.arange(10.0)})


def test_what_is_shown_in_another_sense_is_not_judged() -> None:
    assert set(without_other_readings(ROWS, shipped(), "corrected").values) == {"TWAT", "UACC"}
    assert set(without_other_readings(ROWS, shipped(), "literal").values) == {"TWAT"}  # E2


def _since(rows, events):
    return of_this_unit(rows, events)[0]


def test_the_car_before_does_not_count() -> None:
    assert len(_since(ROWS, []).times) == 10
    assert len(_since(ROWS, [unit(3.0)]).times) == 10
    assert (
        len(_since(ROWS, [unit(1.0), StateChanged(2.0, LineState.SAMPLING), unit(5.0)]).times) == 10
    )
    changed = _since(ROWS, [unit(1.0), unit(4.0, another=True), unit(6.0)])
    assert changed.times.tolist() == [4, 5, 6, 7, 8, 9]
    assert changed.values["TWAT"].tolist() == [4, 5, 6, 7, 8, 9]
    twice = [unit(1.0), unit(4.0, another=True), unit(8.0, another=True)]
    assert _since(ROWS, twice).times.tolist() == [8, 9]
    assert of_this_unit(ROWS, twice)[1] == twice[2:]


def test_a_passport_that_was_read_with_a_hole_is_no_other_car() -> None:
    whole = unit(1.0)
    hole = UnitFound(5.0, 10, Passport(("A", None), ()))
    assert len(_since(ROWS, [whole, hole]).times) == 10


def test_each_gap_once_and_none_from_before() -> None:
    reason = Text("no echo", "нет эха")
    events = [
        Gap(3.0, 3.0, None, reason),
        Gap(5.0, 3.0, 5.0, reason),
        Gap(0.5, 0.1, 0.5, None),
        Gap(2.0, 0.1, 2.0, None),
        Marker(4.0),
    ]
    pauses = list(_pauses(events, 1.0))
    assert [(pause.began, pause.ended) for pause in pauses] == [(3.0, 5.0), (1.0, 2.0)]
    assert pauses[0].reason is not None
    assert pauses[0].reason.ru == "нет эха"
    assert list(_pauses(events, None)) == []


def test_an_adapter_that_was_pulled_out_is_in_the_report(tmp_path) -> None:
    with rig(tmp_path, "sim:?scenario=warm-idle") as idle:
        idle.sampling()
        idle.cars.pull()
        idle.until(lambda it: it["state"]["line"] == "no-port")
        idle.cars.put_back()
        idle.sampling()
        text = idle.get("/report").text
    assert "<dt>Gaps</dt><dd>1: " in text
    assert "Can&#39;t be determined, as this was not recorded: throttle at 5 % or less" in text
