"""The idle mixture set by a gas analyser or a λ meter: which RCOD to write next, and when to stop.

    figure of the meter ──► CoSetting.next ──► in the band · write this byte · stop, and put back

No I/O. What a step of RCOD does to the mixture is not known of a real unit (E3): the first step is
small, and from then on the meter says how much a step does, and in which direction. A figure that
does not follow, or a byte far from the one that was found, ends it: then something else is wrong.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import StrEnum
from typing import Final

from mikas.i18n import Text

LONGEST_STEP: Final = 8
FARTHEST: Final = 32
"""Steps of the byte from the one that was found; one is 1/256 of the fuel."""
MOST_WRITES: Final = 12
_LAST: Final = 255


class MixtureMeter(StrEnum):
    """What the person measures with: CO in per cent, or λ."""

    CO = "co"
    LAMBDA = "lambda"


BOUNDS: Final = {MixtureMeter.CO: (0.0, 15.0), MixtureMeter.LAMBDA: (0.5, 2.0)}
"""The figures that such a meter can show."""
WITHIN: Final = {MixtureMeter.CO: 0.2, MixtureMeter.LAMBDA: 0.015}
"""How near to the goal is near enough, if the person does not say."""
WIDEST: Final = {MixtureMeter.CO: 1.0, MixtureMeter.LAMBDA: 0.1}
"""The widest that a person may say: beyond it any mixture would do."""
_GAIN: Final = {MixtureMeter.CO: 0.1, MixtureMeter.LAMBDA: 0.0039}
"""Richer by so much with a step, before the meter has said how much it is."""
_SEEN: Final = {MixtureMeter.CO: 0.1, MixtureMeter.LAMBDA: 0.005}
"""A change of the figure that is more than its noise."""


class CoOutcome(StrEnum):
    """What to do."""

    SET = "set"
    WRITE = "write"
    STOP = "stop"


@dataclass(frozen=True, slots=True)
class CoStep:
    """What to do, with the byte that RCOD has to have: of STOP the one that was found."""

    outcome: CoOutcome
    raw: int
    why: Text
    turned: bool = False
    """Whether the unit was found to count the other way just now."""


@dataclass(slots=True)
class CoSetting:
    """One adjustment. `found`: the byte at its begin; `goal`, `within`: of the meter's figure."""

    found: int
    goal: float
    within: float
    meter: MixtureMeter = MixtureMeter.CO
    raw: int = field(init=False)
    writes: int = field(init=False, default=0)
    _gain: float = field(init=False)
    _before: tuple[int, float] | None = field(init=False, default=None)  # byte, richness
    _unmoved: int = field(init=False, default=0)  # steps that the figure did not follow

    def __post_init__(self) -> None:
        self.raw = self.found
        self._gain = _GAIN[self.meter]

    def next(self, figure: float) -> CoStep:
        """Return what to do with the meter's figure, which belongs to the present byte."""
        if abs(figure - self.goal) <= self.within:
            return CoStep(CoOutcome.SET, self.raw, _SET)
        richness, goal = self._richness(figure), self._richness(self.goal)
        turned = self._learn(richness)
        if self._unmoved > 1:
            return self._stop(_UNMOVED)
        if self.writes >= MOST_WRITES:
            return self._stop(_TOO_LONG)
        wanted = round((goal - richness) / self._gain)
        step = max(-LONGEST_STEP, min(LONGEST_STEP, wanted))
        if step == 0:
            step = 1 if (goal > richness) == (self._gain > 0) else -1
        raw = max(0, self.found - FARTHEST, min(_LAST, self.found + FARTHEST, self.raw + step))
        if raw == self.raw:
            return self._stop(_FAR)
        self._before = self.raw, richness
        self.raw = raw
        self.writes += 1
        return CoStep(CoOutcome.WRITE, raw, _RICHER if goal > richness else _LEANER, turned)

    def _richness(self, figure: float) -> float:
        return figure if self.meter is MixtureMeter.CO else -figure

    def _learn(self, richness: float) -> bool:
        """Take from the last step how much one does; return whether it does the opposite."""
        if self._before is None:
            return False
        raw, before = self._before
        moved, change = self.raw - raw, richness - before
        if abs(change) < _SEEN[self.meter]:
            # A step of one may do nothing that can be seen.
            self._unmoved += abs(moved) > 2
            return False
        self._unmoved = 0
        least = _GAIN[self.meter] / 5
        gain = change / moved
        turned = (gain > 0) != (self._gain > 0)
        self._gain = max(least, abs(gain)) * (1 if gain > 0 else -1)
        return turned

    def _stop(self, why: Text) -> CoStep:
        return CoStep(CoOutcome.STOP, self.found, why)


_SET: Final = Text("The figure is in the band.", "Показание в заданных пределах.")
_RICHER: Final = Text("The mixture has to be richer.", "Смесь нужно обогатить.")
_LEANER: Final = Text("The mixture has to be leaner.", "Смесь нужно обеднить.")
_UNMOVED: Final = Text(
    "The figure does not follow RCOD. The unit may not use it, as with a λ sensor in the exhaust, "
    "or the meter was read too soon.",
    "Показание не следует за RCOD. Блок может его не использовать, как при лямбда-зонде в выпуске; "
    "или прибор прочитан слишком рано.",
)
_TOO_LONG: Final = Text(
    f"{MOST_WRITES} writes have not brought the figure into the band: the idle is not steady, or "
    "the band is too narrow for the meter.",
    f"За {MOST_WRITES} записей показание не вошло в пределы: холостой ход неустойчив, или пределы "
    "для прибора слишком узкие.",
)
_FAR: Final = Text(
    f"RCOD would be more than {FARTHEST} steps from the value that was found: look for the reason "
    "first (air leak, fuel pressure, injectors, air meter).",
    f"RCOD пришлось бы сдвинуть больше чем на {FARTHEST} единицы от найденного значения: сначала "
    "найдите причину (подсос, давление топлива, форсунки, ДМРВ).",
)
