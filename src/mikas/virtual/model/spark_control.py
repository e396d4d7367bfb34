"""Ignition advance: the table's, a little for idle speed, less after knock."""

from __future__ import annotations

from mikas.virtual.model import physics as ph
from mikas.virtual.model import substitutes
from mikas.virtual.model.phase import Phase
from mikas.virtual.model.physics import STEP
from mikas.virtual.model.sensors import Sensors

CRANKING = 6.0  # °
IDLE = 13.0
LATEST = -12.0  # that knock may take away
KNOCK_STEP, KNOCK_BACK = -3.0, 0.8  # ° at once; ° a second
KNOCK_SHOWN = 0.125  # s that the flag stays up
LISTENING = 0.55  # filling below which no knock is looked for


class SparkControl:
    """`advance` with `correction` (negative, after knock) already in it; two flags."""

    __slots__ = ("_shown", "advance", "correction", "knock", "knock_corrected")

    def __init__(self) -> None:
        self._rest()

    def _rest(self) -> None:
        self.advance = CRANKING
        self.correction = 0.0
        self.knock = self.knock_corrected = False
        self._shown = 0.0

    def step(self, sensors: Sensors, phase: Phase, limit: float, *, firing: bool) -> None:
        """One step. `limit`: the advance at which it knocks just now."""
        if not phase.running:
            self._rest()
            return
        filling = min(1.0, ph.air_per_stroke(sensors.air, sensors.rpm) / ph.STROKE_AIR)
        self._listen(sensors, limit if firing else 90.0, filling)
        if sensors.throttle < 1.0:
            error = phase.target_speed - sensors.rpm
            wanted = IDLE + max(-2.8, min(2.8, 0.05 * error))
            wanted += max(0.0, min(16.0, -0.015 * (error + 150)))  # coasting
        else:
            wanted = min(42.0, ph.base_advance(sensors.rpm, filling))
        wanted += self.correction
        self.advance += max(-3.0, min(2.0, wanted - self.advance))  # per step: 96 and 64 °/s

    def _listen(self, sensors: Sensors, limit: float, filling: float) -> None:
        if sensors.lost.knock:
            self.knock = self.knock_corrected = False
            self.correction = substitutes.SAFE_RETARD if filling > LISTENING else 0.0
            return
        self._shown -= STEP
        self.correction = min(0.0, self.correction + KNOCK_BACK * STEP)
        if filling > LISTENING and self._shown <= 0 and self.advance > limit:
            self.correction = max(LATEST, self.correction + KNOCK_STEP)
            self._shown = KNOCK_SHOWN
        self.knock = self._shown > 0
        self.knock_corrected = self.correction < -0.25
