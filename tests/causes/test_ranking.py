"""Ranking of causes, on drives of virtual cars with known defects."""

from __future__ import annotations

from functools import cache

import pytest
from tools.causes.cars import Car, columns_of
from tools.causes.choose import without

from mikas.catalog import shipped as catalog
from mikas.causes.evidence import feature_texts
from mikas.causes.judging import Judged
from mikas.causes.knowledge import Complaint, load
from mikas.causes.measurements import hand_test, proposals
from mikas.causes.model import Fit
from mikas.causes.ranking import rank
from mikas.causes.result import CauseVerdict, Likelihood, RankedCause, Ranking
from mikas.causes.samples import Samples, samples_of
from mikas.causes.weights import shipped
from mikas.virtual.cars import EngineCar
from mikas.virtual.defects.choosing import car_of
from mikas.virtual.model.engine import Engine
from mikas.virtual.scenarios.scenario import SCENARIOS


@cache
def _samples(name: str = "", amount: float = 1.0, drive: str = "mixed", seed: int = 7) -> Samples:
    return samples_of(*columns_of(Car(seed, drive, {name: amount} if name else {})))


def _first(ranking: Ranking) -> str:
    return ranking.causes[0].id if ranking.causes else ranking.verdict


def test_a_leak_is_the_first_cause_of_a_drive_and_shows_its_moments() -> None:
    samples = _samples("leak")
    ranking = rank([samples])
    assert (ranking.verdict, _first(ranking)) == (CauseVerdict.CAUSES, "leak")
    assert ranking.causes[0].likelihood is not Likelihood.POSSIBLE
    evidence = ranking.causes[0].evidence_for[0]
    assert evidence.feature.startswith("trim")
    assert all(samples.times[0] <= a <= b <= samples.times[-1] for a, b in evidence.spans)


def test_a_sound_car_is_called_sound() -> None:
    assert rank([_samples(seed=11)]).verdict is CauseVerdict.SOUND


def test_values_without_an_engine_speed_tell_nothing() -> None:
    ranking = rank([samples_of([0.0, 1.0], {"UACC": [12.6, 12.5]})])
    assert ranking.verdict is CauseVerdict.CANNOT_TELL
    assert ranking.next


def test_no_samples_are_no_error() -> None:
    assert rank([]).verdict is CauseVerdict.CANNOT_TELL
    assert rank([samples_of([], {})]).verdict is CauseVerdict.CANNOT_TELL


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
    less = without(shipped(), ["throttle_stops"])
    samples = _samples("throttle_stops-open")
    alone = rank([samples], weights=less)
    assert (alone.verdict, alone.causes) == (CauseVerdict.UNKNOWN, ())
    assert "below" not in alone.text.en
    monkeypatch.setattr("mikas.causes.ranking.POSSIBLE", 0.0)
    several = rank([samples], weights=less)
    assert (several.verdict, bool(several.causes)) == (CauseVerdict.UNKNOWN, True)
    assert "below" in several.text.en
    assert several.causes[0].text.en in several.text.en


CALM, HARD = 22, 21
"""Seeds of a driver who never opens the throttle far, and of one who floors the pedal."""


def _not_seen(ranking: Ranking) -> list[str]:
    return [text.en for text in ranking.not_seen]


@pytest.mark.parametrize(
    ("name", "amount"),
    [("throttle_stops-open", 3.0), ("leak", 1.0), ("thermostat", 3.0), ("regulator-high", 3.0)],
)
def test_the_measurements_that_come_next_are_different_ones(name: str, amount: float) -> None:
    proposed = [each.test for each in rank([_samples(name, amount, "warm-idle", 5)]).next]
    assert len(proposed) == len(set(proposed)) == 2


def _alternator_or(name: str, likelihood: Likelihood, *shares: float) -> list[RankedCause]:
    """The alternator as the leading cause, and another, with these probabilities."""
    found = []
    for each, share in zip(("alternator", name), shares, strict=True):
        cause = load().causes[each]
        found.append(
            RankedCause(
                cause.id, cause.variant, likelihood, share, cause.text, cause.check, (), (), "", ""
            )
        )
    return found


def test_what_the_unit_s_values_do_not_separate_is_measured_by_hand() -> None:
    table, known = shipped().table, load()
    two = _alternator_or("regulator-low", Likelihood.PROBABLE, 0.6, 0.3)
    found = hand_test(two, table.names, table, known)  # all was seen
    assert found is not None
    test, pair = found
    assert (test.test, test.guided, pair) == ("by-hand", False, ("alternator", "regulator-low"))
    assert [each.cause for each in test.outcomes] == ["alternator", "regulator"]
    assert [each.means for each in test.outcomes] == [known.causes[name].text for name in pair]
    assert two[0].text.en in test.why.en
    backwards = hand_test(two[::-1], table.names, table, known)
    assert backwards is not None
    assert backwards[0] == test


def test_nothing_is_measured_by_hand_without_need() -> None:
    table, known, probable = shipped().table, load(), Likelihood.PROBABLE
    idle = [name for name in table.names if feature_texts()[name].seen == "idle"]
    two = _alternator_or("regulator-low", probable, 0.6, 0.3)
    assert hand_test(two, idle, table, known) is None  # a drive separates them
    assert hand_test(two[:1], table.names, table, known) is None
    assert hand_test([], table.names, table, known) is None
    certain = _alternator_or("regulator-low", Likelihood.ALMOST_CERTAIN, 0.999, 0.001)
    assert hand_test(certain, table.names, table, known) is None
    both = _alternator_or("regulator-low", probable, 0.95, 0.9)
    assert hand_test(both, table.names, table, known) is None
    other = _alternator_or("radiator", probable, 0.5, 0.4)
    assert hand_test(other, table.names, table, known) is None  # no file has a test


