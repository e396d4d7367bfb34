"""What surrounds the combustion: coolant and air under the bonnet, battery and alternator.

Slow things, each a first-order balance: 60 kJ/K of iron and water heated by a share of the
petrol's heat, cooled through thermostat, radiator, fan and wind; a 12 V battery with its inner
resistance and an alternator that gives little at idle.
"""

from __future__ import annotations

from mikas.virtual.model import physics as ph
from mikas.virtual.model.physics import STEP
from mikas.virtual.scenarios.scenario import Start

HEAT_CAPACITY = 60e3  # J/K
TO_COOLANT = 0.29  # share of the petrol's heat
BOILING = 112.0  # °C under the cap's pressure; steam then takes the heat away
FLAT = 5.5  # V: below this the starter only clicks
THERMOSTAT = (80.0, 92.0)  # °C: begins to open, fully open


class Heat:
    """Temperatures: `coolant`, and `intake_air` where the sensor sits."""

    __slots__ = ("ambient", "coolant", "intake_air")

    def __init__(self, start: Start) -> None:
        self.ambient = start.ambient
        self.coolant = start.coolant
        self.intake_air = self._air_rests_at(14.0, 0.0) if start.running else start.ambient

    def step(self, fuel: float, air: float, speed: float, seconds: float, *, fan: bool) -> None:
        """`seconds` with `fuel` in l/h, `air` in kg/h, `speed` in m/s."""
        burnt = fuel * ph.PETROL / 3600 * ph.PETROL_HEAT * 1e6  # W
        open_share = (self.coolant - THERMOSTAT[0]) / (THERMOSTAT[1] - THERMOSTAT[0])
        radiator = max(0.0, min(1.0, open_share)) * (12 + (110 if fan else 0) + 28 * speed)
        lost = (self.coolant - self.ambient) * (16 + 1.2 * speed + radiator)
        lost += max(0.0, self.coolant - BOILING) * 4000
        self.coolant += (burnt * TO_COOLANT - lost) / HEAT_CAPACITY * seconds
        slowness = 3000 / (12 + air + 4 * speed)
        self.intake_air += (self._air_rests_at(air, speed) - self.intake_air) * seconds / slowness

    def _air_rests_at(self, air: float, speed: float) -> float:
        """Air drawn past a hot engine warms up, the less the more of it flows."""
        soak = 0.42 / (1 + speed / 6 + air / 80)
        return self.ambient + soak * (self.coolant - self.ambient)


class Board:
    """The board's voltage."""

    __slots__ = ("_owed", "_resistance", "_rest", "voltage")

    def __init__(self, start: Start) -> None:
        cold = max(0.0, 20.0 - start.ambient)
        self._resistance = 0.0125 * (1 + 0.006 * cold) / start.battery  # Ohm
        self._rest = 12.75 - 0.006 * cold - 0.8 * (1 - start.battery)
        self._owed = 0.0 if start.running else 1.0  # Ah that the battery takes back
        self.voltage = 14.0 if start.running else self._rest

    def step(self, rpm: float, *, key: bool, starter: bool, burning: bool, fan: bool) -> float:
        """One step; the alternator's torque on the crankshaft, Nm."""
        used = (9.0 if key else 0.1) + (14.0 if burning else 0.0) + (13.0 if fan else 0.0)
        torque = 0.0
        if rpm > 500 and key and not starter:
            gives = min(65.0, 34.0 + (rpm - 850) * 0.018)
            charge = min(20.0, 2.0 + 12.0 * self._owed)
            lack = max(0.0, used + charge - gives)
            goal = 14.15 - 0.04 * lack - 0.004 * (used - 20)
            self._owed = max(0.0, self._owed - charge * STEP / 3600)
            torque = min(gives, used + charge) * goal / 0.55 / (rpm * ph.TO_RADIANS)
        else:
            current = used + (max(120.0, 330.0 - 0.6 * rpm) if starter else 0.0)
            goal = max(FLAT, self._rest - self._resistance * current)
            self._owed += current * STEP / 3600
        self.voltage += (goal - self.voltage) * STEP / (0.09 + STEP)
        return torque
