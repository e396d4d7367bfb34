"""Measure the ranking on cars that were not used for weighing: own seeds, amounts and drives."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import partial
from math import log
from typing import Final

from mikas.causes.knowledge import load
from mikas.causes.ranking import Observation, observe, rank_observation
from mikas.causes.result import CauseVerdict, Likelihood, Ranking
from mikas.causes.samples import samples_of
from mikas.causes.weights import shipped
from tools.causes.cars import AMOUNTS, BY_NAME, Car, columns_of, measured_sets
from tools.causes.choose import without

SECOND: Final[Mapping[str, str]] = {
    # The drive of a simulated car that is what a proposed measurement asks for.
    "cranking": "start", "idle": "idle", "warmup": "warm-up", "drive": "whole", "knock": "pull",
    "long-drive": "long",
}  # fmt: skip
MEASUREMENTS: Final = 2  # that an owner makes


@dataclass(frozen=True, slots=True)
class Outcome:
    """A car and the ranking of its drive."""

    car: Car
    ranking: Ranking

    @property
    def right(self) -> set[str]:
        """The ids of its defects."""
        return {name.partition("-")[0] for name in self.car.defects}

    @property
    def named(self) -> list[str]:
        """The ids that were named, the likeliest first."""
        return [cause.id for cause in self.ranking.causes]

    @property
    def first(self) -> bool:
        """Whether the first is right."""
        return self.named[:1] != [] and self.named[0] in self.right

    @property
    def among_three(self) -> bool:
        """Whether all its defects are among the first three."""
        return self.right <= set(self.named[:3])

    @property
    def certain(self) -> bool:
        """Whether a cause is said to be almost certain."""
        return any(c.likelihood is Likelihood.ALMOST_CERTAIN for c in self.ranking.causes[:1])


def observed(car: Car) -> Observation:
    """Return the observation of a car."""
    return observe([samples_of(*columns_of(car))], shipped())


def outcome(car: Car) -> Outcome:
    """Return the ranking of a car's drive."""
    return Outcome(car, rank_observation(observed(car), load(), shipped()))


def followed(car: Car) -> Outcome:
    """Return the ranking after at most two of the measurements that were proposed, in turn."""
    drives = [samples_of(*columns_of(car))]
    for number in range(MEASUREMENTS):
        ranking = rank_observation(observe(drives, shipped()), load(), shipped())
        done = Outcome(car, ranking)
        proposed = [each.test for each in ranking.next if each.test in SECOND]
        if done.certain or not proposed:  # a meter is of no use at a virtual car's terminals
            return done
        # The same measurement again is another drive of the car.
        again = Car(car.seed + 50_000 * number, SECOND[proposed[0]], car.defects, car.seed)
        drives.append(samples_of(*columns_of(again)))
    return Outcome(car, rank_observation(observe(drives, shipped()), load(), shipped()))


def left_out(car: Car) -> Outcome:
    """Return the ranking by tables in which the car's cause is missing."""
    gone = {name.partition("-")[0] for name in car.defects}
    return Outcome(car, rank_observation(observed(car), load(), without(shipped(), gone)))


def outcomes(
    cars: Sequence[Car], processes: int, judge: Callable[[Car], Outcome] = outcome
) -> list[Outcome]:
    """Return the outcomes of these cars, in parallel."""
    with ProcessPoolExecutor(processes) as pool:
        return list(pool.map(judge, cars, chunksize=2))


@dataclass(frozen=True, slots=True)
class Measured:
    """All that is measured. `curve`: of each defect by share of a noticeable amount."""

    noticeable: Sequence[Outcome]
    half: Sequence[Outcome]
    idle: Sequence[Outcome]
    after: Sequence[Outcome]
    sound: Sequence[Outcome]
    pairs: Sequence[Outcome]
    unknown: Sequence[Outcome]
    curve: Sequence[Outcome]


def measure(processes: int = 2, *, quick: bool = False) -> Measured:
    """Simulate and rank; `quick`: one car of each defect."""
    run = partial(outcomes, processes=processes)
    sets = measured_sets(quick=quick)
    return Measured(
        noticeable=run(sets.noticeable),
        half=run(sets.half),
        idle=run(sets.idle),
        after=run(sets.idle, judge=followed),
        sound=run(sets.sound),
        pairs=run(sets.pairs),
        unknown=run(sets.noticeable, judge=left_out),
        curve=run(sets.curve),
    )


def share(of: Iterable[bool]) -> float:
    """Return how many are true, in %."""
    values = list(of)
    return 100 * sum(values) / max(1, len(values))


def confusion(rows: Sequence[Outcome]) -> dict[str, Counter[str]]:
    """Return by defect what was named first, or the verdict where nothing was."""
    table: dict[str, Counter[str]] = {name: Counter() for name in BY_NAME}
    for row in rows:
        said = row.named[0] if row.named else row.ranking.verdict.value
        table[next(iter(row.car.defects))][said] += 1
    return table


def reliability(rows: Iterable[Outcome]) -> list[tuple[float, float, int, float]]:
    """Return by probability, in tenths: from, to, the number of causes, those right in %."""
    bins: dict[int, list[bool]] = {}
    for row in rows:
        for cause in row.ranking.causes:
            place = min(9, int(cause.probability * 10))
            bins.setdefault(place, []).append(cause.id in row.right)
    return [(i / 10, (i + 1) / 10, len(bins[i]), share(bins[i])) for i in sorted(bins)]


def found(measured: Measured) -> dict[str, list[tuple[float, float]]]:
    """Return by defect: shares of a noticeable amount, and in how many cars it is first, in %."""
    rows = [*measured.half, *measured.noticeable, *measured.curve]
    by_amount: dict[str, dict[float, list[bool]]] = {name: {} for name in BY_NAME}
    amounts = (*AMOUNTS, 0.5, 1.0)
    for row in rows:
        ((name, amount),) = row.car.defects.items()
        near = min(amounts, key=lambda each: abs(log(each / amount)))
        by_amount[name].setdefault(near, []).append(row.first)
    return {
        name: [(amount, share(several[amount])) for amount in sorted(several)]
        for name, several in by_amount.items()
    }


def smallest(curve: Sequence[tuple[float, float]]) -> float | None:
    """Return the amount that is found in half the drives, between two measured ones; None: none.

    A larger amount that is found more seldom counts as that found: the curve only falls back by
    the chance of few cars.
    """
    rising = [(amount, max(s for a, s in curve if a <= amount)) for amount, _ in curve]
    before, had = 0.0, 0.0
    for amount, found_in in rising:
        if found_in >= 50:
            return before + (amount - before) * (50 - had) / (found_in - had)
        before, had = amount, found_in
    return None


def accused(rows: Sequence[Outcome]) -> float:
    """Return the share of sound cars called anything but sound or can't tell, in %."""
    fine = (CauseVerdict.SOUND, CauseVerdict.CANNOT_TELL)
    return share(row.ranking.verdict not in fine for row in rows)


def is_wrong(row: Outcome) -> bool:
    """Whether a car with a defect is called sound, or named wrongly as found."""
    if row.ranking.verdict in (CauseVerdict.CANNOT_TELL, CauseVerdict.UNKNOWN):
        return False
    return not row.first
