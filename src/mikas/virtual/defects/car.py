"""A car with wear and defects, put into a scenario.

    car = WornCar({"leak": 8.0}, wear_of(seed=3))
    scenario = car.applied_to(SCENARIOS["city"])

Wear changes what the scenario leaves as in a sound car; a defect replaces whatever it says.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from random import Random
from typing import Any

from mikas.virtual.defects.table import DEFECTS, SOUND, Value
from mikas.virtual.scenarios.scenario import Scenario


@dataclass(frozen=True, slots=True)
class WornCar:
    """Defects by key (none: a sound car), and the wear of everything else."""

    defects: Mapping[str, Value] = field(default_factory=dict)
    wear: Mapping[str, float] = field(default_factory=dict)

    def applied_to(self, scenario: Scenario) -> Scenario:
        """Return the scenario with this car in it."""
        changes: dict[bool, dict[str, Any]] = {False: {}, True: {}}
        for key, defect in DEFECTS.items():
            given = scenario.start if defect.of_start else scenario.condition
            if key in self.defects:
                changes[defect.of_start][key] = self.defects[key]
            elif key in self.wear and getattr(given, key) == SOUND[key]:
                changes[defect.of_start][key] = self.wear[key]
        return replace(
            scenario,
            start=replace(scenario.start, **changes[True]),
            condition=replace(scenario.condition, **changes[False]),
        )


def wear_of(seed: object) -> Mapping[str, float]:
    """Return the wear of the sound car with this seed: each value within its range, evenly."""
    chance = Random(f"wear {seed}")
    return {
        key: round(chance.uniform(*defect.wear), 3)
        for key, defect in DEFECTS.items()
        if defect.wear is not None
    }
