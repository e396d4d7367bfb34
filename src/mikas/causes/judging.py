"""Judge the hypotheses: sound, each cause at several amounts, two causes at once."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from itertools import combinations
from math import exp, log
from typing import Final

from mikas.causes.knowledge import Complaint, Knowledge
from mikas.causes.model import GRID, KNOTS, SOUND, Fit, Model, Table, log_sum, squeezed

BEFORE_SOUND: Final = 0.85  # of a car about which nothing is known
BEFORE_TWO: Final = 0.01  # of two causes at once
COMPLAINED: Final = 4.0  # times as likely, if the complaint is of this cause
STORED: Final = 8.0  # times as likely, with such a fault stored
INDEPENDENT: Final = 20.0  # features that count whole; of more, each counts less: they overlap
PAIRED: Final = 6  # the best single causes that pairs are made of


@dataclass(frozen=True, slots=True)
class Judged:
    """All hypotheses: the probability of each cause in any of them, of sound, and the best fit."""

    probability: Mapping[str, float]
    sound: float
    best: Fit
    sound_fit: Fit
    model: Model


def judge(deviations: Mapping[str, float], table: Table, before: Mapping[str, float]) -> Judged:
    """Return how probable each cause is. `before`: its weight beforehand, together 1 - sound."""
    model = Model(table, deviations)
    sound_fit = model.fit((), ())
    hypotheses: list[tuple[tuple[str, ...], float, Fit]] = [
        ((), sound_fit.likelihood + log(BEFORE_SOUND), sound_fit)
    ]
    best_of: dict[str, Fit] = {}
    for cause in table.means:
        fits = [model.fit((cause,), (amount,)) for amount in GRID]
        best_of[cause] = max(fits, key=lambda fit: fit.likelihood)
        likelihood = log_sum([fit.likelihood for fit in fits]) - log(len(GRID))
        hypotheses.append(((cause,), likelihood + log(before[cause]), best_of[cause]))
    leading = sorted(best_of, key=lambda c: best_of[c].likelihood, reverse=True)[:PAIRED]
    pairs = [pair for pair in combinations(leading, 2) if _id(pair[0]) != _id(pair[1])]
    for pair in pairs:
        fits = [model.fit(pair, (a, b)) for a in KNOTS for b in KNOTS]
        best = max(fits, key=lambda fit: fit.likelihood)
        likelihood = log_sum([fit.likelihood for fit in fits]) - log(len(fits))
        weight = BEFORE_TWO / len(pairs)
        hypotheses.append((pair, likelihood + log(weight), best))
    temper = min(0.8, INDEPENDENT / max(1, len(model.places)))
    hypotheses = [(causes, temper * weight, fit) for causes, weight, fit in hypotheses]
    total = log_sum([weight for _, weight, _ in hypotheses])
    probability = dict.fromkeys(table.means, 0.0)
    sound = 0.0
    for causes, weight, _ in hypotheses:
        share = exp(weight - total)
        if not causes:
            sound = share
        for cause in causes:
            probability[cause] += share
    best = max(hypotheses, key=lambda each: each[1])[2]
    return Judged(probability, sound, best, sound_fit, model)


def _id(name: str) -> str:
    return name.partition("-")[0]


def weights_beforehand(
    known: Knowledge, table: Table, complaint: Complaint | None, faults: Collection[int]
) -> dict[str, float]:
    """Return how likely each cause is before anything is seen, by complaint and stored faults."""
    weights = {}
    for name in table.means:
        cause = known.causes.get(name)
        weight = 1.0
        if cause is not None and complaint in cause.complaints:
            weight *= COMPLAINED
        if cause is not None and cause.faults & set(faults):
            weight *= STORED
        weights[name] = weight
    total = sum(weights.values())
    share = (1 - BEFORE_SOUND - BEFORE_TWO) / total
    return {name: weight * share for name, weight in weights.items()}


def with_own_causes(table: Table, known: Knowledge) -> Table:
    """Return the table with the causes that are known, the user's by the effects in their files."""
    means = {name: rows for name, rows in table.means.items() if name in known.causes}
    spreads = dict(table.spreads)
    place = {name: index for index, name in enumerate(table.names)}
    for name, cause in known.causes.items():
        if not cause.effects:
            continue
        rows = [[0.0] * len(table.names) for _ in KNOTS]
        for feature, effect in cause.effects.items():
            if feature in place:
                for row, knot in zip(rows, KNOTS, strict=True):
                    row[place[feature]] = squeezed(effect * knot)
        means[name] = rows
        spreads[name] = [max(1.0, spread) for spread in table.spreads[SOUND]]
    return Table(table.names, table.correlation, means, spreads, table.counts)
