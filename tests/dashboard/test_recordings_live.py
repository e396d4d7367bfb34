"""What the report of the running session takes of its history, and what it leaves out."""

from __future__ import annotations

import numpy as np

from dashboard.rig import rig
from mikas.catalog import shipped
from mikas.dashboard.api.report import _judged, _pauses, _since
from mikas.dashboard.history import Rows


def unit(time, *, another=False):
    return {"kind": "unit", "time": time, "another": another}


ROWS = Rows(np.arange(10.0), {"TWAT": np.arange(10.0), "UACC": np.arange(10.0)})


def test_what_is_shown_in_another_sense_is_not_judged() -> None:
    assert set(_judged(ROWS, shipped(), "corrected").values) == {"TWAT", "UACC"}
    assert set(_judged(ROWS, shipped(), "literal").values) == {"TWAT"}  # E2


def test_the_car_before_does_not_count() -> None:
    assert len(_since(ROWS, []).times) == 10
    assert len(_since(ROWS, [unit(3.0)]).times) == 10
    assert len(_since(ROWS, [unit(1.0), {"kind": "state", "time": 2.0}, unit(5.0)]).times) == 10
    changed = _since(ROWS, [unit(1.0), unit(4.0, another=True), unit(6.0)])
    assert changed.times.tolist() == [4, 5, 6, 7, 8, 9]
    assert changed.values["TWAT"].tolist() == [4, 5, 6, 7, 8, 9]
    twice = [unit(1.0), unit(4.0, another=True), unit(8.0, another=True)]
    assert _since(ROWS, twice).times.tolist() == [8, 9]


def test_a_passport_that_was_read_with_a_hole_is_no_other_car() -> None:
    whole = {**unit(1.0), "version_code": 10, "passport": ["A", "B"]}
    hole = {**unit(5.0), "version_code": 10, "passport": ["A", None]}
    assert len(_since(ROWS, [whole, hole]).times) == 10


def test_each_gap_once_and_none_from_before() -> None:
    reason = {"en": "no echo", "ru": "нет эха"}
    events = [
        {"kind": "gap", "time": 3.0, "began": 3.0, "ended": None, "reason": reason},
        {"kind": "gap", "time": 5.0, "began": 3.0, "ended": 5.0, "reason": reason},
        {"kind": "gap", "time": 0.5, "began": 0.1, "ended": 0.5, "reason": None},
        {"kind": "gap", "time": 2.0, "began": 0.1, "ended": 2.0, "reason": None},
        {"kind": "marker", "time": 4.0, "label": ""},
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
    assert "Not recorded, so it can&#39;t be told: throttle at 5 % or less" in text
