"""Standing, starting, running: what the control program knows of how far the engine is."""

from __future__ import annotations

from mikas.virtual.model.physics import STEP, LookupTable
from mikas.virtual.model.sensors import Sensors

# Over coolant °C. The speeds are those of the facts about the car: 850 warm, 1100 to 1500 cold.
TARGET_SPEED = LookupTable(
    {-40: 1500, -20: 1450, 0: 1330, 20: 1200, 40: 1060, 60: 930, 75: 860, 80: 850}, 5
)
IDLE_AIR = LookupTable(
    {-40: 44, -20: 38, 0: 29, 20: 22.5, 40: 18.5, 60: 16, 80: 14.5, 100: 14.2}, 5
)
START_AIR = LookupTable({-40: 60, -20: 48, 0: 38, 20: 31, 60: 23, 90: 18.5}, 5)
CRANKING_MIXTURE = LookupTable({-40: 0.52, -20: 0.58, 0: 0.68, 20: 0.78, 60: 0.88, 90: 0.93}, 5)
WARM_UP_MIXTURE = LookupTable(
    {-40: 0.74, -20: 0.80, 0: 0.86, 20: 0.91, 40: 0.96, 60: 1.0, 100: 1.0}, 5
)
START_SPEED = 480.0  # rpm at which starting is over
LOOK_UP = 16  # steps between two looks into the tables


class Phase:
    """`turned` counts engine cycles since the crankshaft began to turn, `run_time` s of running.

    `after_start` falls from 1 to 0 after a start. The rest is what the tables say at this coolant.
    """

    __slots__ = (
        "_look_up", "after_start", "air_at_start", "coolant_at_start", "cranking_mixture",
        "idle_air", "run_time", "running", "start_air", "target_speed", "turned", "warm_up_mixture",
    )  # fmt: skip

    def __init__(self, coolant: float, intake_air: float) -> None:
        self.coolant_at_start = coolant
        self.air_at_start = intake_air
        self.running = False
        self.turned = self.run_time = self.after_start = 0.0
        self._consult(coolant)

    def step(self, sensors: Sensors) -> None:
        """One step."""
        rpm = sensors.rpm
        if rpm == 0:
            self.turned = self.run_time = 0.0
            self.running = False
        else:
            if self.turned == 0:
                self.air_at_start = sensors.intake_air
                self.coolant_at_start = sensors.coolant
            self.turned += rpm / 120 * STEP
            if rpm > START_SPEED and not self.running:
                self.running = True
                self.after_start = 1.0
        if self.running:
            self.run_time += STEP
            lasting = 6 + 0.25 * max(0.0, 60 - sensors.coolant)
            self.after_start -= self.after_start * STEP / lasting
        if self._look_up == 0:
            self._consult(sensors.coolant)
        self._look_up -= 1

    def _consult(self, coolant: float) -> None:
        self._look_up = LOOK_UP
        self.target_speed = TARGET_SPEED(coolant)
        self.idle_air = IDLE_AIR(coolant)
        self.start_air = START_AIR(coolant)
        self.cranking_mixture = CRANKING_MIXTURE(coolant)
        self.warm_up_mixture = WARM_UP_MIXTURE(coolant)
