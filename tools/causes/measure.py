"""Measure the ranking on cars that were not used for weighing: own seeds, amounts and drives."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import partial
from typing import Final

from mikas.causes.knowledge import load
from mikas.causes.model import Table
from mikas.causes.ranking import Observation, observe, rank_observation
from mikas.causes.result import Likelihood, Ranking, Verdict
from mikas.causes.samples import samples_of
from mikas.causes.weights import Weights, shipped
from tools.causes.cars import (
    BY_NAME,
    Car,
    columns_of,
    measured_cars,
    pairs_of_defects,
    sound_cars,
)

SECOND: Final[Mapping[str, str]] = {
    # The drive of a simulated car that is what a proposed measurement asks for.
    "cranking": "whole", "idle": "whole", "warmup": "warm-up", "drive": "whole",
    "knock": "whole", "long-drive": "whole",
}  # fmt: skip


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
    """Return the ranking after at most two of the measurements that were proposed."""
    drives = [samples_of(*columns_of(car))]
    ranking = rank_observation(observe(drives, shipped()), load(), shipped())
    kinds = dict.fromkeys(SECOND[each.test] for each in ranking.next)
    more = (columns_of(Car(car.seed, kind, car.defects)) for kind in kinds)
    drives.extend(samples_of(*each) for each in more)
    return Outcome(car, rank_observation(observe(drives, shipped()), load(), shipped()))


def left_out(car: Car) -> Outcome:
    """Return the ranking by tables in which the car's cause is missing."""
    weights, known = shipped(), load()
    table = weights.table
    gone = {name.partition("-")[0] for name in car.defects}
    means = {n: rows for n, rows in table.means.items() if n.partition("-")[0] not in gone}
    less = Weights(
        weights.scales,
        Table(table.names, table.correlation, means, table.spreads, table.counts),
        weights.header,
    )
    return Outcome(car, rank_observation(observed(car), known, less))


def outcomes(
    cars: Sequence[Car], processes: int, judge: Callable[[Car], Outcome] = outcome
) -> list[Outcome]:
    """Return the outcomes of these cars, in parallel."""
    with ProcessPoolExecutor(processes) as pool:
        return list(pool.map(judge, cars, chunksize=2))


@dataclass(frozen=True, slots=True)
class Measured:
    """All that is measured."""

    noticeable: Sequence[Outcome]
    half: Sequence[Outcome]
    idle: Sequence[Outcome]
    after: Sequence[Outcome]
    sound: Sequence[Outcome]
    pairs: Sequence[Outcome]
    unknown: Sequence[Outcome]


def measure(processes: int = 2, *, quick: bool = False) -> Measured:
    """Simulate and rank; `quick`: one car of each defect."""
    each = partial(min, 1) if quick else int
    run = partial(outcomes, processes=processes)
    noticeable = measured_cars("whole", each(5), 500_000)
    idle = measured_cars("idle", each(3), 600_000)
    return Measured(
        noticeable=run(noticeable),
        half=run(measured_cars("whole", each(4), 550_000, 0.5)),
        idle=run(idle),
        after=run(idle, judge=followed),
        sound=run(sound_cars(20 if quick else 250)),
        pairs=run(pairs_of_defects(10 if quick else 60)),
        unknown=run(noticeable, judge=left_out),
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


def found(rows: Iterable[Outcome]) -> dict[str, list[tuple[float, bool]]]:
    """Return by defect the amounts, and whether the first cause was right."""
    result: dict[str, list[tuple[float, bool]]] = {name: [] for name in BY_NAME}
    for row in rows:
        ((name, amount),) = row.car.defects.items()
        result[name].append((amount, row.first))
    return result


def accused(rows: Sequence[Outcome]) -> float:
    """Return the share of sound cars called anything but sound or can't tell, in %."""
    fine = (Verdict.SOUND, Verdict.CANNOT_TELL)
    return share(row.ranking.verdict not in fine for row in rows)
