"""Samples of recordings: thinned rows, several files of one car, a unit without injectors."""

from __future__ import annotations

from math import isnan, nan
from pathlib import Path

import numpy as np
import pytest

from mikas.catalog.ignition_only import DEAD
from mikas.causes.ranking import rank
from mikas.causes.rows import PERIOD, samples_of_rows, unserved
from mikas.causes.samples import samples_of
from mikas.recording.table.channels import Rows


def rows(times: list[float], **columns: list[float]) -> Rows:
    return Rows(np.array(times), {name: np.array(each) for name, each in columns.items()})


def test_a_sample_has_the_last_value_of_each_channel_in_its_bin() -> None:
    (samples,) = samples_of_rows(
        [rows([0.0, 0.05, 0.1, 0.45], FREQ=[800, nan, 840, nan], THR=[nan, 3, nan, nan])]
    )
    assert samples.times == [0.1, 0.45]
    assert samples.column("FREQ") == [840, 840]
    assert samples.column("THR") == [3, 3]
    assert samples.column("TWAT") is None


def test_a_clock_that_was_set_back_begins_other_samples() -> None:
    found = samples_of_rows([rows([5.0, 6.0], FREQ=[1, 2]), rows([1.0, 2.0], FREQ=[3, 4])])
    assert [each.column("FREQ") for each in found] == [[1, 2], [3, 4]]


def test_rows_without_a_moment_give_no_samples() -> None:
    assert samples_of_rows([]) == []
    assert samples_of_rows([rows([], FREQ=[])]) == []


@pytest.mark.parametrize("rate", [2.5, 35.0])
def test_a_fast_recording_has_no_more_samples_than_the_period_gives(rate: float) -> None:
    times = [number / rate for number in range(1000)]
    (samples,) = samples_of_rows([rows(times, FREQ=[float(time) for time in times])])
    assert len(samples) <= min(1000, samples.seconds / PERIOD + 2)


def idle(**dead: float) -> list[dict[str, list[float]]]:
    columns = {"FREQ": 850.0, "JAIR": 15.0, "INJ": 3.2, "FSM": 38.0} | dead
    return [{name: [value] * 60 for name, value in columns.items()}]


def test_a_unit_whose_injection_stays_0_serves_the_ignition_alone() -> None:
    times = [float(number) for number in range(60)]
    dead = [samples_of(times, each) for each in idle(JAIR=0, INJ=0, FSM=0)]
    assert unserved(dead) == DEAD
    without_meter = [samples_of(times, each) for each in idle(JAIR=0)]
    assert unserved(without_meter) == frozenset()
    standing = [samples_of(times, each) for each in idle(FREQ=0, JAIR=0, INJ=0, FSM=0)]
    assert unserved(standing) == frozenset()
    assert unserved([]) == frozenset()


def test_of_a_unit_without_injectors_nothing_is_concluded_from_them() -> None:
    times = [float(number) / 4 for number in range(400)]
    columns = {
        "FREQ": 850.0, "FREQX": 850.0, "THR": 0.0, "TWAT": 86.0, "TAIR": 20.0, "UACC": 13.9,
        "UOZ": 13.0, "JAIR": 0.0, "INJ": 0.0, "JQT": 0.0, "FSM": 0.0, "SSM": 0.0,
    }  # fmt: skip
    samples = [samples_of(times, {name: [value] * 400 for name, value in columns.items()})]
    ranking = rank(samples, absent=unserved(samples))
    assert not {"air_meter", "air_meter_zero", "idle_valve"} & {it.id for it in ranking.causes}
    assert "ignition alone" in " ".join(each.en for each in ranking.doubts)
    assert not any(isnan(it.value) for cause in ranking.causes for it in cause.evidence_for)


def test_the_command_line_has_every_complaint() -> None:
    from mikas.causes.knowledge import Complaint
    from mikas.cli.commands.recordings.causes import COMPLAINTS

    assert tuple(Complaint) == COMPLAINTS


def test_every_channel_that_a_feature_reads_is_taken_from_recordings() -> None:
    import inspect
    import re

    from mikas.causes import features, regimes
    from mikas.causes.rows import CHANNELS

    modules = Path(features.__file__).parent.glob("[!_]*.py")
    text = "".join(path.read_text("utf-8") for path in modules) + inspect.getsource(regimes)
    named = set(re.findall(r'"([A-Z][A-Z0-9_]{2,9})"', text))
    assert named <= set(CHANNELS)
