"""Idle speed by air: a set air flow, and the idle valve's position that lets it through.

The speed's error moves the air that is wanted; the air's error moves the valve. The valve follows
its set position with a lag, at most 96 steps a second.
"""

from __future__ import annotations

from mikas.virtual.model import physics as ph
from mikas.virtual.model.phase import Phase
from mikas.virtual.model.physics import STEP
from mikas.virtual.model.sensors import Sensors

CLOSED = 1.0  # % below which the throttle counts as closed
FAN_AIR = 0.8  # kg/h more while the fan loads the alternator
FASTEST = 3.0  # valve steps a grid step


class IdleControl:
    """`idle`: the engine idles. `air_set` in kg/h, `valve_set` and `valve` in steps."""

    __slots__ = ("_air_trim", "_speed_trim", "air_set", "idle", "valve", "valve_set")

    def __init__(self, phase: Phase, valve: float) -> None:
        self.idle = False
        self.air_set = phase.start_air
        self.valve_set = self.valve = valve
        self._speed_trim = self._air_trim = 0.0

    def step(self, sensors: Sensors, phase: Phase, *, fan: bool) -> None:
        """One step."""
        closed = sensors.throttle < CLOSED
        error = phase.target_speed - sensors.rpm
        self.idle = phase.running and closed and error > -600
        if not phase.running:
            self._speed_trim = 0.0
            goal = phase.start_air
        else:
            goal = phase.idle_air + phase.after_start * 5 + self._speed_trim + FAN_AIR * fan
            if self.idle:
                goal += max(-1.2, min(5.0, 0.012 * error))
                if error < 400 and phase.run_time > 3:
                    self._learn(error, sensors.air)
            elif not closed:
                goal += min(8.0, 1.2 * sensors.throttle)  # a cushion for when it closes
        self.air_set += (goal - self.air_set) * STEP / (0.15 + STEP)
        flow = self.air_set / ph.density(sensors.intake_air) - ph.THROTTLE_LEAK
        self.valve_set = max(0.0, min(255.0, flow / ph.VALVE_FLOW + self._air_trim))
        self.valve += max(-FASTEST, min(FASTEST, (self.valve_set - self.valve) * 0.3))

    def _learn(self, error: float, air: float) -> None:
        eager = min(120.0, error) if error > -250 else -20.0  # so fast it may be coasting
        change = max(-60.0, eager) * 0.008 * STEP
        self._speed_trim = max(-8.0, min(12.0, self._speed_trim + change))
        if abs(error) < 120:
            off = max(-5.0, min(5.0, self.air_set - air))
            self._air_trim = max(-30.0, min(60.0, self._air_trim + 0.8 * off * STEP))
