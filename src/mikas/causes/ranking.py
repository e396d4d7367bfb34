"""Rank the causes for what was seen of a car.

    ranking = rank([samples_of(times, columns)], complaint=Complaint.IDLES_HIGH)

Each hypothesis (sound, one cause at several amounts, two causes at once) gets a likelihood by the
tables, and a weight beforehand: by the owner's complaint and the stored faults. A hypothesis wins
only if it also fits: what nothing fits is unknown, not the least bad cause.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

from mikas.causes.evidence import Explained, evidence_of
from mikas.causes.features import Seen, View, context_of, features_of
from mikas.causes.judging import (
    Judged,
    JudgingConstants,
    is_sound,
    is_unknown,
    judge,
    may_be_sound,
    suppose,
    weights_beforehand,
    with_own_causes,
)
from mikas.causes.knowledge import Complaint, Knowledge, KnownCause, load
from mikas.causes.measurements import DRIVING, hand_test, missing, proposals
from mikas.causes.model import LikelihoodModel, WeightTable
from mikas.causes.regimes import drive_of, swings
from mikas.causes.result import (
    ORIGIN,
    CauseVerdict,
    Likelihood,
    NextMeasurement,
    RankedCause,
    Ranking,
)
from mikas.causes.samples import Samples
from mikas.causes.weights import Weights, shipped
from mikas.i18n import Text

PROBABLE: Final = 0.55
POSSIBLE: Final = 0.06
MOST: Final = 5
LEAST: Final = 9  # features; with fewer nothing is said
SHORT: Final = 120.0  # s; of less nothing is said to be unknown: too little was seen to know it
LEAST_STANDING: Final = 4  # of an engine that was cranked and did not run


@dataclass(frozen=True, slots=True)
class Observation:
    """What was seen of a car: deviations of sound cars by feature, and where each comes from.

    `swinging`: the speeds between which an idle went up and down that never held; else None.
    """

    deviations: Mapping[str, float]
    seen: Mapping[str, Seen]
    context: Mapping[str, float]
    sources: Mapping[str, int]
    seconds: float
    ran: bool
    swinging: tuple[float, float] | None = None


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
    recordings: Iterable[Samples], weights: Weights, absent: Collection[str] = ()
) -> Observation:
    """Return what was seen in these recordings of one car, each feature put together."""
    observer = Observer(weights)
    for samples in recordings:
        observer.add(samples, absent)
    return observer.observation


class Observer:
    """Puts the features of one car's samples together. Of samples that were added it keeps the
    features alone, so that a long drive can be given in pieces.
    """

    def __init__(self, weights: Weights) -> None:
        self._weights = weights
        self._deviations: dict[str, list[tuple[float, int, Seen]]] = {}
        self._context: Mapping[str, float] | None = None
        self._count = 0
        self._seconds = 0.0
        self._ran = False
        self._swinging: tuple[float, float] | None = None

    def add(self, samples: Samples, absent: Collection[str] = ()) -> None:
        """Add the features of samples; `absent`: as in `rank`."""
        source, self._count = self._count, self._count + 1
        self._seconds += samples.seconds
        served = {n: column for n, column in samples.columns.items() if n not in absent}
        drive = drive_of(Samples(samples.times, served))
        if drive is None:
            return
        self._ran = self._ran or bool(drive.running)
        self._swinging = swings(drive) or self._swinging
        context = context_of(View(drive))
        if self._context is None:
            self._context = context
        found = features_of(drive)
        for name, deviation in self._weights.deviations(found, context).items():
            self._deviations.setdefault(name, []).append((deviation, source, found[name]))

    @property
    def observation(self) -> Observation:
        """What was seen so far."""
        values, seen, sources = {}, {}, {}
        for name, several in self._deviations.items():
            values[name] = sum(each[0] for each in several) / len(several)
            _, sources[name], seen[name] = max(several, key=lambda each: abs(each[0]))
        return Observation(
            values, seen, self._context or {}, sources, self._seconds, self._ran, self._swinging
        )


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
    cranked = "crank-speed" in observation.deviations
    least = LEAST if observation.ran or not cranked else LEAST_STANDING
    if len(observation.deviations) < least or not (observation.ran or cranked):
        return Ranking(
            CauseVerdict.CANNOT_TELL, _too_little(observation), (),
            proposals(
                None, observation.deviations, table, known,
                swinging=observation.swinging is not None,
            ),
            not_seen, doubts, observation.seconds,
        )  # fmt: skip
    before = weights_beforehand(known, table, complaint, faults)
    constants = weights.constants
    model = LikelihoodModel(table, observation.deviations)
    judged = judge(suppose(model, before, constants.unknown_width), constants, weights.usual)
    causes = _ranked(judged, model, observation, known, weights)
    verdict, text = _verdict(judged, causes, constants, not_seen, observation)
    if is_sound(judged, constants):
        causes = ()
    return Ranking(
        verdict, text, tuple(causes),
        () if verdict is CauseVerdict.SOUND and not not_seen
        else _next(judged, causes, observation, table, known),
        not_seen, doubts, observation.seconds,
        something_off=not is_sound(judged, constants) and not may_be_sound(judged, constants),
    )  # fmt: skip


def _next(
    judged: Judged,
    causes: Sequence[RankedCause],
    observation: Observation,
    table: WeightTable,
    known: Knowledge,
) -> tuple[NextMeasurement, ...]:
    """Return a test by hand if there is one, then the measurements of the unit's values."""
    seen = observation.deviations
    if not observation.ran:
        return proposals(judged, seen, table, known, starts=False)
    if (found := hand_test(causes, seen, table, known)) is None:
        return proposals(judged, seen, table, known)
    test, separated = found
    return (test, *proposals(judged, seen, table, known, separated))


