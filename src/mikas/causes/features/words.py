"""The words of every feature, and the part of the car that it is of: from `words.toml`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib.resources import files

from mikas.i18n import Text
from mikas.toml import parse


@dataclass(frozen=True, slots=True)
class FeatureText:
    """A feature in words. `seen`: what has to happen to see it; `least`: it is never less."""

    text: Text
    unit: Text
    digits: int
    seen: str
    system: str
    least: float


@cache
def feature_texts() -> Mapping[str, FeatureText]:
    """Return the words of every feature, from `words.toml`."""
    tables = parse(files("mikas.causes.features").joinpath("words.toml").read_text("utf-8"))
    return {
        name: FeatureText(
            Text(**keys["text"]),
            Text(**keys["unit"]),
            int(keys["digits"]),
            keys["seen"],
            keys["system"],
            float(keys.get("least", "-inf")),
        )
        for name, keys in tables.items()
    }
