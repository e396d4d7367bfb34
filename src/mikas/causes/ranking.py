"""Rank the causes for what was seen of a car.

    ranking = rank([samples_of(times, columns)], complaint=Complaint.IDLES_HIGH)

Each hypothesis (sound, one cause at several amounts, two causes at once) gets a likelihood by the
tables, and a weight beforehand: by the owner's complaint and the stored faults. A hypothesis wins
only if it also fits: what nothing fits is unknown, not the least bad cause.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from math import exp, log
from typing import Final

from mikas.causes.evidence import Explained, evidence_of
from mikas.causes.features import Seen, View, context_of, features_of
from mikas.causes.knowledge import Complaint, Knowledge, KnownCause, load
from mikas.causes.measurements import missing, proposals
from mikas.causes.model import GRID, KNOTS, SOUND, Fit, Model, Table, log_sum
from mikas.causes.regimes import drive_of
from mikas.causes.result import (
    ORIGIN,
    Likelihood,
    RankedCause,
    Ranking,
    Verdict,
)
from mikas.causes.samples import Samples
from mikas.causes.weights import Weights, shipped
from mikas.i18n import Text

BEFORE_SOUND: Final = 0.5  # of a car about which nothing is known
BEFORE_TWO: Final = 0.04  # of two causes at once
COMPLAINED: Final = 4.0  # times as likely, if the complaint is of this cause
STORED: Final = 8.0  # times as likely, with such a fault stored
CERTAIN: Final = 0.97
PROBABLE: Final = 0.55
POSSIBLE: Final = 0.06
MOST: Final = 5
STRANGE: Final = 2.6  # squared distance a feature, from which a hypothesis does not fit
LEAST: Final = 9  # features; with fewer nothing is said
PAIRED: Final = 6  # the best single causes that pairs are made of


@dataclass(frozen=True, slots=True)
class Observation:
    """What was seen of a car: deviations of sound cars by feature, and where each comes from."""

    deviations: Mapping[str, float]
    seen: Mapping[str, Seen]
    context: Mapping[str, float]
    sources: Mapping[str, int]
    seconds: float
    ran: bool


def rank(
    recordings: Sequence[Samples],
    *,
    complaint: Complaint | None = None,
    faults: Collection[int] = (),
    absent: Collection[str] = (),
    knowledge: Knowledge | None = None,
    weights: Weights | None = None,
) -> Ranking:
    """Return the causes for one car's samples: of a recording, several, or the last minutes.

    `faults`: stored fault numbers. `absent`: channels that this unit does not serve (an
    ignition-only one): nothing is read from them.
    """
    known = knowledge or load()
    tables = weights or shipped()
    observation = observe(recordings, tables, absent)
    return rank_observation(
        observation,
        known,
        tables,
        complaint=complaint,
        faults=faults,
        ignition_only=bool(absent),
    )


def observe(
    recordings: Sequence[Samples], weights: Weights, absent: Collection[str] = ()
) -> Observation:
    """Return what was seen in these recordings of one car, each feature put together."""
    deviations: dict[str, list[tuple[float, int, Seen]]] = {}
    contexts: list[Mapping[str, float]] = []
    ran = False
    for source, samples in enumerate(recordings):
        if absent:
            kept = {n: c for n, c in samples.columns.items() if n not in absent}
            samples = Samples(samples.times, kept)  # noqa: PLW2901  (the same, with less)
        drive = drive_of(samples)
        if drive is None:
            continue
        ran = ran or bool(drive.running)
        context = context_of(View(drive))
        contexts.append(context)
        found = features_of(drive)
        for name, deviation in weights.deviations(found, context).items():
            deviations.setdefault(name, []).append((deviation, source, found[name]))
    values, seen, sources = {}, {}, {}
    for name, several in deviations.items():
        values[name] = sum(each[0] for each in several) / len(several)
        _, sources[name], seen[name] = max(several, key=lambda each: abs(each[0]))
    seconds = sum(samples.seconds for samples in recordings)
    return Observation(values, seen, contexts[0] if contexts else {}, sources, seconds, ran)


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


def _weights_beforehand(
    known: Knowledge, table: Table, complaint: Complaint | None, faults: Collection[int]
) -> dict[str, float]:
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
                    row[place[feature]] = effect * knot
        means[name] = rows
        spreads[name] = [max(1.0, spread) for spread in table.spreads[SOUND]]
    return Table(table.names, table.correlation, means, spreads, table.counts)


def rank_observation(
    observation: Observation,
    known: Knowledge,
    weights: Weights,
    *,
    complaint: Complaint | None = None,
    faults: Collection[int] = (),
    ignition_only: bool = False,
) -> Ranking:
    """Return the causes for what was seen."""
    table = with_own_causes(weights.table, known)
    doubts = (ORIGIN, *((_IGNITION_ONLY,) if ignition_only else ()))
    not_seen = missing(observation.deviations)
    if len(observation.deviations) < LEAST or not observation.ran:
        text = _TOO_LITTLE if observation.ran or not observation.deviations else _STOOD
        return Ranking(
            Verdict.CANNOT_TELL, text, (), proposals(None, observation.deviations, table, known),
            not_seen, doubts, observation.seconds,
        )  # fmt: skip
    before = _weights_beforehand(known, table, complaint, faults)
    judged = judge(observation.deviations, table, before)
    strange = judged.best.distance > STRANGE
    causes = _ranked(judged, observation, known, weights, strange)
    verdict, text = _verdict(judged, causes, strange, not_seen)
    if verdict is Verdict.SOUND:
        causes = ()
    return Ranking(
        verdict, text, tuple(causes),
        proposals(judged, observation.deviations, table, known) if verdict is not Verdict.SOUND
        else (),
        not_seen, doubts, observation.seconds,
    )  # fmt: skip


def _ranked(
    judged: Judged, observation: Observation, known: Knowledge, weights: Weights, strange: bool
) -> Sequence[RankedCause]:
    """Return the causes that are possible, the directions of one put together."""
    by_id: dict[str, list[tuple[float, KnownCause]]] = {}
    for name, probability in judged.probability.items():
        by_id.setdefault(known.causes[name].id, []).append((probability, known.causes[name]))
    ranked = []
    for several in by_id.values():
        probability = sum(share for share, _ in several)
        if probability < POSSIBLE:
            continue
        cause = max(several, key=lambda each: each[0])[1]
        explained = Explained(
            judged.model, cause.name, observation.seen, observation.context, observation.sources
        )
        speaks, denies = evidence_of(explained, weights)
        ranked.append(
            RankedCause(
                cause.id,
                cause.variant,
                _likelihood(probability, strange),
                probability,
                cause.text,
                cause.check,
                speaks,
                denies,
                cause.confidence,
                cause.source,
            )
        )
    return sorted(ranked, key=lambda cause: -cause.probability)[:MOST]


def _likelihood(probability: float, strange: bool) -> Likelihood:
    """Return the word: of a car that no hypothesis fits, none is almost certain."""
    if probability >= CERTAIN and not strange:
        return Likelihood.ALMOST_CERTAIN
    return Likelihood.PROBABLE if probability >= PROBABLE else Likelihood.POSSIBLE


def _verdict(
    judged: Judged, causes: Sequence[RankedCause], strange: bool, not_seen: Sequence[Text]
) -> tuple[Verdict, Text]:
    if strange and judged.sound_fit.distance > STRANGE:
        return Verdict.UNKNOWN, _UNKNOWN
    if judged.sound >= max(0.5, *(each.probability for each in causes), 0.0):
        return Verdict.SOUND, _SOUND_SO_FAR if not_seen else _SOUND
    if not causes or (causes[0].probability < 0.3 and judged.sound > 0.15):
        return Verdict.CANNOT_TELL, _UNDECIDED
    return Verdict.CAUSES, _FOUND.filled(cause=causes[0].text)


_SOUND: Final = Text(
    "Nothing speaks against this engine.", "Ничто не говорит о неисправности этого двигателя."
)
_SOUND_SO_FAR: Final = Text(
    "Nothing speaks against this engine, as far as these data show.",
    "По этим данным ничто не говорит о неисправности двигателя.",
)
_FOUND: Final = Text("What was seen speaks for: {cause}.", "Данные говорят за: {cause}.")
_UNKNOWN: Final = Text(
    "Something is off, and no cause known here explains it. The causes below explain a part.",
    "Что-то не так, но ни одна известная здесь причина этого не объясняет. Причины ниже объясняют "
    "лишь часть.",
)
_UNDECIDED: Final = Text(
    "These data don't decide between several causes and a sound engine.",
    "По этим данным нельзя решить между несколькими причинами и исправным двигателем.",
)
_TOO_LITTLE: Final = Text(
    "Can't tell: too little was seen. Record a start, some idle and a drive.",
    "Сказать нельзя: данных мало. Запишите пуск, холостой ход и поездку.",
)
_STOOD: Final = Text("Can't tell: the engine did not run.", "Сказать нельзя: двигатель не работал.")
_IGNITION_ONLY: Final = Text(
    "This unit controls the ignition alone: nothing is known of injection, air meter and idle "
    "valve.",
    "Этот блок управляет только зажиганием: о впрыске, ДМРВ и РДВ (РХХ) данных нет.",
)
