"""A surveyed unit, made virtual by its profile and surveyed again, gives the same profile."""

from __future__ import annotations

import json
import tempfile
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from survey_harness import Beside, drive, surveyed, url_of

from mikas.catalog import shipped

SIZES = dict(shipped().codes)
# By how much a time may differ that both surveys have measured: absolute, and a share.
TOLERANCES = {
    "turn_round": (3e-4, 0.02),
    "turn_round_spread": (3e-4, 0.3),
    "inter_byte": (1e-4, 0.02),
    "least_pause": (4e-3, 0.05),
    "stream_gap": (2e-4, 0.02),
    "stream_load": (0.1, 0.1),
}

quirks = st.fixed_dictionaries(
    {},
    optional={
        "model": st.sampled_from(["5.4"]),
        "echo": st.just(0),
        "turn_round": st.sampled_from([0.0005, 0.007, 0.03]),
        "turn_round_spread": st.sampled_from([0.001, 0.004]),
        "inter_byte": st.sampled_from([0.0005, 0.003]),
        "least_pause": st.sampled_from([0.012, 0.083]),
        "stream_gap": st.sampled_from([0.001, 0.02]),
        "stream_load": st.sampled_from([0.0, 0.6, 2.0]),
        "unknown": st.just("01"),
        "bad_write": st.just("silent"),
        "missing": st.sampled_from(["60", "71", "64+63", "23", "53+80", "stroke", "passports"]),
        "max_list": st.sampled_from([3, 20]),
        "max_list_61": st.sampled_from([2, 30]),
        "max_list_64": st.sampled_from([5, 21]),
        "max_list_71": st.sampled_from([4, 22]),
        "long_list": st.just("short"),
        "max_block": st.sampled_from([16, 100]),
        "counted_blocks": st.just(1),
        "accepts": st.sampled_from(["stuffed", "raw"]),
        "raw_checksum": st.just(1),
        "stream_end": st.sampled_from(["request", "break"]),
        "lacking": st.sampled_from(["1A", "3F+08", "5B+5C+72"]),
        "extra": st.sampled_from(["33", "90:2+A0:3", "1A:2"]),
        "faults": st.sampled_from(["17", "195+17+41"]),
    },
)


def compared(unit: dict[str, Any]) -> dict[str, Any]:
    """The profile with what may differ left out: data of the engine, which differ from one drive
    to the next.
    """
    codes = {
        code: each if SIZES.get(int(code, 16)) != each["size"] else each["size"]
        for code, each in (unit["codes"] or {}).items()
    }
    out = {key: value for key, value in unit.items() if key not in TOLERANCES}
    return json.loads(json.dumps(out | {"codes": codes, "strokes": None}))


def check_same(first: dict[str, Any], second: dict[str, Any]) -> None:
    assert compared(second) == compared(first)
    for name, (absolute, share) in TOLERANCES.items():
        assert (second[name] is None) is (first[name] is None), name
        if first[name] is not None:
            assert second[name] == pytest.approx(first[name], abs=absolute, rel=share), name
    assert (second["strokes"] is None) is (first["strokes"] is None)
    assert second["strokes"] == (first["strokes"] and pytest.approx(first["strokes"], abs=0.03))


@settings(max_examples=3)
@given(quirks)
def test_a_survey_of_the_unit_made_of_a_survey_is_the_same(given_quirks):
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        car = drive(folder)
        out = folder / "unit.zip"
        options = {"memory": True, "passports": True}
        first = surveyed(url_of(car, **given_quirks), out, Beside(), **options)
        again = url_of(car, unit=out)
        second = surveyed(again, folder / "again.zip", Beside(), **options)
    check_same(first.unit, second.unit)
