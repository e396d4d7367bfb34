"""The sensors' values as the control program reads them, or the substitutes of failed sensors.

That an air meter, a temperature or a throttle sensor has a substitute, and that an engine without
crank signal does not run, is reported of these units; the values themselves are this model's
assumption. The program's outputs (injection, advance, valve) follow from the substitutes, and the
parameters of the failed sensors show them.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, fields
from typing import NamedTuple

from mikas.virtual.model import physics as ph

IDLE_CO = 0.03125  # position of the CO potentiometer
STANDING = 40.0  # rpm; below it the crankshaft sensor gives no signal
SAFE_RETARD = -6.0  # °, at high load without knock sensor


class Substitute(NamedTuple):
    """While one of `faults` is present, `parameters` have substitutes."""

    faults: tuple[int, ...]
    parameters: tuple[str, ...]


TABLE = (
    Substitute((13, 14), ("JAIR",)),  # computed from throttle and engine speed, for air of 20 °C
    Substitute((17, 18), ("TAIR",)),  # 20 °C
    Substitute((21, 22), ("TWAT",)),  # air at start + 0.1 °C a second, up to 80 °C; fan on
    Substitute((23, 24), ("THR",)),  # computed from air flow and speed; 5 % without air meter
    Substitute((25,), ("UACC",)),  # 9.5 V; the fault is the value itself: below 10 V
    Substitute((26,), ("UACC",)),  # 18.2 V; the fault is the value itself: above 18 V
    Substitute((31, 32), ("RCOD",)),  # 0: the CO potentiometer in its middle
    Substitute((41,), ("DET", "RDET", "UOZOC")),  # no knock control, `SAFE_RETARD`
    Substitute((53,), ("FREQ", "FREQX")),  # 0: no injection and no spark
)


@dataclass(frozen=True, slots=True)
class LostSignals:
    """The signals that the present faults take away, in the order of `TABLE`."""

    air_meter: bool = False
    air_temperature: bool = False
    coolant: bool = False
    throttle: bool = False
    low_voltage: bool = False
    high_voltage: bool = False
    idle_co: bool = False
    knock: bool = False
    crank: bool = False
    anything: bool = False

    @classmethod
    def by(cls, faults: Collection[int]) -> LostSignals:
        """Return the signals lost by `faults`: any fault of a row loses the row's signal."""
        present = [any(fault in faults for fault in row.faults) for row in TABLE]
        names = (field.name for field in fields(cls))
        return cls(**dict(zip(names, (*present, any(present)), strict=True)))


NOTHING = LostSignals()


@dataclass(slots=True, eq=False)
class Signals:
    """The true values, as sound sensors give them; the plant updates them."""

    coolant: float
    intake_air: float
    rpm: float = 0.0
    throttle: float = 0.0  # %
    air: float = 0.0  # kg/h through the air meter
    demand: float = 0.0  # kg/h that the cylinders take with the throttle wide open
    voltage: float = 12.6


@dataclass(slots=True, eq=False)
class Sensors:
    """The program's readings, in the same units. `lost`: the signals that faults take away."""

    lost: LostSignals
    coolant: float
    intake_air: float
    rpm: float = 0.0
    throttle: float = 0.0
    air: float = 0.0
    voltage: float = 12.6
    idle_co: float = IDLE_CO

    def read(self, signals: Signals, valve: float, air_at_start: float, run_time: float) -> None:
        """Read `signals` for one step. The other parameters serve the substitutes."""
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
            self._substitute(signals, valve)
            if lost.coolant:
                self.coolant = min(80.0, air_at_start + 0.1 * run_time)

    def _substitute(self, signals: Signals, valve: float) -> None:
        lost = self.lost
        if lost.crank:
            self.rpm = 0.0
        if lost.low_voltage:
            self.voltage = 9.5
        if lost.high_voltage:
            self.voltage = 18.2
        if lost.air_temperature:
            self.intake_air = 20.0
        if lost.idle_co:
            self.idle_co = 0.0
        demand = signals.demand if self.rpm else 0.0
        bypass = valve * ph.VALVE_FLOW
        if lost.throttle:
            self.throttle = 5.0 if lost.air_meter else _throttle(self.air, demand, bypass)
        if lost.air_meter:
            inlet = ph.throttle_air(self.throttle) + bypass
            air = ph.manifold(inlet, demand) * demand if demand else 0.0
            self.air += (air - self.air) * 0.15


def _throttle(air: float, demand: float, bypass: float) -> float:
    """Return the opening in % that gives `air` of the `demand`, with `bypass` by the idle valve."""
    if demand <= 0:
        return 0.0
    inlet = ph.inlet_for(min(0.99, air / demand), demand) - bypass
    opening = ph.throttle_for(inlet - 2.0)
    return opening if opening > 5.0 else 0.0
