"""Units that control the ignition alone: a 5.4 of a carburettor engine has no injectors and no air
meter, and answers the channels of these with zeros. Found out from the values: the engine runs, and
injection and air flow are zero in all readings.

One of the two alone may be a fault: fuel is cut on overrun, and an air meter may have no contact.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Final

from mikas.i18n import Text

if TYPE_CHECKING:
    from mikas.catalog.lookup import Catalog

DEAD: Final = frozenset(
    ("INJ", "JAIR", "JQT", "VALF", "RCOK", "RCOD", "SSM", "FSM", "UGB")
)  # fmt: skip
"""Channels that mean nothing on such a unit: of injection, mixture, air meter and idle valve."""

WITNESSES: Final = ("INJ", "JAIR")
"""The channels that are zero while the engine runs."""

SPEED: Final = "FREQ"
RUNNING: Final = 500.0  # rpm
SAID: Final = Text(
    "This unit controls the ignition alone (a carburettor engine): injection and air flow are zero "
    "while the engine runs, so nothing of injection, mixture, air meter and idle valve is judged.",
    "Этот блок управляет только зажиганием (карбюраторный двигатель): впрыск и расход воздуха на "
    "работающем двигателе нулевые, поэтому впрыск, смесь, ДМРВ и РДВ не оцениваются.",
)
_FEWEST: Final = 20  # readings of each


def is_absent(name: str, catalog: Catalog) -> bool:
    """Return whether a channel means nothing on such a unit, or is computed from such a one."""
    return not DEAD.isdisjoint(catalog.required_by([name]))


def absent_channels(catalog: Catalog) -> tuple[str, ...]:
    """Return all channels of the catalog that mean nothing on such a unit, in its order."""
    return tuple(name for name in catalog.channels if is_absent(name, catalog))


class InjectionWatch:
    """Counts the readings of a running engine, and those with injection or air flow."""

    def __init__(self) -> None:
        self._readings = dict.fromkeys(WITNESSES, 0)
        self.is_alive: bool = False
        """Whether a witness was not zero: then this unit is none, whatever follows."""
        self._rpm = 0.0

    def add_row(self, values: Mapping[str, float]) -> None:
        """Take the values that were read at one time."""
        self._rpm = values.get(SPEED, self._rpm)
        if self._rpm < RUNNING:
            return
        for name in WITNESSES:
            if name in values:
                self.count(name, 1, is_alive=values[name] != 0)

    def count(self, name: str, readings: int, *, is_alive: bool) -> None:
        """Count readings of a witness while the engine ran; `is_alive`: one was not zero."""
        self._readings[name] += readings
        self.is_alive |= is_alive

    @property
    def ignition_only(self) -> bool:
        """Whether the unit controls the ignition alone; false while that is not certain."""
        return not self.is_alive and min(self._readings.values()) >= _FEWEST