def _ranked(
    judged: Judged,
    model: LikelihoodModel,
    observation: Observation,
    known: Knowledge,
    weights: Weights,
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
            model, cause.name, observation.seen, observation.context, observation.sources
        )
        speaks, denies = evidence_of(explained, weights)
        ranked.append(
            RankedCause(
                cause.id,
                cause.variant,
                _likelihood(probability, judged, weights.constants),
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


def _likelihood(probability: float, judged: Judged, constants: JudgingConstants) -> Likelihood:
    """Return the word: none is almost certain of a car that fits worse than the cause's own."""
    if may_be_sound(judged, constants):
        return Likelihood.POSSIBLE
    if probability >= constants.certain and judged.oddness <= constants.close:
        return Likelihood.ALMOST_CERTAIN
    return Likelihood.PROBABLE if probability >= PROBABLE else Likelihood.POSSIBLE


def _verdict(
    judged: Judged,
    causes: Sequence[RankedCause],
    constants: JudgingConstants,
    not_seen: Sequence[Text],
    observation: Observation,
) -> tuple[CauseVerdict, Text]:
    verdict, text = _verdict_of_running(judged, causes, constants, not_seen, observation.seconds)
    if verdict is CauseVerdict.CANNOT_TELL and not observation.ran:
        return verdict, _NOT_STARTED  # who can't start it can't drive it
    return verdict, text


def _too_little(observation: Observation) -> Text:
    if observation.swinging is not None:
        low, high = (f"{round(rpm, -1):.0f}" for rpm in observation.swinging)
        return _SWINGS.filled(low=low, high=high)
    return _TOO_LITTLE if observation.ran or not observation.deviations else _STOOD


def _verdict_of_running(
    judged: Judged,
    causes: Sequence[RankedCause],
    constants: JudgingConstants,
    not_seen: Sequence[Text],
    seconds: float,
) -> tuple[CauseVerdict, Text]:
    if is_sound(judged, constants):
        if DRIVING in not_seen:
            return CauseVerdict.CANNOT_TELL, _DRIVE_IT
        return CauseVerdict.SOUND, _SOUND_SO_FAR if not_seen else _SOUND
    undecided = _UNDECIDED_DRIVE_IT if DRIVING in not_seen else _UNDECIDED
    if may_be_sound(judged, constants):
        return CauseVerdict.CANNOT_TELL, undecided
    if is_unknown(judged, causes[0].probability if causes else 0.0, constants):
        if seconds < SHORT:
            return CauseVerdict.CANNOT_TELL, _SEVERAL_DRIVE_IT
        text = _A_PART.filled(cause=causes[0].text) if causes else _UNKNOWN
        return CauseVerdict.UNKNOWN, text
    if not causes or causes[0].probability < constants.named:
        return CauseVerdict.CANNOT_TELL, _SEVERAL_DRIVE_IT if DRIVING in not_seen else _SEVERAL
    return CauseVerdict.CAUSES, _FOUND.filled(cause=causes[0].text)


_SOUND: Final = Text(
    "Nothing speaks against this engine.", "Ничто не говорит о неисправности этого двигателя."
)
_SOUND_SO_FAR: Final = Text(
    "Nothing speaks against this engine, as far as these data show.",
    "По этим данным ничто не говорит о неисправности двигателя.",
)
_DRIVE_IT: Final = Text(
    "Nothing speaks against this engine so far, but it was not driven: drive it.",
    "Пока ничто не говорит о неисправности, но езды в данных нет: нужна поездка.",
)
_FOUND: Final = Text("What was seen speaks for: {cause}.", "Данные говорят за: {cause}.")
_UNKNOWN: Final = Text(
    "Something is off, and no cause known here explains it.",
    "Что-то не так, но ни одна известная здесь причина этого не объясняет.",
)
_A_PART: Final = Text(
    "Something is off, and no cause known here explains all of it; the causes below explain a "
    "part. The likeliest of them: {cause}.",
    "Что-то не так; целиком этого не объясняет ни одна известная здесь причина, причины ниже "
    "объясняют часть. Вероятнее других: {cause}.",
)
_UNDECIDED: Final = Text(
    "These data don't decide between several causes and a sound engine.",
    "По этим данным нельзя решить между несколькими причинами и исправным двигателем.",
)
_UNDECIDED_DRIVE_IT: Final = Text(
    "These data don't decide between several causes and a sound engine: drive it.",
    "По этим данным нельзя решить между несколькими причинами и исправным двигателем: нужна "
    "поездка.",
)
_SEVERAL: Final = Text(
    "Something is off; these data don't decide between several causes.",
    "Что-то не так; по этим данным нельзя выбрать между несколькими причинами.",
)
_SEVERAL_DRIVE_IT: Final = Text(
    "Something is off; these data don't decide between several causes: drive it.",
    "Что-то не так; по этим данным нельзя выбрать между несколькими причинами: нужна поездка.",
)
_TOO_LITTLE: Final = Text(
    "Can't tell: too little was seen. Record a start, some idle and a drive.",
    "Сказать нельзя: данных мало. Запишите пуск, холостой ход и поездку.",
)
_SWINGS: Final = Text(
    "Can't tell yet: with the throttle closed the speed swings from {low} to {high} rpm, and is "
    "never steady enough to be compared with a sound engine's idle. The idle test looks into it.",
    "Пока сказать нельзя: при закрытом дросселе обороты плавают от {low} до {high} об/мин, и "
    "сравнить их с холостым ходом исправной машины нельзя. Причину ищет проверка холостого хода.",
)
_NOT_STARTED: Final = Text(
    "The engine was cranked and did not run; these data don't decide why.",
    "Двигатель прокручивали, но он не заработал; почему — по этим данным не решить.",
)
_STOOD: Final = Text("Can't tell: the engine did not run.", "Сказать нельзя: двигатель не работал.")
_IGNITION_ONLY: Final = Text(
    "This unit controls the ignition alone: nothing is known of injection, air meter and idle "
    "valve.",
    "Этот блок управляет только зажиганием: о впрыске, ДМРВ и РДВ (РХХ) данных нет.",
)
