"""What has to be so while the idle mixture is set: warm idle, and a unit that keeps RCOD.

At another speed, or with a cold engine, another mixture would be set.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from mikas.i18n import Text

CHANNEL: Final = "RCOD"
NEEDED: Final = ("FREQ", "TWAT", "THR")
"""The channels that say whether it is warm idle."""
_SPEEDS: Final = (500.0, 1300.0)
_WARM: Final = 70.0
_CLOSED: Final = 5.0


def idle_problems(values: Mapping[str, float]) -> list[Text]:
    """Return why this is no warm idle; empty: it is one."""
    problems: list[Text] = []
    if not _SPEEDS[0] <= values["FREQ"] <= _SPEEDS[1]:
        problems.append(
            Text(
                f"the engine turns at {values['FREQ']:.0f} rpm, not at idle",
                f"обороты {values['FREQ']:.0f}, это не холостой ход",
            )
        )
    if values["TWAT"] < _WARM:
        problems.append(
            Text(
                f"the coolant has {values['TWAT']:.0f} °C, {_WARM:.0f} are needed",
                f"охлаждающая жидкость {values['TWAT']:.0f} °C, нужно {_WARM:.0f}",
            )
        )
    if values["THR"] > _CLOSED:
        problems.append(
            Text(
                f"the throttle is open by {values['THR']:.0f} %",
                f"дроссель открыт на {values['THR']:.0f} %",
            )
        )
    return problems


def not_kept(wrote: str, has: str) -> Text:
    """Return what it means that RCOD is another one than was written."""
    return Text(
        f"RCOD was written as {wrote} and is {has} now: the unit sets it by itself. Where a CO "
        "potentiometer is fitted, turn that.",
        f"В RCOD записано {wrote}, а теперь там {has}: блок задаёт его сам. Если стоит "
        "потенциометр СО, регулируйте им.",
    )
