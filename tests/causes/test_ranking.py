"""Ranking of causes, on drives of virtual cars with known defects."""

from __future__ import annotations

from functools import cache

from tools.causes.cars import Car, columns_of

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
