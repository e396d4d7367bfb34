"""Readings as JSON and as text, with the reference range at warm idle."""

from __future__ import annotations

from typing import Any

from mikas.catalog import Derived, Parameter
from mikas.cli.language import current_language, decimal, tr
from mikas.client import Reading
from mikas.sampling.derived import DerivedValue


def as_json(reading: Reading) -> dict[str, Any]:
    """Return `{"value", "unit", "raw", "time"}`: numbers are numbers, flags true or false."""
    return {
        "value": reading.value,
        "unit": reading.unit,
        "raw": reading.raw.hex().upper(),
        "time": round(reading.time, 6),
    }


def shown_value(reading: Reading | DerivedValue) -> str:
    """Return the value with its channel's decimals; a flag as yes or no."""
    if isinstance(reading, DerivedValue):
        return decimal(f"{reading.value:.{reading.channel.decimals}f}")
    if isinstance(reading.value, bool):
        return tr("yes", "да") if reading.value else tr("no", "нет")
    return decimal(f"{reading.value:.{reading.parameter.decimals}f}")


def shown_unit(reading: Reading | DerivedValue) -> str:
    """Return the unit in the current language."""
    if isinstance(reading, DerivedValue):
        return reading.channel.unit_text.to(current_language())
    return reading.parameter.interpretation(reading.interpretation).unit_text.to(current_language())


def reference(parameter: Parameter | Derived) -> str:
    """Return `13 … 16`, the reference range at warm idle; empty without one."""
    if isinstance(parameter, Derived) or parameter.reference is None:
        return ""
    low, high = parameter.reference
    return decimal(f"{low:g} … {high:g}" if high > low else f"{low:g}")


def verdict(reading: Reading) -> str:
    """The reference range; nothing under a reading in which it would not hold."""
    return reference(reading.parameter) if reading.interpretation == "corrected" else ""
