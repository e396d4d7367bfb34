"""What the control program uses instead of a sensor whose fault is present.

That an air meter, a temperature or a throttle sensor has a substitute, and that an engine with no
crank signal does not run, is reported of these units; the values themselves are this model's
assumption. The program's outputs (injection, advance, valve) follow from the substitutes, and the
parameters of the failed sensors show them.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, fields

from mikas.virtual.model import physics as ph

AIR_TEMPERATURE = 20.0  # °C
COOLANT_AT_LAST = 80.0  # °C; reached from the air's temperature at start, COOLANT_RISE a second
COOLANT_RISE = 0.1
THROTTLE_BLIND = 5.0  # %; throttle and air meter both failed
LOW_VOLTAGE, HIGH_VOLTAGE = 9.5, 18.2  # V; here the fault is the value itself (< 10 V, > 18 V)
SAFE_RETARD = -6.0  # °
IDLE_CO = 0.0  # the CO potentiometer in its middle


@dataclass(frozen=True, slots=True)
class Substitute:
    """One row: while one of `faults` is present, `parameters` come from `rule`."""

    faults: tuple[int, ...]
    parameters: tuple[str, ...]
    rule: str


TABLE = (
    Substitute((13, 14), ("JAIR",), "computed from throttle and engine speed, for air of 20 °C"),
    Substitute((17, 18), ("TAIR",), "20 °C"),
    Substitute(
        (21, 22), ("TWAT",), "air temperature at start + 0.1 °C a second, up to 80 °C; fan on"
    ),
    Substitute((23, 24), ("THR",), "computed from air flow and engine speed; 5 % if no air meter"),
    Substitute((25,), ("UACC",), "9.5 V"),
    Substitute((26,), ("UACC",), "18.2 V"),
    Substitute((31, 32), ("RCOD",), "0"),
    Substitute((41,), ("DET", "RDET", "UOZOC"), "no knock control, 6° later at high load"),
    Substitute((53,), ("FREQ", "FREQX"), "0: no injection and no spark"),
)


@dataclass(frozen=True, slots=True)
class Lost:
    """Which signals the faults that are present take away, in the order of `TABLE`."""

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
    def by(cls, faults: Collection[int]) -> Lost:
        """Any fault of a row loses the row's signal."""
        present = [any(fault in faults for fault in row.faults) for row in TABLE]
        names = (field.name for field in fields(cls))
        return cls(**dict(zip(names, (*present, any(present)), strict=True)))


NOTHING = Lost()


def coolant(air_at_start: float, run_time: float) -> float:
    """°C: rises with time from the air's temperature at the start."""
    return min(COOLANT_AT_LAST, air_at_start + COOLANT_RISE * run_time)


def throttle(air: float, wanted: float, around: float) -> float:
    """%: the opening that gives `air` of the `wanted`, when `around` it flows the idle valve's."""
    if wanted <= 0:
        return 0.0
    inlet = ph.inlet_for(min(0.99, air / wanted), wanted) - around
    opening = ph.throttle_for(inlet - 2.0)
    return opening if opening > 5.0 else 0.0
