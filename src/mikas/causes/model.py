"""The model: how probable what was seen is in a sound car, and with each defect at each amount.

Each feature is measured in spreads of sound cars, far values squeezed (`squeezed`). A defect moves
the means by its amount (`KNOTS`) and has its own spreads; how features vary together is taken from
sound cars. What was not seen takes no part. Pure Python: the page computes the same.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from math import asinh, exp, log, sinh, sqrt
from operator import mul
from typing import Final

KNOTS: Final = (0.45, 0.8, 1.2, 1.8)
"""Amounts, in noticeable ones, at which the tables have means."""

GRID: Final = (0.45, 0.62, 0.8, 1.0, 1.2, 1.5, 1.8, 2.4, 3.4)
SOUND: Final = "sound"
FREEDOM: Final = 14.0  # degrees of freedom: far tails, since the world differs from the table
WEIGHT: Final = 2.0

Row = Sequence[float]


def squeezed(z: float) -> float:
    """Return a deviation in spreads, the far ones drawn together: 3 is 2.6, 100 is 12.6."""
    return 3.0 * asinh(z / 3.0)


def plain(squeezed_z: float) -> float:
    """Return the deviation of a squeezed one."""
    return 3.0 * sinh(squeezed_z / 3.0)


@dataclass(frozen=True, slots=True)
class WeightTable:
    """The weights, by the place of a feature in `names`."""

    names: Sequence[str]
    correlation: Sequence[Row]
    means: Mapping[str, Sequence[Row]]
    spreads: Mapping[str, Row]
    counts: Mapping[str, Row]
    systems: Mapping[str, frozenset[str]] = field(default_factory=dict)  # that a cause may move


@dataclass(frozen=True, slots=True)
class Fit:
    """How well a hypothesis fits. `distance`: squared, a feature; 1 is usual for its own cars."""

    causes: tuple[str, ...]
    amounts: tuple[float, ...]
    likelihood: float  # logarithm
    distance: float
    count: int  # of features
    strangest: float  # the largest deviation that is left, in the hypothesis' spreads


class LikelihoodModel:
    """The model for what was seen of one car. `seen`: squeezed deviations by feature."""

    def __init__(self, table: WeightTable, seen: Mapping[str, float]) -> None:
        self.table = table
        self.places: list[int] = [place for place, name in enumerate(table.names) if name in seen]
        self.values: list[float] = [seen[table.names[place]] for place in self.places]
        self._factor = _cholesky(
            [[table.correlation[a][b] for b in self.places] for a in self.places]
        )

    def shift(self, cause: str, amount: float) -> list[float]:
        """Return the means that a defect of this amount gives, of what was seen.

        Beyond the last knot they go on in proportion.
        """
        means = self.table.means[cause]
        if amount > KNOTS[-1]:
            share = amount / KNOTS[-1]
            return [squeezed(share * plain(means[-1][place])) for place in self.places]
        for index, knot in enumerate(KNOTS):
            if amount <= knot:
                low = KNOTS[index - 1] if index else 0.0
                share = (amount - low) / (knot - low)
                if index == 0:
                    return [share * means[0][place] for place in self.places]
                before, after = means[index - 1], means[index]
                return [
                    before[place] + share * (after[place] - before[place]) for place in self.places
                ]
        raise AssertionError("there are knots")

    def spread(self, causes: Sequence[str]) -> list[float]:
        """Return the spreads with these defects: the widest of them."""
        rows = [self.table.spreads[cause] for cause in causes or (SOUND,)]
        return [max(row[place] for row in rows) for place in self.places]

    def fit(self, causes: tuple[str, ...], amounts: tuple[float, ...]) -> Fit:
        """Return how well these defects with these amounts fit what was seen."""
        shifts = [self.shift(c, a) for c, a in zip(causes, amounts, strict=True)]
        means = [sum(column) for column in zip(*shifts, strict=True)] if shifts else None
        return self.fit_means(causes, amounts, means or [0.0] * len(self.places))

    def fit_means(
        self, causes: tuple[str, ...], amounts: tuple[float, ...], means: Sequence[float]
    ) -> Fit:
        """Return how well these means fit."""
        return self._fit(causes, amounts, means, self.spread(causes))

    def fit_unknown(self, moved: Sequence[bool], width: float) -> Fit:
        """Return how well a defect fits that moves these of what was seen, by about `width`."""
        spread = [
            sqrt(plain * plain + width * width) if wide else plain
            for plain, wide in zip(self.spread(()), moved, strict=True)
        ]
        return self._fit((), (), [0.0] * len(spread), spread)

    def _fit(
        self,
        causes: tuple[str, ...],
        amounts: tuple[float, ...],
        means: Sequence[float],
        spread: Sequence[float],
    ) -> Fit:
        off = [
            (value - mean) / width
            for value, mean, width in zip(self.values, means, spread, strict=True)
        ]
        squares = _length(self._factor, off)
        count = len(off)
        likelihood = -0.5 * (FREEDOM + count) * log(1 + squares / FREEDOM)
        likelihood -= sum(log(width) for width in spread)
        strangest = max((abs(each) for each in off), default=0.0)
        return Fit(causes, amounts, likelihood, squares / max(1, count), count, strangest)


def _cholesky(matrix: Sequence[Row]) -> list[list[float]]:
    lower: list[list[float]] = []
    for i, row in enumerate(matrix):
        line: list[float] = []
        for j in range(i):
            other = lower[j]
            line.append((row[j] - sum(a * b for a, b in zip(line, other, strict=False))) / other[j])
        line.append(sqrt(max(1e-6, row[i] - sum(a * a for a in line))))
        lower.append(line)
    return lower


def _length(lower: Sequence[Sequence[float]], off: Sequence[float]) -> float:
    solved: list[float] = []
    total = 0.0
    for line, value in zip(lower, off, strict=True):
        y = (value - sum(map(mul, line, solved))) / line[-1]
        solved.append(y)
        total += y * y
    return total


def log_sum(values: Sequence[float]) -> float:
    """Return the logarithm of the sum of exponentials."""
    top = max(values)
    return top + log(sum(exp(value - top) for value in values))
