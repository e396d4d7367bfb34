"""Mixture and injection: tables, λ loop, full power, and the two fuel cuts."""

from __future__ import annotations

from mikas.virtual.model import physics as ph
from mikas.virtual.model.phase import Phase
from mikas.virtual.model.physics import STEP
from mikas.virtual.model.sensors import Sensors

LEANEST, RICHEST = 1.49, 0.5  # what VALF can tell (§4)
FULL_POWER = 0.88
TRIM_LIMIT = 0.25
LIMIT, LIMIT_BACK = 6120.0, 6000.0  # rpm: fuel off and on again
OVERRUN, OVERRUN_BACK = 1900.0, 1450.0  # rpm of a warm engine; a cold one's are higher


class MixtureControl:
    """`mixture` is λ, `trim` the λ loop's share, `fuel` mg a stroke, `injection` ms."""

    __slots__ = (
        "_exhaust",
        "_last_rpm",
        "_last_throttle",
        "_limited",
        "_overrun",
        "_tip_in",
        "fuel",
        "full_power",
        "injection",
        "mixture",
        "trim",
    )  # fmt: skip

    def __init__(self, phase: Phase) -> None:
        self.mixture = phase.cranking_mixture
        self.trim = 0.0
        self.fuel = self.injection = 0.0
        self.full_power = False
        self._exhaust = 1.0  # what the probe sees, late and blurred
        self._tip_in = self._last_throttle = self._last_rpm = 0.0
        self._overrun = self._limited = False

    def step(
        self, sensors: Sensors, phase: Phase, demand: float, burnt: float, *, idle: bool
    ) -> None:
        """One step. `demand`: the air of a wide open throttle; `burnt`: the λ that really burns."""
        self._watch_throttle(sensors, phase, demand)
        self._watch_speed(sensors, phase)
        if phase.running:
            self._choose(sensors, phase, burnt, idle=idle)
        else:
            self.mixture = phase.cranking_mixture
        cut = self._overrun or self._limited
        self.fuel = 0.0
        if cut:
            self.mixture = LEANEST
        elif phase.turned > 0.7:  # the program must see a tooth gap before it knows where to inject
            counted = ph.air_per_stroke(sensors.air, sensors.rpm)
            self.fuel = counted / (ph.STOICHIOMETRIC * self.mixture)
        self.injection = ph.injection(self.fuel, sensors.voltage)

    def _watch_throttle(self, sensors: Sensors, phase: Phase, demand: float) -> None:
        opening = (sensors.throttle - self._last_throttle) / STEP  # % a second
        self._last_throttle = sensors.throttle
        self._tip_in = max(self._tip_in * 0.93, min(0.12, max(0.0, opening - 15) * 0.0012))
        breathing = sensors.air > 0.8 * demand and sensors.rpm > 1000
        self.full_power = phase.running and (
            sensors.throttle > (65 if self.full_power else 70)
            or (breathing and sensors.throttle > 45)
        )

    def _watch_speed(self, sensors: Sensors, phase: Phase) -> None:
        rpm = sensors.rpm
        soon = 2 * rpm - self._last_rpm
        self._last_rpm = rpm
        self._limited = soon > (LIMIT_BACK if self._limited else LIMIT)
        floor = (OVERRUN_BACK if self._overrun else OVERRUN) + phase.target_speed - 850
        closed = sensors.throttle < 1.0
        self._overrun = phase.running and closed and rpm > floor and phase.run_time > 8

    def _choose(self, sensors: Sensors, phase: Phase, burnt: float, *, idle: bool) -> None:
        mixture = phase.warm_up_mixture - 0.12 * phase.after_start - self._tip_in
        if self.full_power:
            mixture = min(mixture, FULL_POWER)
        warm = sensors.coolant > 45 and phase.run_time > 25
        if warm and not (self.full_power or self._overrun or self._limited):
            self._steer_by_probe(sensors.air, burnt)
        else:
            self.trim -= self.trim * STEP / 3
            if idle:
                mixture /= 1 + sensors.idle_co
        self.mixture = max(RICHEST, min(LEANEST, mixture / (1 + self.trim)))

    def _steer_by_probe(self, air: float, burnt: float) -> None:
        """Two-point control: richer while the probe says lean and the other way round."""
        self._exhaust += (burnt - self._exhaust) * min(0.5, STEP * (0.7 + air / 25))
        slope = (0.012 + air * 0.0004) * STEP
        change = slope if self._exhaust > 1.0 else -slope
        self.trim = max(-TRIM_LIMIT, min(TRIM_LIMIT, self.trim + change))
