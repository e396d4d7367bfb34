"""Ranking of causes, on drives of virtual cars with known defects."""

from __future__ import annotations

from functools import cache

import pytest
from tools.causes.cars import Car, columns_of

from mikas.causes.knowledge import Complaint
from mikas.causes.ranking import rank
from mikas.causes.result import Likelihood, Ranking, Verdict
from mikas.causes.samples import Samples, samples_of


@cache
def _samples(name: str = "", amount: float = 1.0, drive: str = "mixed", seed: int = 7) -> Samples:
    return samples_of(*columns_of(Car(seed, drive, {name: amount} if name else {})))


def _first(ranking: Ranking) -> str:
    return ranking.causes[0].id if ranking.causes else ranking.verdict


def test_a_leak_is_the_first_cause_of_a_drive_and_shows_its_moments() -> None:
    samples = _samples("leak")
    ranking = rank([samples])
    assert (ranking.verdict, _first(ranking)) == (Verdict.CAUSES, "leak")
    assert ranking.causes[0].likelihood is not Likelihood.POSSIBLE
    evidence = ranking.causes[0].evidence_for[0]
    assert evidence.feature.startswith("trim")
    assert all(samples.times[0] <= a <= b <= samples.times[-1] for a, b in evidence.spans)


def test_a_sound_car_is_called_sound() -> None:
    assert rank([_samples(seed=11)]).verdict is Verdict.SOUND


def test_values_without_an_engine_speed_tell_nothing() -> None:
    ranking = rank([samples_of([0.0, 1.0], {"UACC": [12.6, 12.5]})])
    assert ranking.verdict is Verdict.CANNOT_TELL
    assert ranking.next


def test_no_samples_are_no_error() -> None:
    assert rank([]).verdict is Verdict.CANNOT_TELL
    assert rank([samples_of([], {})]).verdict is Verdict.CANNOT_TELL


def test_evidence_is_counted_and_a_range_of_one_value_is_that_value() -> None:
    ranking = rank([_samples("throttle_stops-open")], complaint=Complaint.IDLES_HIGH)
    shown = [each.text.ru for cause in ranking.causes for each in cause.evidence_for]
    assert shown
    for text in shown:
        _, _, usual = text.partition("у исправных: ")
        ends = usual.rstrip(")").split(" … ")
        assert len(ends) == len(set(ends)), text
        if text.startswith(("дроссель", "наименьшее открытие", "размах")):
            assert not usual.startswith("−"), text


def test_what_no_cause_explains_names_no_causes_below(monkeypatch: pytest.MonkeyPatch) -> None:
    one, other = _samples(drive="idle"), _samples("throttle_stops-open", drive="idle")
    both = rank([_joined(one, other)])
    assert (both.verdict, bool(both.causes)) == (Verdict.UNKNOWN, True)
    assert "below" in both.text.en
    monkeypatch.setattr("mikas.causes.ranking.POSSIBLE", 2.0)
    alone = rank([_joined(one, other)])
    assert (alone.verdict, alone.causes) == (Verdict.UNKNOWN, ())
    assert "below" not in alone.text.en


def _joined(one: Samples, other: Samples) -> Samples:
    """Two cars one after the other, as the minutes of one."""
    later = one.times[-1] + 1 - other.times[0]
    return samples_of(
        [*one.times, *(time + later for time in other.times)],
        {name: [*column, *other.columns[name]] for name, column in one.columns.items()},
    )
