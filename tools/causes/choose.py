"""Choose the constants of judging, on cars that serve only this: neither weighed nor measured.

First how well each cause fits its own cars (four-fold: by tables that do not know the car), then
each constant in turn, from a few values, by what the validation cars would be called.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, fields, replace
from functools import partial
from statistics import median
from typing import Final

from mikas.causes.features import Seen
from mikas.causes.judging import (
    POOLED,
    Judged,
    JudgingConstants,
    Supposed,
    UsualFit,
    is_sound,
    is_unknown,
    judge,
    may_be_sound,
    suppose,
    unknown_defects,
    weights_beforehand,
    with_own_causes,
)
from mikas.causes.knowledge import load
from mikas.causes.model import GRID, SOUND, LikelihoodModel
from mikas.causes.ranking import POSSIBLE
from mikas.causes.weights import Weights, read
from tools.causes.tables import texts
from tools.causes.weigh import Example, weigh

FOLDS: Final = 4
BEGINNING: Final = JudgingConstants()
ANY: Final = {POOLED: UsualFit(1.0, 1.0)}

VALUES: Final[Mapping[str, Sequence[float]]] = {
    "unknown_width": (1.5, 2.5, 4.0),
    "independent": (36, 48),
    "sound_before": (0.3, 0.5, 0.65, 0.8, 0.9),
    "two_before": (0.003, 0.01, 0.03, 0.08),
    "unknown_before": (0.0001, 0.001, 0.005, 0.02, 0.05, 0.12),
    "said_sound": (0.5, 0.6, 0.7, 0.8, 0.9, 0.95),
    "cleared": (0.001, 0.003, 0.01, 0.03, 0.06),
    "named": (0.3, 0.5, 0.6, 0.7, 0.8, 0.9),
    "said_unknown": (0.2, 0.35, 0.5, 0.65, 0.8),
    "unlike": (2.8, 3.2, 4.0),  # 220 sound cars lie below 2.1, but for one: a margin for thousands
    "own": (0.8, 0.9, 1.0, 1.06, 1.12, 1.2),
    "far": (1.8, 2.0, 2.3, 2.7),
    "close": (1.05, 1.12, 1.2, 1.3, 1.4, 1.55, 1.7),
    "certain": (0.9, 0.95, 0.98, 0.99, 0.995, 0.998),
}


def seen_of(example: Example) -> dict[str, Seen]:
    """Return the example's values as what was seen."""
    return {name: Seen(value, value, ()) for name, value in example.values.items()}


def model_of(example: Example, weights: Weights) -> LikelihoodModel:
    """Return the model for an example, by these weights."""
    table = with_own_causes(weights.table, load())
    return LikelihoodModel(table, weights.deviations(seen_of(example), example.context))


def usual_fits(examples: Sequence[Example], causes: Sequence[str]) -> dict[str, UsualFit]:
    """Return the medians of how well each cause fits its own cars, few cars drawn to the pool's."""
    found: dict[str, list[tuple[float, float]]] = {}
    for fold in range(FOLDS):
        rest = [each for place, each in enumerate(examples) if place % FOLDS != fold]
        weights = read(*texts(weigh(rest, causes), ANY, BEGINNING))
        for example in examples[fold::FOLDS]:
            names = tuple(example.defects)
            model = model_of(example, weights)
            if len(model.places) < 12:
                continue
            grid = [(amount,) for amount in GRID] if names else [()]
            best = max((model.fit(names, each) for each in grid), key=lambda fit: fit.likelihood)
            found.setdefault(names[0] if names else SOUND, []).append(
                (best.distance, best.strangest)
            )
    pool = [each for several in found.values() for each in several]
    usual = {POOLED: UsualFit(median(d for d, _ in pool), median(s for _, s in pool))}
    for name, several in found.items():
        share = len(several) / (len(several) + 10)
        usual[name] = UsualFit(
            share * median(d for d, _ in several) + (1 - share) * usual[POOLED].distance,
            share * median(s for _, s in several) + (1 - share) * usual[POOLED].strangest,
        )
    return usual


@dataclass(frozen=True, slots=True)
class Trial:
    """A validation car. `kind`: what is asked; `supposed`: by the width of unknown defects."""

    kind: str
    right: frozenset[str]
    supposed: Mapping[float, Supposed]


def trials(
    examples: Mapping[str, Sequence[Example]], weights: Weights, processes: int
) -> list[Trial]:
    """Return the trials by kind; of the noticeable also one in which the cause is unknown."""
    work = [(kind, example) for kind, several in examples.items() for example in several]
    work += [("unknown", example) for example in examples["noticeable"]]
    with ProcessPoolExecutor(processes) as pool:
        return list(pool.map(partial(_trial, weights), work, chunksize=8))


def _trial(weights: Weights, work: tuple[str, Example]) -> Trial:
    kind, example = work
    right = frozenset(name.partition("-")[0] for name in example.defects)
    if kind == "unknown":
        weights = without(weights, right)
    model = model_of(example, weights)
    before = weights_beforehand(load(), model.table, None, ())
    found = suppose(model, before, BEGINNING.unknown_width)
    known = [each for each in found.hypotheses if not each.unknown]
    return Trial(
        kind,
        right,
        {
            width: Supposed([*known, *unknown_defects(model, width)], found.count)
            for width in VALUES["unknown_width"]
        },
    )


