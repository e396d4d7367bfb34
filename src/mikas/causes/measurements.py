"""What was not seen, and the measurements that separate the leading causes best.

A measurement shows some features (`seen` in `features/words.toml`). Its worth is how far the causes
that are possible now would differ in those of them that were not seen. Where no measurement of the
unit's values separates the leading cause from another, a test by hand may (`[apart.OTHER]` of a
cause's file): a meter at a terminal, a part to unplug.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Final

from mikas.causes.features.words import feature_texts
from mikas.causes.judging import Judged
from mikas.causes.knowledge import HandTest, Knowledge, KnownCause, name_of
from mikas.causes.model import SOUND, WeightTable
from mikas.causes.result import Likelihood, MeasurementOutcome, NextMeasurement, RankedCause
from mikas.i18n import Text, joined

WORTH: Final = 0.02  # of a measurement that is proposed
TWICE: Final = 0.2  # what a feature counts that was seen already: a second look
LIKELY: Final = 0.002  # of a cause that a measurement is to separate
MOST: Final = 2
NAMED: Final = 3  # causes that a measurement is said to separate
APART: Final = 9.0  # the square of a distance in spreads at which two causes are separate
BOTH: Final = 0.06  # how likely two causes at once may be that are to be separated


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
    judged: Judged | None,
    seen: Collection[str],
    table: WeightTable,
    known: Knowledge,
    by_hand: Collection[str] = (),
    *,
    starts: bool = True,
    swinging: bool = False,
) -> tuple[NextMeasurement, ...]:
    """Return the measurements that separate the causes best, each once, the most useful first.

    `by_hand`: two causes that a test by hand separates: these are not said to do so. `starts`:
    whether the engine does; else only what can be done without. `swinging`: its idle never holds.
    """
    if judged is None:
        first = "idle" if swinging else "warmup"
        chosen = [each for each in MEASUREMENTS if each.name in (first, "drive")]
        return tuple(_next(each, _BEGIN) for each in chosen)
    weights = {name: share for name, share in judged.probability.items() if share > LIKELY}
    if judged.sound > LIKELY:
        weights[SOUND] = judged.sound
    rest = set(table.names) - set(seen)
    proposed: list[NextMeasurement] = []
    left = [each for each in MEASUREMENTS if starts or each.name == "cranking"]
    for _ in range(min(MOST, len(left))):
        worth = {m.name: _worth(m, weights, rest, table) for m in left}
        best = max(left, key=lambda m: worth[m.name])
        if worth[best.name] < WORTH:
            break
        left.remove(best)
        pairs = _separated(best, weights, rest, table) - {frozenset(by_hand)}
        proposed.append(_next(best, _why(weights, pairs, known)))
        rest -= _shown(best, rest)
    if not proposed and left and missing(seen):  # no cause leads: nothing is there to be separated
        proposed.append(_next(max(left, key=lambda m: len(_shown(m, rest))), _BEGIN))
    return tuple(proposed)


def hand_test(
    causes: Sequence[RankedCause], seen: Collection[str], table: WeightTable, known: Knowledge
) -> tuple[NextMeasurement, tuple[str, str]] | None:
    """Return the test by hand of the leading cause and another that the unit's values, seen and
    unseen, don't separate, with their names; None if there is no need or no such test.
    """
    if not causes or causes[0].likelihood is Likelihood.ALMOST_CERTAIN:
        return None
    leading, *others = (known.causes[name_of(each.id, each.variant)] for each in causes)
    rest = set(table.names) - set(seen)
    for place, other in enumerate(others, 1):
        if causes[0].probability + causes[place].probability > 1 + BOTH:
            continue  # perhaps both at once
        if _separable(leading.name, other.name, rest, table):
            continue
        for one, two in ((leading, other), (other, leading)):
            test = one.apart_from(two)
            if test is not None:
                return _hand_measurement(test, one, two), (one.name, two.name)
    return None


def _separable(one: str, other: str, rest: Collection[str], table: WeightTable) -> bool:
    """Whether a measurement of values that were not seen separates two causes."""
    return any(
        apart >= APART
        for measurement in MEASUREMENTS
        for *_, apart in _distances(measurement, (one, other), rest, table, twice=0)
    )


def _hand_measurement(test: HandTest, one: KnownCause, two: KnownCause) -> NextMeasurement:
    outcomes = (
        MeasurementOutcome(test.this, one.id, one.text),
        MeasurementOutcome(test.other, two.id, two.text),
    )
    why = _BY_HAND.filled(causes=joined("; ", (one.text, two.text)))
    return NextMeasurement("by-hand", False, test.do, why, outcomes)


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
    return sum(
        weights[one] * weights[other] * min(1.0, apart / APART)
        for one, other, apart in _distances(measurement, weights, rest, table)
    )


def _distances(
    measurement: Measurement,
    causes: Iterable[str],
    rest: Collection[str],
    table: WeightTable,
    twice: float = TWICE,
) -> Iterator[tuple[str, str, float]]:
    """Yield each two causes with the square of their distance in what a measurement shows.

    `rest`: the features that were not seen; `twice`: how much another one counts, measured again.
    """
    counts = [
        (place, 1.0 if name in rest else twice)
        for place, name in enumerate(table.names)
        if feature_texts()[name].seen in measurement.shows
    ]
    for one, other in combinations(causes, 2):
        apart = sum(
            count * (_effect(table, one, p) - _effect(table, other, p)) ** 2 for p, count in counts
        )
        yield one, other, apart


def _separated(
    measurement: Measurement,
    causes: Iterable[str],
    rest: Collection[str],
    table: WeightTable,
) -> set[frozenset[str]]:
    """Return the pairs of causes that a measurement separates."""
    distances = _distances(measurement, causes, rest, table)
    return {frozenset((one, other)) for one, other, apart in distances if apart >= APART}


def _why(weights: Mapping[str, float], pairs: Collection[frozenset[str]], known: Knowledge) -> Text:
    """Return between what a measurement decides: the likeliest causes, each two of them a pair."""
    apart = [cause for cause in weights if any(cause in pair for pair in pairs)]
    named: list[str] = []
    for cause in sorted(apart or weights, key=lambda name: -weights[name]):
        if cause in known.causes and all(frozenset((cause, it)) in pairs for it in named):
            named.append(cause)
    texts = [known.causes[cause].text for cause in named[:NAMED]]
    if len(texts) < 2:
        return _CONFIRM.filled(cause=texts[0]) if texts else _BEGIN
    return _SEPARATES.filled(causes=joined("; ", texts))


def _next(measurement: Measurement, why: Text) -> NextMeasurement:
    return NextMeasurement(measurement.name, measurement.guided, measurement.text, why)


_BEGIN: Final = Text("It shows most of what is missing.", "Это даст большую часть недостающего.")
_SEPARATES: Final = Text("It separates: {causes}.", "Это позволит различить: {causes}.")
_BY_HAND: Final = Text(
    "The unit's values don't separate these: {causes}.",
    "По данным блока эти причины не различить: {causes}.",
)
_CONFIRM: Final = Text(
    "It confirms or denies: {cause}.", "Это подтвердит или опровергнет: {cause}."
)
