"""The history: bounded and decimated, with spikes and gaps kept."""

from __future__ import annotations

import numpy as np
from hypothesis import strategies as st

from mikas.dashboard.session.history import History, json_columns, plain
from mikas.recording.table.channels import Rows

NAN = float("nan")
COLUMN = st.lists(st.one_of(st.just(NAN), st.integers(-1000, 1000).map(float)), min_size=1)


def test_a_missing_value_is_null_in_json():
    rows = Rows(np.arange(3.0), {"A": np.array([1, NAN, 2.5])})
    assert json_columns(rows.times, rows.values) == {
        "names": ["A"], "times": [0.0, 1.0, 2.0], "values": [[1, None, 2.5]],
    }  # fmt: skip


def test_whole_numbers_stay_whole():
    assert plain([1.0, -0.0, 0.1, NAN]) == [1, 0, 0.1, None]


def test_a_changed_plan_is_another_set_of_columns():
    history = History()
    history.add(1.0, ("A", "B"), [1, 2])
    history.add(2.0, ("B", "C"), [3, 4])
    rows = history.rows(60)
    assert set(rows.values) == {"A", "B", "C"}
    assert plain(rows.values["A"]) == [1, None]
    assert plain(rows.values["B"]) == [2, 3]
    assert plain(history.rows(60, ["C", "X"]).values["X"]) == [None, None]
    assert history.rows(0.5).times.tolist() == [2.0]


def test_the_rows_added_since_a_count_are_of_all_plans(monkeypatch):
    monkeypatch.setattr("mikas.dashboard.session.history._ROWS", 3)
    history = History()
    for number in range(10):
        names, row = (("A", "B"), [number, 0]) if number < 5 else (("B",), [0])
        history.add(float(number), names, row)
    for first in range(11):
        for last in range(first, 11):
            times, columns = history.added(first, last, ["A", "X"])
            a, x = columns["A"], columns["X"]
            assert times.tolist() == list(range(first, last))
            assert plain(a) == [n if n < 5 else None for n in range(first, last)]
            assert plain(x) == [None] * (last - first)


def test_rows_that_are_too_old_are_dropped():
    history = History(seconds=1000)
    for number in range(20_000):
        history.add(float(number), ("A",), [number])
    rows = history.rows(1e9)
    assert 1000 <= len(rows.times) <= 1000 + 2 * 2048
    assert rows.values["A"][-1] == 19_999


def test_two_hours_stay_however_often_the_plan_changes():
    plans = [tuple(f"N{number}" for number in range(40 - less)) for less in (0, 1)]
    history = History()
    for second in range(7200):
        names = plans[second // 20 % 2]
        history.add(float(second), names, [float(second)] * len(names))
    rows = history.rows(7200)
    assert rows.times.tolist() == [float(second) for second in range(7200)]
    assert plain(rows.values["N0"]) == list(range(7200))


def test_the_oldest_goes_when_there_are_too_many_values(monkeypatch):
    monkeypatch.setattr("mikas.dashboard.session.history._ROWS", 10)
    monkeypatch.setattr("mikas.dashboard.session.history._MAX_VALUES", 100)
    history = History()
    for number in range(200):
        history.add(float(number), ("A", "B"), [number, number])
    assert 40 <= len(history.rows(7200).times) <= 50
    for number in range(200, 1000):  # blocks of one row
        history.add(float(number), ("A", "B") if number % 2 else ("B", "C"), [number, number])
    assert 35 <= len(history.rows(7200).times) <= 50


def test_an_empty_history_has_empty_columns():
    rows, named = History().rows(60), History().rows(60, ["A"])
    assert json_columns(rows.times, rows.values) == {"names": [], "times": [], "values": []}
    assert json_columns(named.times, named.values) == {
        "names": ["A"], "times": [], "values": [[]],
    }  # fmt: skip
