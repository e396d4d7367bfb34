"""The answer: causes in order, with evidence, doubts and the next measurement."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Any, Final

from mikas.causes.samples import Span
from mikas.i18n import Text
from mikas.json_values import json_of


class CauseVerdict(StrEnum):
    """What the values say in all. `UNKNOWN`: something is off that no known cause explains."""

    SOUND = "sound"
    CAUSES = "causes"
    CANNOT_TELL = "cannot-tell"
    UNKNOWN = "unknown"


class Likelihood(StrEnum):
    """How likely a cause is, in words. The figures behind them: docs/development/causes.md."""

    ALMOST_CERTAIN = "almost-certain"
    PROBABLE = "probable"
    POSSIBLE = "possible"


LIKELIHOODS: Final = {
    Likelihood.ALMOST_CERTAIN: Text("almost certainly", "почти наверняка"),
    Likelihood.PROBABLE: Text("probably", "вероятно"),
    Likelihood.POSSIBLE: Text("possibly", "возможно"),
}
"""Each likelihood in words."""

ORIGIN: Final = Text(
    "Known from a model of the engine and service literature, not from cars.",
    "Известно по модели двигателя и сервисной литературе, а не по машинам.",
)


@dataclass(frozen=True, slots=True)
class Evidence:
    """What speaks for or against a cause. `text`: what was seen, with its value and unit, and what
    sound cars have. `low`, `high`: that range; `spans`: the moments, seconds of the data's clock,
    of the `source`-th recording. `weight`: its strength, in the logarithm of odds.
    """

    feature: str
    text: Text
    value: float
    low: float
    high: float
    spans: tuple[Span, ...]
    weight: float
    source: int = 0

    def as_json(self) -> dict[str, Any]:
        """Return the shape of the command line's contract; `from`, `to`: the longest moment."""
        span = max(self.spans, key=lambda it: it[1] - it[0], default=None)
        return {
            "text": json_of(self.text),
            "from": span[0] if span else None,
            "to": span[1] if span else None,
            "feature": self.feature,
            "value": self.value,
            "low": self.low,
            "high": self.high,
            "recording": self.source,
            "spans": [list(each) for each in self.spans],
        }


@dataclass(frozen=True, slots=True)
class RankedCause:
    """A cause. `id`: the virtual car's key for it; `variant`: its direction, or empty."""

    id: str
    variant: str
    likelihood: Likelihood
    probability: float
    text: Text
    check: Text
    evidence_for: tuple[Evidence, ...]
    evidence_against: tuple[Evidence, ...]
    confidence: str
    source: str

    def as_json(self) -> dict[str, Any]:
        """Return the shape of the command line's contract."""
        return {
            "id": self.id,
            "variant": self.variant,
            "likelihood": self.likelihood,
            "text": json_of(self.text),
            "check": json_of(self.check),
            "for": [each.as_json() for each in self.evidence_for],
            "against": [each.as_json() for each in self.evidence_against],
            "confidence": self.confidence,
            "source": self.source,
        }


@dataclass(frozen=True, slots=True)
class MeasurementOutcome:
    """What may be found, and the cause that speaks for: its id, and its text."""

    text: Text
    cause: str
    means: Text

    def as_json(self) -> dict[str, Any]:
        """Return the shape of the command line's contract."""
        return {
            "text": json_of(self.text),
            "cause": self.cause,
            "means": json_of(self.means),
        }


@dataclass(frozen=True, slots=True)
class NextMeasurement:
    """What to measure next. `test`: a guided test's name, or `drive`, `long-drive`, or `by-hand`:
    with a meter, or a part unplugged; that has its `outcomes`.
    """

    test: str
    guided: bool
    text: Text
    why: Text
    outcomes: tuple[MeasurementOutcome, ...] = ()

    def as_json(self) -> dict[str, Any]:
        """Return the shape of the command line's contract."""
        return {
            "test": self.test,
            "guided": self.guided,
            "text": json_of(self.text),
            "why": json_of(self.why),
            "outcomes": [each.as_json() for each in self.outcomes],
        }


@dataclass(frozen=True, slots=True)
class Ranking:
    """The causes of one car. `text`: the verdict in a sentence. `not_seen`: what the data lack.

    `doubts`: what this unit can't show, and where the knowledge comes from. `something_off`:
    whether no sound car has such values, even if the data don't decide between the causes.
    """

    verdict: CauseVerdict
    text: Text
    causes: tuple[RankedCause, ...]
    next: tuple[NextMeasurement, ...]
    not_seen: tuple[Text, ...]
    doubts: tuple[Text, ...]
    seconds: float
    something_off: bool = False

    def as_json(self) -> dict[str, Any]:
        """Return the shape of the command line's contract."""
        return {
            "verdict": self.verdict,
            "text": json_of(self.text),
            "causes": [each.as_json() for each in self.causes],
            "next": [each.as_json() for each in self.next],
            "not_seen": [json_of(each) for each in self.not_seen],
            "doubts": [json_of(each) for each in self.doubts],
            "seconds": self.seconds,
        }


NO_CAUSES: Final[Sequence[RankedCause]] = ()
