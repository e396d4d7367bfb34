"""What was not seen, and the measurements that separate the leading causes best.

A measurement shows some features (`seen` in `features/words.toml`). Its worth is how far the causes
that are possible now would differ in those of them that were not seen.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Final

from mikas.causes.features.words import feature_texts
from mikas.causes.judging import Judged
from mikas.causes.knowledge import Knowledge
from mikas.causes.model import SOUND, WeightTable
from mikas.causes.result import NextMeasurement
from mikas.i18n import Text, joined

WORTH: Final = 0.02  # of a measurement that is proposed
TWICE: Final = 0.2  # what a feature counts that was seen already: a second look
LIKELY: Final = 0.002  # of a cause that a measurement is to separate
MOST: Final = 2


@dataclass(frozen=True, slots=True)
class Measurement:
    """Something to do with the car. `shows`: kinds of features; `guided`: a guided test's name."""

    name: str
    guided: bool
    shows: frozenset[str]
    text: Text


MEASUREMENTS: Final = (
    Measurement(
        "cranking", True, frozenset({"start"}),
        Text("Start the engine while recording (guided test “Cranking”).",
             "Запустите двигатель под запись (проверка «Прокрутка стартером»)."),
    ),
    Measurement(
        "idle", True, frozenset({"idle"}),
        Text("Let the warm engine idle for two minutes (guided test “Idle stability”).",
             "Дайте прогретому двигателю две минуты поработать на холостом ходу (проверка "
             "«Устойчивость холостого хода»)."),
    ),
    Measurement(
        "warmup", True, frozenset({"start", "cold-start", "cold-idle", "idle"}),
        Text("Record a start in the morning, cold, until the engine is warm (guided test “Warm-up "
             "and thermostat”).",
             "Запишите утренний пуск холодного двигателя до прогрева (проверка «Прогрев и "
             "термостат»)."),
    ),
    Measurement(
        "drive", False, frozenset({"start", "drive", "idle"}),
        Text("Record a start and ten minutes of driving: town, open road, stops.",
             "Запишите пуск и десять минут езды: город, трасса, остановки."),
    ),
    Measurement(
        "knock", True, frozenset({"pull", "drive"}),
        Text("Record a pull in third gear with the pedal to the floor (guided test “Ignition and "
             "knock”).",
             "Запишите разгон на третьей передаче с педалью в пол (проверка «Зажигание и "
             "детонация»)."),
    ),
    Measurement(
        "long-drive", False, frozenset({"long-drive", "drive", "idle"}),
        Text("Record twenty minutes of driving with a warm engine, then two minutes of idle.",
             "Запишите двадцать минут езды на прогретом двигателе, затем две минуты холостого "
             "хода."),
    ),
)  # fmt: skip

_MISSING: Final[Mapping[str, Text]] = {
    "start": Text("a start", "пуск"),
    "cold-start": Text("a cold start", "пуск холодного двигателя"),
    "cold-idle": Text("cold idle", "холостой ход непрогретого двигателя"),
    "idle": Text("warm idle", "холостой ход прогретого двигателя"),
    "drive": Text("driving", "движение"),
    "pull": Text("full load", "полная нагрузка"),
    "long-drive": Text("a long warm drive", "долгая езда на прогретом двигателе"),
}


DRIVING: Final = _MISSING["drive"]


def missing(seen: Collection[str]) -> tuple[Text, ...]:
    """Return the kinds of driving of which less than half of the features was seen."""
    counts: dict[str, list[bool]] = {}
    for name, words in feature_texts().items():
        counts.setdefault(words.seen, []).append(name in seen)
    return tuple(_MISSING[kind] for kind in _MISSING if sum(counts[kind]) * 2 < len(counts[kind]))


def proposals(
    judged: Judged | None, seen: Collection[str], table: WeightTable, known: Knowledge
) -> tuple[NextMeasurement, ...]:
    """Return the measurements that separate the causes best, each once, the most useful first."""
    if judged is None:
        chosen = [each for each in MEASUREMENTS if each.name in ("warmup", "drive")]
        return tuple(_next(each, _BEGIN) for each in chosen)
    weights = {name: share for name, share in judged.probability.items() if share > LIKELY}
    if judged.sound > LIKELY:
        weights[SOUND] = judged.sound
    rest = set(table.names) - set(seen)
    proposed: list[NextMeasurement] = []
    left = list(MEASUREMENTS)
    for _ in range(MOST):
        worth = {m.name: _worth(m, weights, rest, table) for m in left}
        best = max(left, key=lambda m: worth[m.name])
        if worth[best.name] < WORTH:
            break
        left.remove(best)
        proposed.append(_next(best, _why(weights, known)))
        rest -= _shown(best, rest)
    if not proposed and missing(seen):  # no cause leads: nothing is there to be separated
        proposed.append(_next(max(left, key=lambda m: len(_shown(m, rest))), _BEGIN))
    return tuple(proposed)


def _shown(measurement: Measurement, features: Collection[str]) -> set[str]:
    return {name for name in features if feature_texts()[name].seen in measurement.shows}


def _effect(table: WeightTable, cause: str, place: int) -> float:
    return 0.0 if cause == SOUND else table.means[cause][2][place]


def _worth(
    measurement: Measurement,
    weights: Mapping[str, float],
    rest: Collection[str],
    table: WeightTable,
) -> float:
    counts = [
        (place, 1.0 if name in rest else TWICE)
        for place, name in enumerate(table.names)
        if feature_texts()[name].seen in measurement.shows
    ]
    total = 0.0
    causes = list(weights)
    for index, one in enumerate(causes):
        for other in causes[:index]:
            apart = sum(
                count * (_effect(table, one, p) - _effect(table, other, p)) ** 2
                for p, count in counts
            )
            total += weights[one] * weights[other] * min(1.0, apart / 9.0)
    return total


def _why(weights: Mapping[str, float], known: Knowledge) -> Text:
    """Return between what a measurement decides."""
    ordered = [
        known.causes[cause].text
        for cause in sorted(weights, key=lambda name: -weights[name])[:3]
        if cause in known.causes
    ]
    if len(ordered) < 2:
        return _CONFIRM.filled(cause=ordered[0]) if ordered else _BEGIN
    return _SEPARATES.filled(causes=joined("; ", ordered))


def _next(measurement: Measurement, why: Text) -> NextMeasurement:
    return NextMeasurement(measurement.name, measurement.guided, measurement.text, why)


_BEGIN: Final = Text("It shows most of what is missing.", "Она даст большую часть недостающего.")
_SEPARATES: Final = Text("It separates: {causes}.", "Она различит: {causes}.")
_CONFIRM: Final = Text(
    "It confirms or denies: {cause}.", "Она подтвердит или опровергнет: {cause}."
)
