"""Judge the hypotheses: sound, each cause at several amounts, two causes at once, an unknown one.

    suppose ──► hypotheses with likelihoods ──► judge ──► probabilities

An unknown defect moves the features of some systems by any amount: whatever explains a car worse
than that is not its cause. The constants (`JudgingConstants`) are chosen by `make causes` on cars
of their own, and stand in `weights/judging.csv`.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from math import exp, log, sqrt
from typing import Final

from mikas.causes.features.words import feature_texts
from mikas.causes.knowledge import Complaint, Knowledge
from mikas.causes.model import (
    GRID,
    KNOTS,
    SOUND,
    Fit,
    LikelihoodModel,
    WeightTable,
    log_sum,
    squeezed,
)

COMPLAINED: Final = 4.0  # times as likely, if the complaint is of this cause
STORED: Final = 8.0  # times as likely, with such a fault stored
LEADING: Final = 4  # the best single causes that pairs are made of
PARTNERS: Final = 5  # the best second causes of each
POOLED: Final = "*"  # in the table of fits: all causes together


@dataclass(frozen=True, slots=True)
class JudgingConstants:
    """What `make causes` chooses on cars of its own for choosing.

    `independent`: features that count whole; of more, each counts less: they overlap.
    `sound_before`, `two_before`, `unknown_before`: how likely a sound car, two causes, an unknown
    defect are; `unknown_width`: how far that moves things. `certain`: the probability of the almost
    certain; `named`: of a cause that is named as found; `cleared`: of sound, above it nothing is
    named as found; `said_sound`, `said_unknown`: from which these are said. `unlike`: how much
    worse than a sound car one may fit that is still held for sound. `own`, `close`, `far`: how much
    worse than its own cars a hypothesis may fit not to be called unknown though something unknown
    is likelier, to be almost certain, and to explain a car at all.
    """

    unknown_width: float = 2.5
    independent: float = 36.0
    sound_before: float = 0.8
    two_before: float = 0.01
    unknown_before: float = 0.02
    said_sound: float = 0.8
    cleared: float = 0.02
    named: float = 0.5
    said_unknown: float = 0.3
    unlike: float = 2.5
    own: float = 1.0
    far: float = 2.0
    close: float = 1.3
    certain: float = 0.99


@dataclass(frozen=True, slots=True)
class UsualFit:
    """How well a cause fits its own cars: the medians of distance and of the strangest feature."""

    distance: float
    strangest: float


@dataclass(frozen=True, slots=True)
class Hypothesis:
    """Causes (none: a sound car), how probable what was seen is with them, and the best fit."""

    causes: tuple[str, ...]
    likelihood: float  # logarithm, all amounts together
    before: float  # logarithm of the weight beforehand, among those of its kind
    fit: Fit
    unknown: bool = False


@dataclass(frozen=True, slots=True)
class Supposed:
    """All hypotheses about one car. `count`: of the features that were seen."""

    hypotheses: Sequence[Hypothesis]
    count: int


@dataclass(frozen=True, slots=True)
class Judged:
    """The probability of each cause in any hypothesis, of sound, of an unknown one; the best fit.

    `oddness`: how much worse the best fits than the causes' own cars do; `sound_oddness`: sound.
    """

    probability: Mapping[str, float]
    sound: float
    unknown: float
    best: Fit
    oddness: float
    sound_oddness: float


def suppose(model: LikelihoodModel, before: Mapping[str, float], unknown_width: float) -> Supposed:
    """Return the hypotheses. `before`: of each cause its weight, together 1."""
    sound = model.fit((), ())
    found = [Hypothesis((), sound.likelihood, 0.0, sound)]
    singles = []
    for cause in model.table.means:
        fits = [model.fit((cause,), (amount,)) for amount in GRID]
        likelihood = log_sum([fit.likelihood for fit in fits]) - log(len(GRID))
        best = max(fits, key=lambda fit: fit.likelihood)
        singles.append(Hypothesis((cause,), likelihood, log(before[cause]), best))
    singles.sort(key=lambda each: -each.fit.likelihood)
    found += singles
    found += _pairs(model, singles)
    found += unknown_defects(model, unknown_width)
    return Supposed(found, len(model.places))


def _pairs(model: LikelihoodModel, singles: Sequence[Hypothesis]) -> list[Hypothesis]:
    """Return pairs of the leading causes with those that explain best what each leaves."""
    found: dict[frozenset[str], Hypothesis] = {}
    for one in singles[:LEADING]:
        (a,), (amount,) = one.causes, one.fit.amounts
        others = [b for (b,) in (each.causes for each in singles) if _id(a) != _id(b)]
        screened = {b: model.fit((a, b), (amount, 1.0)).likelihood for b in others}
        for b in sorted(others, key=lambda each: -screened[each])[:PARTNERS]:
            if frozenset((a, b)) not in found:
                found[frozenset((a, b))] = _pair(model, a, b, amount)
    weight = -log(max(1, len(found)))
    return [Hypothesis(p.causes, p.likelihood, weight, p.fit) for p in found.values()]


def _pair(model: LikelihoodModel, a: str, b: str, amount: float) -> Hypothesis:
    """Return the pair, the amount of each in turn."""
    fits = [model.fit((a, b), (amount, other)) for other in KNOTS]
    best = max(fits, key=lambda fit: fit.likelihood)
    fits += [model.fit((a, b), (each, best.amounts[1])) for each in KNOTS]
    best = max(fits, key=lambda fit: fit.likelihood)
    likelihood = log_sum([fit.likelihood for fit in fits]) - 2 * log(len(KNOTS))
    return Hypothesis((a, b), likelihood, 0.0, best)


def unknown_defects(model: LikelihoodModel, width: float) -> list[Hypothesis]:
    """Return an unknown defect of each system, and of each set of systems that a known one has."""
    words, table = feature_texts(), model.table
    systems = [words[table.names[place]].system for place in model.places]
    moved = {frozenset((each,)) for each in systems} | set(table.systems.values())
    found = []
    for each in moved:
        wide = [system in each for system in systems]
        if any(wide):
            fit = model.fit_unknown(wide, width)
            found.append(Hypothesis((), fit.likelihood, -log(len(moved)), fit, unknown=True))
    return found


def judge(supposed: Supposed, constants: JudgingConstants, usual: Mapping[str, UsualFit]) -> Judged:
    """Return how probable each cause is."""
    hypotheses = supposed.hypotheses
    temper = min(1.0, constants.independent / max(1, supposed.count))
    weighed = [
        (each, temper * each.likelihood + each.before + log(_before(each, constants)))
        for each in hypotheses
    ]
    total = log_sum([weight for _, weight in weighed])
    causes = dict.fromkeys(cause for each in hypotheses for cause in each.causes)
    probability = dict.fromkeys(causes, 0.0)
    sound = unknown = 0.0
    for each, weight in weighed:
        share = exp(weight - total)
        if each.unknown:
            unknown += share
        elif not each.causes:
            sound = share
        for cause in each.causes:
            probability[cause] += share
    known = [pair for pair in weighed if not pair[0].unknown]
    best = max(known, key=lambda pair: pair[1])[0].fit
    return Judged(
        probability, sound, unknown, best, oddness(best, usual),
        oddness(hypotheses[0].fit, usual),
    )  # fmt: skip


def may_be_sound(judged: Judged, constants: JudgingConstants) -> bool:
    """Whether nothing may be named as found, since the car may be sound.

    A car that looks like no sound one is none, however little a known defect explains it.
    """
    return judged.sound > constants.cleared and judged.sound_oddness <= constants.unlike


def is_sound(judged: Judged, constants: JudgingConstants) -> bool:
    """Whether the verdict is *sound*."""
    return judged.sound >= constants.said_sound and judged.sound_oddness <= constants.unlike


def is_unknown(judged: Judged, leading: float, constants: JudgingConstants) -> bool:
    """Whether the verdict is *unknown*. `leading`: the probability of the first cause.

    It is, if even the best hypothesis fits much worse than its own cars do; or if a defect that is
    not known is likelier than the first cause, and that does not fit as its own cars do.
    """
    if judged.oddness > constants.far:
        return True
    likely = judged.unknown >= constants.said_unknown and judged.unknown > leading
    return likely and judged.oddness > constants.own


def _before(hypothesis: Hypothesis, constants: JudgingConstants) -> float:
    """Return how likely hypotheses of this kind are before anything is seen."""
    if hypothesis.unknown:
        return constants.unknown_before
    if len(hypothesis.causes) == 2:
        return constants.two_before
    if not hypothesis.causes:
        return constants.sound_before
    return max(0.01, 1 - constants.sound_before - constants.two_before)


def oddness(fit: Fit, usual: Mapping[str, UsualFit]) -> float:
    """Return how much worse the fit is than that of the causes' own cars; 1: as usual."""
    own = [usual.get(cause, usual[POOLED]) for cause in fit.causes or (SOUND,)]
    distance = fit.distance / max(each.distance for each in own)
    strangest = fit.strangest / max(each.strangest for each in own)
    return max(sqrt(distance), strangest)


def _id(name: str) -> str:
    return name.partition("-")[0]


def weights_beforehand(
    known: Knowledge, table: WeightTable, complaint: Complaint | None, faults: Collection[int]
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
    return {name: weight / total for name, weight in weights.items()}


def with_own_causes(table: WeightTable, known: Knowledge) -> WeightTable:
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
    systems = {name: known.causes[name].systems for name in means}
    return WeightTable(table.names, table.correlation, means, spreads, table.counts, systems)
