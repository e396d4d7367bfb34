"""One step of a survey, and the state that the car has to be in for it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from typing import Any

from mikas.i18n import Text
from mikas.survey.person import Prompter
from mikas.survey.unit import SurveyedUnit

Measured = dict[str, Any]
"""The figures measured so far, as JSON values."""
Measure = Callable[[SurveyedUnit, Measured, Prompter], None]


class CarState(Enum):
    """The state of the car in a part of the survey, in their order."""

    STANDING = "standing"
    """Ignition on, engine off."""
    STARTING = "starting"
    """The starter turns, the engine starts."""
    IDLE = "idle"
    """The engine idles, cold or warm."""
    WARM = "warm"
    """The engine idles warm."""
    RAISED = "raised"
    """The engine is held at a raised speed."""
    AFTER = "after"
    """The engine idles again."""


@dataclass(frozen=True, slots=True)
class SurveyStep:
    """One step: what it measures, in which state of the car."""

    name: str
    """The step's name, kept once it is done."""
    state: CarState
    """The state that the car has to be in."""
    title: Text
    """What it does, for the person."""
    measure: Measure
    """Measures, and adds the figures."""
    keeps: bool = False
    """Whether its figures hold though the car left the state meanwhile."""
