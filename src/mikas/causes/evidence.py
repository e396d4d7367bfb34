"""Evidence: what speaks for a cause and against it, in words with values."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import exp, log
from typing import Final

from mikas.causes.features import BY_NAME, Seen
from mikas.causes.features.words import feature_texts
from mikas.causes.model import GRID, LikelihoodModel
from mikas.causes.result import Evidence
from mikas.causes.weights import FeatureScale, Weights
from mikas.i18n import Text, joined
from mikas.recording.formatting import digits, joined_unit

FOR: Final = 1.0  # logarithm of odds from which a feature is named
AGAINST: Final = 1.0
MOST: Final = 6
EXPECTED: Final = 2.0  # spreads by which a cause must move a feature that denies it

_LOGARITHMS: Final = frozenset(
    {
        "crank-turns", "stalls", "breathing-spread", "no-air", "hidden-throttle", "throttle-jumps",
        "knock",
    }
)  # fmt: skip
"""Features whose value is log(1 + …) of the shown one."""
_TWICE: Final = frozenset({"no-air", "hidden-throttle", "throttle-jumps"})


@dataclass(frozen=True, slots=True)
class Explained:
    """A cause, and what was seen of the car."""

    model: LikelihoodModel
    cause: str
    seen: Mapping[str, Seen]
    context: Mapping[str, float]
    sources: Mapping[str, int]


def evidence_of(
    explained: Explained, weights: Weights
) -> tuple[tuple[Evidence, ...], tuple[Evidence, ...]]:
    """Return what speaks for the cause and what against it, the strongest first."""
    model, cause = explained.model, explained.cause
    amount = max(GRID, key=lambda each: model.fit((cause,), (each,)).likelihood)
    shift, spread = model.shift(cause, amount), model.spread((cause,))
    sound = model.spread(())
    speaks, denies = [], []
    for place, value, mean, width, plain in zip(
        model.places, model.values, shift, spread, sound, strict=True
    ):
        name = model.table.names[place]
        if mean == 0.0:
            continue
        gain = 0.5 * (value / plain) ** 2 + log(plain)
        gain -= 0.5 * ((value - mean) / width) ** 2 + log(width)
        if gain >= FOR and value * mean > 0:
            speaks.append(_evidence(explained, name, weights.scales[name], gain))
        elif gain <= -AGAINST and abs(mean) >= EXPECTED:
            denies.append(_evidence(explained, name, weights.scales[name], gain))
    speaks.sort(key=lambda each: -each.weight)
    denies.sort(key=lambda each: each.weight)
    return tuple(speaks[:MOST]), tuple(denies[:MOST])


def _evidence(explained: Explained, name: str, scale: FeatureScale, weight: float) -> Evidence:
    seen = explained.seen[name]
    context = explained.context.get(BY_NAME[name].context, float("nan"))
    due = scale.due(context)
    words = feature_texts()[name]
    low, high = (max(words.least, _shown(name, due + sign * 2 * scale.scale)) for sign in (-1, 1))
    ends = digits(low, words.digits), digits(high, words.digits)
    usual = ends[0] if ends[0] == ends[1] else joined(" … ", ends)
    value = joined_unit(digits(seen.shown, words.digits), words.unit)
    text = _SEEN.filled(name=words.text, value=value, usual=usual)
    return Evidence(
        name, text, seen.shown, low, high, seen.spans, weight, explained.sources.get(name, 0)
    )


def _shown(name: str, value: float) -> float:
    """Return a value of the tables as it is shown."""
    if name == "retard":
        return -(exp(max(0.0, -value)) - 1)
    if name not in _LOGARITHMS:
        return value
    plain = exp(max(0.0, value)) - 1
    return plain / 2 if name in _TWICE else plain


_SEEN: Final = Text(
    "{name}: {value} (sound cars: {usual})",
    "{name}: {value} (у исправных: {usual})",
)