def test_another_measurement_is_not_said_to_separate_what_the_hand_does() -> None:
    table, known = shipped().table, load()
    names = ("alternator", "regulator-low", "radiator")
    judged = Judged(dict.fromkeys(names, 0.3), 0.0, 0.0, Fit((), (), 0.0, 1.0, 20, 1.0), 1.0, 9.0)
    seen = [name for name in table.names if feature_texts()[name].seen != "long-drive"]
    for each in proposals(judged, seen, table, known, names[:2]):
        both = [known.causes[name].text.en in each.why.en for name in names[:2]]
        assert not all(both), each.why.en


def test_where_no_cause_leads_what_shows_most_of_the_missing_is_measured() -> None:
    table, known = shipped().table, load()
    seen = [name for name in table.names if feature_texts()[name].seen == "idle"]
    undecided = Judged({}, 0.0, 1.0, Fit((), (), 0.0, 9.0, 20, 9.0), 9.0, 9.0)
    (proposed,) = proposals(undecided, seen, table, known)
    assert proposed.test == "drive"
    assert "most of what is missing" in proposed.why.en
    assert proposals(undecided, table.names, table, known) == ()


def test_full_load_is_seen_only_with_the_pedal_on_the_floor() -> None:
    assert "full load" in _not_seen(rank([_samples(seed=CALM)]))
    assert "full load" not in _not_seen(rank([_samples(seed=HARD)]))


def test_a_throttle_that_does_not_open_is_found_if_the_pedal_was_on_the_floor() -> None:
    found = rank([_samples("throttle_stops-short", seed=HARD)])
    assert (_first(found), found.causes[0].variant) == ("throttle_stops", "short")
    missed = rank([_samples("throttle_stops-short", seed=CALM)])
    assert missed.verdict is not CauseVerdict.CAUSES
    assert "full load" in _not_seen(missed)


def test_three_minutes_of_idle_never_call_a_car_sound() -> None:
    assert rank([_samples(drive="idle", seed=12)]).verdict is CauseVerdict.CANNOT_TELL
    ranking = rank([_samples("knock", drive="idle", seed=12)])
    assert ranking.verdict is CauseVerdict.CANNOT_TELL
    assert "drive it" in ranking.text.en
    assert ranking.next[0].test == "drive"


def test_without_its_cause_a_leak_is_never_called_another_almost_certainly() -> None:
    leak = _samples("leak", 1.2)
    assert rank([leak]).causes[0].id == "leak"
    ranking = rank([leak], weights=without(shipped(), ["leak"]))
    assert ranking.verdict in (CauseVerdict.UNKNOWN, CauseVerdict.CANNOT_TELL)
    assert all(c.likelihood is not Likelihood.ALMOST_CERTAIN for c in ranking.causes)


def test_too_little_is_never_said_to_be_unknown() -> None:
    """A minute of an engine that behaves like no known one: too little to be sure of that."""
    whole = _samples("throttle_stops-open", drive="idle", seed=12)
    less = without(shipped(), ["throttle_stops"])
    rows = [row for row, time in enumerate(whole.times) if time < whole.times[0] + 100]
    begun = Samples(
        [whole.times[row] for row in rows],
        {name: [column[row] for row in rows] for name, column in whole.columns.items()},
    )
    assert rank([whole], weights=less).verdict is CauseVerdict.UNKNOWN
    assert rank([begun], weights=less).verdict is CauseVerdict.CANNOT_TELL


def test_an_idle_that_never_holds_is_named_and_measured_next() -> None:
    unit = EngineCar(Engine(car_of("leak:13").applied_to(SCENARIOS["warm-idle"])), catalog())
    names = ("FREQ", "FREQX", "THR", "RXX", "TWAT", "JAIR")
    times = [0.25 * step for step in range(720)]
    columns: dict[str, list[float]] = {name: [] for name in names}
    for time in times:
        for name in names:
            parameter = catalog().parameter(name)
            columns[name].append(float(parameter.decode(unit.raw(parameter.code, time))))
    swinging = rank([samples_of(times, columns)], complaint=Complaint.IDLES_HIGH)
    assert swinging.verdict is CauseVerdict.CANNOT_TELL
    assert "swings from 1" in swinging.text.en
    assert "плавают от 1" in swinging.text.ru
    assert [each.test for each in swinging.next] == ["idle", "drive"]


def test_an_engine_that_does_not_start_is_not_to_be_driven() -> None:
    whole = _samples(drive="start", seed=3)
    begin = next(
        at for at, rpm in zip(whole.times, whole.columns["FREQ"], strict=True) if rpm > 400
    )
    rows = [row for row, time in enumerate(whole.times) if time < begin]
    cranked = Samples(
        [whole.times[row] for row in rows],
        {name: [column[row] for row in rows] for name, column in whole.columns.items()},
    )
    ranking = rank([cranked])
    assert ranking.verdict is CauseVerdict.CANNOT_TELL
    assert "did not run" in ranking.text.en
    assert {each.test for each in ranking.next} <= {"cranking"}
