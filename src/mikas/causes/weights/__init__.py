"""The tables that `make causes` writes: how features vary in sound cars, how causes move them.

`features.csv`, `causes.csv`, `correlations.csv`, `fits.csv` (how well each cause fits its own cars)
and `judging.csv` (constants); lines that begin with # say how they were made. No number here is
written by hand.
"""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from math import isnan
from typing import Final

from mikas.causes.features import BY_NAME, Seen
from mikas.causes.judging import JudgingConstants, UsualFit
from mikas.causes.model import KNOTS, SOUND, WeightTable, squeezed

_FILES: Final = ("features.csv", "causes.csv", "correlations.csv", "fits.csv", "judging.csv")


@dataclass(frozen=True, slots=True)
class FeatureScale:
    """How a feature varies in sound cars. `slope`: with its context, around `about`."""

    slope: float
    about: float
    middle: float
    scale: float
    spread: float

    def due(self, context: float) -> float:
        """Return the usual value in this context; NaN: not known."""
        return self.middle + (0.0 if isnan(context) else self.slope * (context - self.about))

    def deviation(self, value: float, context: float) -> float:
        """Return how far a value is from the usual one, squeezed."""
        return squeezed((value - self.due(context)) / self.scale)


@dataclass(frozen=True, slots=True)
class Weights:
    """All tables. `header`: the lines that say how they were made."""

    scales: Mapping[str, FeatureScale]
    table: WeightTable
    header: Sequence[str]
    constants: JudgingConstants
    usual: Mapping[str, UsualFit]

    def deviations(
        self, seen: Mapping[str, Seen], context: Mapping[str, float]
    ) -> dict[str, float]:
        """Return the deviation of each feature that was seen and has a scale."""
        return {
            name: self.scales[name].deviation(
                feature.value, context.get(BY_NAME[name].context, float("nan"))
            )
            for name, feature in seen.items()
            if name in self.scales
        }


@cache
def shipped() -> Weights:
    """Return the tables of this package."""
    texts = [files(__name__).joinpath(name).read_text("utf-8") for name in _FILES]
    return read(*texts)


def read(features: str, causes: str, correlations: str, fits: str, judging: str) -> Weights:
    """Return the tables of these texts."""
    scales = {row[0]: FeatureScale(*map(float, row[1:])) for row in _rows(features)}
    names = list(scales)
    place = {name: index for index, name in enumerate(names)}
    spreads = {SOUND: [scale.spread for scale in scales.values()]}
    means: dict[str, list[list[float]]] = {}
    counts: dict[str, list[float]] = {}
    for cause, feature, count, *numbers in _rows(causes):
        if cause not in means:
            means[cause] = [[0.0] * len(names) for _ in KNOTS]
            spreads[cause] = list(spreads[SOUND])
            counts[cause] = [0.0] * len(names)
        if feature not in place:
            continue
        for row, number in zip(means[cause], numbers, strict=False):
            row[place[feature]] = float(number)
        spreads[cause][place[feature]] = float(numbers[-1])
        counts[cause][place[feature]] = float(count)
    matrix = [[0.0] * len(names) for _ in names]
    for index in range(len(names)):
        matrix[index][index] = 1.0
    for a, b, value in _rows(correlations):
        matrix[place[a]][place[b]] = matrix[place[b]][place[a]] = float(value)
    header = [line[1:].strip() for line in features.splitlines() if line.startswith("#")]
    usual = {row[0]: UsualFit(*map(float, row[1:])) for row in _rows(fits)}
    constants = JudgingConstants(**{name: float(value) for name, value in _rows(judging)})
    table = WeightTable(names, matrix, means, spreads, counts)
    return Weights(scales, table, header, constants, usual)


def _rows(text: str) -> list[list[str]]:
    lines = [line for line in text.splitlines() if line and not line.startswith("#")]
    return list(csv.reader(lines))[1:]
