"""Weigh the features of simulated cars: how sound ones vary, how each defect moves them.

All numbers of the tables in `src/mikas/causes/weights` come from here, none by hand.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from mikas.causes.features import BY_NAME as FEATURES
from mikas.causes.features.words import feature_texts
from mikas.causes.knowledge import load
from mikas.causes.model import KNOTS, squeezed

KNOWN: Final = load()
Floats = NDArray[np.float64]

FEWEST: Final = 12  # cars that a mean at a knot is made of, with those of its neighbours
TIGHT: Final = 1.0  # of a sound car's spread: residuals of few cars are not believed to be less
SURE: Final = 16.0  # of a chi-square with four degrees of freedom
STEPS: Final = {
    # the least that a feature can differ by, where all sound cars show the same
    "rest-air": 0.15, "stalls": 0.4, "no-air": 0.5, "hidden-throttle": 0.5, "throttle-jumps": 0.5,
    "least-throttle": 0.5, "idle-throttle": 0.5, "flat-top": 0.15, "knock": 0.5, "retard": 0.15,
    "most-retard": 1.0, "valve-lag": 1.5, "voltage-idle": 0.1, "voltage-driven": 0.1,
    "voltage-driven-high": 0.1, "idle-speed": 10.0, "idle-hunting": 15.0,
    "cold-idle-hunting": 20.0, "idle-advance": 0.5, "trim-idle": 2.0, "trim-light": 2.0,
    "trim-heavy": 2.0, "trim-difference": 2.0, "coolant-driven": 1.0, "coolant-most": 1.0,
    "coolant-range": 1.0, "coolant-rise": 1.0, "voltage-driven-spread": 0.1, "voltage-fall": 0.1,
    "voltage-held": 0.1,
    "coolant-drop": 1.0, "air-below-set": 0.3, "cold-idle-speed": 30.0, "widest-throttle": 3.0,
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class Example:
    """A car that was simulated: its defects with amounts, what was seen of it."""

    defects: Mapping[str, float]
    values: Mapping[str, float]
    context: Mapping[str, float]


@dataclass(frozen=True, slots=True)
class Weights:
    """What the tables hold. `means[cause]`: a row a knot, a column a feature."""

    names: Sequence[str]
    slope: Floats
    about: Floats
    middle: Floats
    scale: Floats
    correlation: Floats
    means: Mapping[str, Floats]
    spreads: Mapping[str, Floats]
    counts: Mapping[str, Floats]


def weigh(examples: Sequence[Example], causes: Sequence[str]) -> Weights:
    """Return the weights of these cars."""
    names = list(FEATURES)
    raw = np.array([[each.values.get(name, np.nan) for name in names] for each in examples])
    sound = np.array([not each.defects for each in examples])
    slope, about = np.zeros(len(names)), np.zeros(len(names))
    for index, name in enumerate(names):
        context = FEATURES[name].context
        if not context:
            continue
        x = np.array([each.context.get(context, np.nan) for each in examples])
        fit = sound & np.isfinite(x) & np.isfinite(raw[:, index])
        if fit.sum() < 20:
            continue
        about[index] = x[fit].mean()
        slope[index] = _robust_slope(x[fit] - about[index], raw[fit, index])
        moved = np.where(np.isfinite(x), slope[index] * (x - about[index]), 0.0)
        raw[:, index] -= moved
    middle = np.nanmedian(raw[sound], axis=0)
    wide = np.nanpercentile(raw[sound], 84, axis=0) - np.nanpercentile(raw[sound], 16, axis=0)
    floor = np.array([STEPS.get(name, 0.0) for name in names])
    scale = np.maximum.reduce([wide / 2, floor, np.full(len(names), 1e-3)])
    table = np.vectorize(squeezed)((raw - middle) / scale)
    own = np.sqrt(np.nanmean(table[sound] ** 2, axis=0))
    means, spreads, counts = {}, {}, {}
    untouched = table.copy()
    spreads["sound"] = np.maximum(own, 0.5)
    for cause in causes:
        chosen = np.array([list(each.defects) == [cause] for each in examples])
        amounts = np.array([each.defects.get(cause, 0.0) for each in examples])[chosen]
        means[cause], spreads[cause], counts[cause] = _curve(
            table[chosen], amounts, spreads["sound"], _movable(cause, names)
        )
        touched = np.abs(means[cause]).max(axis=0) > 0
        untouched[np.ix_(chosen, touched)] = np.nan
    correlation = _correlation(untouched)
    return Weights(names, slope, about, middle, scale, correlation, means, spreads, counts)


def _robust_slope(x: Floats, y: Floats) -> float:
    keep = np.ones(len(x), bool)
    slope = 0.0
    for _ in range(4):
        design = np.stack([x[keep], np.ones(keep.sum())], 1)
        slope, offset = np.linalg.lstsq(design, y[keep], rcond=None)[0]
        off = np.abs(y - slope * x - offset)
        keep = off <= 3 * np.median(off) + 1e-9
    return float(slope)


def _correlation(table: Floats, shrink: float = 0.25) -> Floats:
    """Return the correlations of what no defect moves, drawn towards none."""
    count = table.shape[1]
    result = np.eye(count)
    for a in range(count):
        for b in range(a):
            both = np.isfinite(table[:, a] + table[:, b])
            if both.sum() < 25:
                continue
            x, y = np.clip(table[both, a], -4, 4), np.clip(table[both, b], -4, 4)
            if x.std() > 1e-6 and y.std() > 1e-6:
                value = np.corrcoef(x, y)[0, 1] * (1 - shrink)
                result[a, b] = result[b, a] = value
    low, vectors = np.linalg.eigh(result)
    result = vectors @ np.diag(np.maximum(low, 0.08)) @ vectors.T
    width = np.sqrt(np.diag(result))
    scaled: Floats = result / width / width[:, None]
    return scaled


def _movable(cause: str, names: Sequence[str]) -> Sequence[bool]:
    """Return which features are of the cause's systems: it moves no others."""
    systems = KNOWN.causes[cause].systems
    return [feature_texts()[name].system in systems for name in names]


