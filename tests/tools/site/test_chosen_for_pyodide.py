"""No test of the dashboard is forgotten when others run on Pyodide (`make browser`)."""

from __future__ import annotations

from pathlib import Path

from on_pyodide import chosen

DASHBOARD = Path(__file__).parents[2] / "dashboard"


def test_every_test_is_run_or_left_out_for_a_reason():
    files = {path.name for path in DASHBOARD.glob("test_*.py")}
    run = [each for part in chosen.PARTS.values() for each in part]
    left_out = [each for each in chosen.LEFT_OUT if "::" not in each]
    assert sorted([*run, *left_out]) == sorted(files)
    for each in chosen.LEFT_OUT:
        file, _, name = each.partition("::")
        assert not name or f"\ndef {name}(" in (DASHBOARD / file).read_text("utf-8"), each