def without(weights: Weights, ids: Iterable[str]) -> Weights:
    """Return the weights without these causes."""
    gone = set(ids)
    table = weights.table
    means = {n: rows for n, rows in table.means.items() if n.partition("-")[0] not in gone}
    return replace(weights, table=replace(table, means=means))


@dataclass(frozen=True, slots=True)
class Said:
    """What a car would be called: as in `mikas.causes.ranking`, without words and evidence."""

    right: frozenset[str]
    named: Sequence[str]
    certain: bool
    unknown: bool
    accused: bool
    sound: bool

    @property
    def first(self) -> bool:
        """Whether the first is right."""
        return bool(self.named) and self.named[0] in self.right


def said_of(right: frozenset[str], judged: Judged, constants: JudgingConstants) -> Said:
    """Return what a car is called by these constants."""
    if is_sound(judged, constants):
        return Said(right, (), certain=False, unknown=False, accused=False, sound=True)
    shares: dict[str, float] = {}
    for name, share in judged.probability.items():
        cause = name.partition("-")[0]
        shares[cause] = shares.get(cause, 0.0) + share
    named = sorted((n for n in shares if shares[n] >= POSSIBLE), key=lambda n: -shares[n])
    cleared = not may_be_sound(judged, constants)
    odd = is_unknown(judged, shares[named[0]] if named else 0.0, constants)
    certain = bool(named) and shares[named[0]] >= constants.certain
    found = bool(named) and shares[named[0]] >= constants.named
    return Said(
        right, named,
        certain=certain and cleared and judged.oddness <= constants.close,
        unknown=cleared and odd, accused=cleared and (odd or found), sound=False,
    )  # fmt: skip


def figures(
    tried: Sequence[Trial], constants: JudgingConstants, usual: Mapping[str, UsualFit]
) -> dict[str, float]:
    """Return how often the validation cars are called rightly, in %."""
    by_kind: dict[str, list[Said]] = {}
    wary: list[Said] = []
    for each in tried:
        judged = judge(each.supposed[constants.unknown_width], constants, usual)
        by_kind.setdefault(each.kind, []).append(said_of(each.right, judged, constants))
        if each.kind == "sound":  # a few hundred must speak for thousands: with a margin
            worse = replace(constants, cleared=3 * constants.cleared, unlike=0.9 * constants.unlike)
            wary.append(said_of(each.right, judged, worse))

    def share(kind: str, test: Callable[[Said], bool]) -> float:
        several = by_kind.get(kind, ())
        return 100 * sum(map(test, several)) / max(1, len(several))

    certain = [
        said for kind, several in by_kind.items() if kind != "unknown" for said in several
        if said.certain
    ]  # fmt: skip
    return {
        "noticeable": share("noticeable", lambda said: said.first),
        "noticeable three": share("noticeable", lambda said: said.right <= set(said.named[:3])),
        "noticeable certain": share("noticeable", lambda said: said.certain),
        "noticeable unknown": share("noticeable", lambda said: said.unknown),
        "half": share("half", lambda said: said.first),
        "half three": share("half", lambda said: said.right <= set(said.named[:3])),
        "idle": share("idle", lambda said: said.first),
        "idle wrong": share("idle", lambda said: not said.first and said.accused),
        "pairs": share("pairs", lambda said: said.right <= set(said.named[:3])),
        "unknown said": share("unknown", lambda said: said.unknown),
        "unknown certain": share("unknown", lambda said: said.certain),
        "accused": 100 * sum(said.accused for said in wary) / max(1, len(wary)),
        "undecided": share("sound", lambda said: not said.sound and not said.accused),
        "wrong certain": 100 * sum(not said.first for said in certain) / max(1, len(certain)),
    }


def loss(found: Mapping[str, float]) -> float:
    """Return how far the figures are from the goals, each by its gravity."""

    def under(name: str, goal: float) -> float:
        return max(0.0, goal - found[name])

    def over(name: str, goal: float) -> float:
        return max(0.0, found[name] - goal)

    return (
        3 * under("noticeable", 98) + 2 * under("noticeable three", 100)
        + under("half", 88) + under("half three", 94) + under("idle", 70)
        + 2 * under("pairs", 88) + 1.5 * under("unknown said", 80)
        + 0.3 * under("noticeable certain", 85) + over("noticeable unknown", 2)
        + 6 * over("unknown certain", 0.7) + 6 * over("wrong certain", 0.3)
        + 10 * over("accused", 0.4) + over("undecided", 12) + 2 * over("idle wrong", 1)
    )  # fmt: skip


def chosen(tried: Sequence[Trial], usual: Mapping[str, UsualFit]) -> JudgingConstants:
    """Return the constants by which these cars are called best.

    How much the features count together changes the worth of all else: each has its own search.
    """
    begun = (replace(BEGINNING, independent=count) for count in VALUES["independent"])
    found = [_improved(each, tried, usual) for each in begun]
    return min(found, key=lambda each: loss(figures(tried, each, usual)))


def _improved(
    begin: JudgingConstants, tried: Sequence[Trial], usual: Mapping[str, UsualFit]
) -> JudgingConstants:
    """Return the constants, each but `independent` in turn set to the best of its values."""
    best, least = begin, loss(figures(tried, begin, usual))
    names = [each.name for each in fields(JudgingConstants) if each.name != "independent"]
    for _ in range(4):
        before = least
        for name in names:
            for value in VALUES[name]:
                candidate = replace(best, **{name: value})
                found = loss(figures(tried, candidate, usual))
                if found < least - 1e-9:
                    best, least = candidate, found
        if least == before:
            break
    return best