def _curve(
    table: Floats, amounts: Floats, sound: Floats, movable: Sequence[bool]
) -> tuple[Floats, Floats, Floats]:
    """Return means at the knots, spread around them, and the number of cars, by feature.

    Amount 0 is a sound car: the curve begins at 0.
    """
    knots = np.array([0.0, *KNOTS])
    count = table.shape[1]
    means = np.zeros((len(KNOTS), count))
    spread = sound.copy()
    cars = np.zeros(count)
    for index in range(count):
        known = np.isfinite(table[:, index])
        cars[index] = known.sum()
        if known.sum() < 5 or not movable[index]:
            continue
        y, a = table[known, index], amounts[known]
        basis = np.stack([np.interp(a, knots, hat) for hat in np.eye(len(knots))[1:]], 1)
        # Second differences are small: few cars do not bend the curve.
        bend = np.zeros((len(KNOTS), len(KNOTS)))
        for row in range(len(KNOTS) - 1):
            gaps = np.diff(knots)
            if row > 0:
                bend[row, row - 1] += 1 / gaps[row]
            bend[row, row] -= 1 / gaps[row] + 1 / gaps[row + 1]
            bend[row, row + 1] += 1 / gaps[row + 1]
        design = np.vstack([basis, 0.35 * bend])
        goal = np.concatenate([y, np.zeros(len(KNOTS))])
        fit = np.linalg.lstsq(design, goal, rcond=None)[0]
        off = y - basis @ fit
        if not _matters(y, basis @ fit, sound[index]):
            continue
        prior = 6
        variance = (np.sum(off**2) + prior * sound[index] ** 2) / (known.sum() + prior)
        means[:, index] = fit
        spread[index] = max(np.sqrt(variance), TIGHT * sound[index])
    return means, spread, cars


def _matters(y: Floats, fitted: Floats, sound: float) -> bool:
    """Whether the cause moves the feature, by far more than chance: else it takes no part."""
    gain = float(np.sum(y**2) - np.sum((y - fitted) ** 2)) / max(sound, 0.5) ** 2
    wild = float(np.mean(y**2)) / max(sound, 0.5) ** 2
    return gain > SURE or (wild > 2.5 and len(y) >= 8)
