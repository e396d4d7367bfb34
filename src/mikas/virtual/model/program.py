"""The control unit's program: from sensors to injection, spark and idle valve.

Not the real unit's program, which is not public, but one that does what it is known to do: speed by
the idle valve and a little spark, mixture by temperature and a λ loop, full-power enrichment, fuel
cut on overrun and at the speed limit, later spark on knock. What its parts hold is what a tester
reads.
"""

from __future__ import annotations

from copy import copy

from mikas.virtual.model.idle_control import IdleControl
from mikas.virtual.model.mixture_control import MixtureControl
from mikas.virtual.model.phase import Phase
from mikas.virtual.model.sensors import Sensors, Signals
from mikas.virtual.model.spark_control import SparkControl
from mikas.virtual.model.substitutes import Lost

FAN_ON, FAN_OFF = 93.5, 88.5  # °C
PARKED = 40.0  # where the idle valve stands before it is first driven


class Program:
    """One control unit."""

    __slots__ = ("fan", "idle", "mixture", "phase", "sensors", "spark")

    def __init__(self, lost: Lost, coolant: float, intake_air: float) -> None:
        self._begin(lost, coolant, intake_air, PARKED)

    def _begin(self, lost: Lost, coolant: float, intake_air: float, valve: float) -> None:
        self.fan = False
        self.sensors = Sensors(lost, coolant, intake_air)
        self.phase = Phase(coolant, intake_air)
        self.idle = IdleControl(self.phase, valve)
        self.mixture = MixtureControl(self.phase)
        self.spark = SparkControl()

    def fork(self) -> Program:
        """A copy that goes its own way."""
        other = copy(self)
        other.sensors, other.phase, other.idle = (
            copy(self.sensors),
            copy(self.phase),
            copy(self.idle),
        )
        other.mixture, other.spark = copy(self.mixture), copy(self.spark)
        return other

    def power_on(self, coolant: float, intake_air: float) -> None:
        """The key was turned on: all starts again, but the valve keeps its position."""
        self._begin(self.sensors.lost, coolant, intake_air, self.idle.valve)

    def power_off(self) -> None:
        """The key was turned off: nothing is driven any more."""
        self.power_on(self.sensors.coolant, self.sensors.intake_air)

    def step(self, signals: Signals, burnt: float, knock_limit: float) -> None:
        """One step: read the sensors, then set everything that the unit sets.

        `burnt` is the λ that really burns, `knock_limit` the advance at which it knocks.
        """
        sensors, phase, idle = self.sensors, self.phase, self.idle
        sensors.read(signals, idle.valve, phase.air_at_start, phase.run_time)
        phase.step(sensors)
        if sensors.coolant > FAN_ON or sensors.lost.coolant:
            self.fan = True
        elif sensors.coolant < FAN_OFF:
            self.fan = False
        idle.step(sensors, phase, fan=self.fan)
        self.mixture.step(sensors, phase, signals.demand, burnt, idle=idle.idle)
        self.spark.step(sensors, phase, knock_limit, firing=self.mixture.fuel > 0)
