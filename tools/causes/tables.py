"""The weights as the texts of the tables in `src/mikas/causes/weights`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from math import isfinite
from typing import Final

from mikas.causes.judging import JudgingConstants, UsualFit
from mikas.causes.model import KNOTS
from tools.causes.weigh import Weights

FILES: Final = ("features.csv", "causes.csv", "correlations.csv", "fits.csv", "judging.csv")


def texts(
    weights: Weights,
    usual: Mapping[str, UsualFit],
    constants: JudgingConstants,
    header: Sequence[str] = (),
) -> tuple[str, ...]:
    """Return the texts of `FILES`."""
    kept = [i for i, scale in enumerate(weights.scale) if isfinite(scale + weights.middle[i])]
    head = "".join(f"# {line}\n" for line in header)
    features = head + "feature,slope,about,middle,scale,spread\n"
    for i in kept:
        numbers = weights.slope[i], weights.about[i], weights.middle[i], weights.scale[i]
        spread = weights.spreads["sound"][i]
        features += ",".join([weights.names[i], *(f"{n:.6g}" for n in numbers), f"{spread:.3f}"])
        features += "\n"
    causes = head + ",".join(["cause", "feature", "cars", *(f"at {k:g}" for k in KNOTS), "spread"])
    causes += "\n"
    for cause, means in weights.means.items():
        for i in kept:
            if abs(means[:, i]).max() > 0:
                curve = [f"{n:.3f}" for n in means[:, i]]
                row = cause, weights.names[i], f"{weights.counts[cause][i]:.0f}", *curve
                causes += ",".join([*row, f"{weights.spreads[cause][i]:.3f}"]) + "\n"
    correlations = head + "feature,other,correlation\n"
    for i in kept:
        for j in kept:
            if j < i and abs(weights.correlation[i, j]) >= 0.0005:
                pair = weights.names[i], weights.names[j], f"{weights.correlation[i, j]:.3f}"
                correlations += ",".join(pair) + "\n"
    fits = head + "cause,distance,strangest\n"
    for cause, fit in usual.items():
        fits += f"{cause},{fit.distance:.3f},{fit.strangest:.3f}\n"
    judging = head + "name,value\n"
    for name, value in asdict(constants).items():
        judging += f"{name},{value:g}\n"
    return features, causes, correlations, fits, judging
