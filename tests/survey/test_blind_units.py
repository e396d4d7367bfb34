"""Units whose assumptions are drawn from a seed: nothing that a survey finds of them is wrong."""

from __future__ import annotations

import pytest
from bench.blind_units import surveyed


@pytest.mark.parametrize(
    ("seed", "trouble"),
    [
        (2009, {"latency_ms": "16"}),
        (2016, {"latency_ms": "1"}),
        (2026, {"missing-byte": "0.01"}),
        (4012, {"doubled": "0.02"}),
        (4023, {"late": "0.01"}),
        (5019, {"noise": "0.03"}),
        (7009, {"lost": "0.02"}),
    ],
)
def test_a_bad_line_or_a_slow_adapter_makes_nothing_wrong(tmp_path, seed, trouble):
    unit = surveyed(seed, tmp_path, trouble)
    assert [row for row in unit.rows if row.verdict == "wrong"] == []
    assert sum(row.verdict == "right" for row in unit.rows) >= 16


@pytest.mark.parametrize("seed", [1, 3, 101, 102])
def test_nothing_found_is_wrong_and_what_is_open_has_a_reason(tmp_path, seed):
    unit = surveyed(seed, tmp_path)
    assert [row for row in unit.rows if row.verdict == "wrong"] == []
    assert sum(row.verdict == "right" for row in unit.rows) >= 16
    for row in unit.rows:
        assert row.verdict == "right" or row.found.partition(": ")[2]
