"""The measures that are compared between the cars and followed over time: one figure of each drive.

`least`: the smallest difference that counts, whatever the statistics say. With a normal range it is
half of its width; the others are the smallest that a mechanic would act on.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

from mikas.catalog import Catalog, Parameter
from mikas.fleet.states import DriveState
from mikas.i18n import Text


@dataclass(frozen=True, slots=True)
class CarMeasure:
    """The median of a channel in a state, of a drive. `text`: inside a sentence."""

    key: str
    name: str
    state: DriveState
    least: float
    text: Text
    title: Text

    def channel(self, catalog: Catalog) -> Parameter:
        """Return the channel; with its normal range where that applies: at warm idle."""
        found = catalog.parameter(self.name)
        return found if self.state is DriveState.WARM_IDLE else replace(found, reference=None)


def _measure(  # noqa: PLR0917  (a row of the table below)
    key: str, name: str, state: DriveState, least: float, text: tuple[str, str], at: tuple[str, str]
) -> CarMeasure:
    whole = Text(f"{text[0]} {at[0]}", f"{text[1]} {at[1]}")
    title = Text(*(f"{words[:1].upper()}{words[1:]}" for words in whole))
    return CarMeasure(key, name, state, least, whole, title)


_IDLE: Final = ("at warm idle", "на прогретом холостом ходу")

MEASURES: Final = (
    _measure("idle_voltage", "UACC", DriveState.WARM_IDLE, 0.5,
             ("battery voltage", "напряжение бортсети"), _IDLE),
    _measure("charging", "UACC", DriveState.ABOVE_IDLE, 0.5,
             ("battery voltage", "напряжение бортсети"), ("above 1500 rpm", "выше 1500 об/мин")),
    _measure("coolant", "TWAT", DriveState.WARMED_UP, 7.5,
             ("coolant temperature", "температура ОЖ"),
             ("after ten minutes of running", "после десяти минут работы")),
    _measure("idle_air", "JAIR", DriveState.WARM_IDLE, 1.5, ("air flow", "расход воздуха"), _IDLE),
    _measure("idle_injection", "INJ", DriveState.WARM_IDLE, 0.75,
             ("injection pulse", "длительность впрыска"), _IDLE),
    _measure("idle_valve", "FSM", DriveState.WARM_IDLE, 10,
             ("idle valve position", "положение РДВ (РХХ)"), _IDLE),
    _measure("idle_advance", "UOZ", DriveState.WARM_IDLE, 3, ("ignition advance", "УОЗ"), _IDLE),
    _measure("idle_speed", "FREQ", DriveState.WARM_IDLE, 50, ("speed", "обороты"), _IDLE),
)  # fmt: skip
"""In the order of the page."""
