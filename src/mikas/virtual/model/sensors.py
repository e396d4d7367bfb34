"""What the control program takes for true: the sensors, or what stands in for a failed one."""

from __future__ import annotations

from mikas.virtual.model import physics as ph
from mikas.virtual.model import substitutes
from mikas.virtual.model.substitutes import Lost

IDLE_CO = 0.03125  # where somebody left the CO potentiometer
STANDING = 40.0  # rpm; slower than this the crankshaft sensor gives nothing


class Signals:
    """What the sensors would say if all were sound; the plant keeps it up to date."""

    __slots__ = ("air", "coolant", "demand", "intake_air", "rpm", "throttle", "voltage")

    def __init__(self, coolant: float, intake_air: float) -> None:
        self.rpm = 0.0
        self.throttle = 0.0  # %
        self.air = 0.0  # kg/h through the air meter
        self.demand = 0.0  # kg/h that the cylinders would take unthrottled
        self.coolant = coolant
        self.intake_air = intake_air
        self.voltage = 12.6


class Sensors:
    """The program's readings, in the same units. `lost`: the signals that faults take away."""

    __slots__ = (
        "air", "coolant", "idle_co", "intake_air", "lost", "rpm", "throttle", "voltage",
    )  # fmt: skip

    def __init__(self, lost: Lost, coolant: float, intake_air: float) -> None:
        self.lost = lost
        self.rpm = self.throttle = self.air = 0.0
        self.coolant = coolant
        self.intake_air = intake_air
        self.voltage = 12.6
        self.idle_co = IDLE_CO

    def read(self, signals: Signals, valve: float, air_at_start: float, run_time: float) -> None:
        """One step. `valve`, `air_at_start` and `run_time` serve the substitutes."""
        lost = self.lost
        self.rpm = signals.rpm if signals.rpm >= STANDING else 0.0
        self.voltage = signals.voltage
        self.intake_air = signals.intake_air
        self.coolant = signals.coolant
        self.throttle = signals.throttle
        self.idle_co = IDLE_CO
        if not lost.air_meter:
            self.air += (signals.air - self.air) * 0.6
        if lost.anything:
            self._replace(signals, valve)
            if lost.coolant:
                self.coolant = substitutes.coolant(air_at_start, run_time)

    def _replace(self, signals: Signals, valve: float) -> None:
        lost = self.lost
        if lost.crank:
            self.rpm = 0.0
        if lost.low_voltage:
            self.voltage = substitutes.LOW_VOLTAGE
        if lost.high_voltage:
            self.voltage = substitutes.HIGH_VOLTAGE
        if lost.air_temperature:
            self.intake_air = substitutes.AIR_TEMPERATURE
        if lost.idle_co:
            self.idle_co = substitutes.IDLE_CO
        wanted = signals.demand if self.rpm else 0.0
        around = valve * ph.VALVE_FLOW
        if lost.throttle and lost.air_meter:
            self.throttle = substitutes.THROTTLE_BLIND
        elif lost.throttle:
            self.throttle = substitutes.throttle(self.air, wanted, around)
        if lost.air_meter:
            inlet = ph.throttle_air(self.throttle) + around
            air = ph.manifold(inlet, wanted) * wanted if wanted else 0.0
            self.air += (air - self.air) * 0.15
