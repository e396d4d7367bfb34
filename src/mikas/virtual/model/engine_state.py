"""One moment of the engine model, in physical units, named by what §4's mnemonics mean."""

from __future__ import annotations

from dataclasses import dataclass

from mikas.virtual.model import physics as ph
from mikas.virtual.model.physics import STEP
from mikas.virtual.model.plant import Plant

FIELDS = {
    "TWAT": "coolant",
    "FREQ": "rpm",
    "FREQX": "idle_rpm",
    "UOZ": "advance",
    "UACC": "voltage",
    "INJ": "injection",
    "JAIR": "air",
    "JQT": "fuel",
    "DET": "knock",
    "RXX": "idle",
    "BITPOW": "full_power",
    "RDET": "knock_corrected",
    "VALF": "mixture",
    "THR": "throttle",
    "RCOK": "fuel_correction",
    "RCOD": "idle_co_correction",
    "UOZOC": "advance_correction",
    "SSM": "valve_set",
    "FSM": "valve",
    "UGB": "air_set",
    "TAIR": "intake_air",
    "TWATI": "coolant_at_start",
}
"""Which field of `EngineState` a parameter of §4 shows."""

NEUTRAL = -0.5  # E3: what the letter of the formula makes of a correction of nothing, byte 128


@dataclass(frozen=True, slots=True)
class EngineState:
    """What the control unit believes and does, then some truths about the car behind it.

    With a sensor's fault present its field holds the substitute (`model/substitutes.py`).
    """

    time: float  # s since the start
    ignition_on: bool
    running: bool
    coolant: float  # °C
    coolant_at_start: float  # °C
    intake_air: float  # °C
    rpm: float
    idle_rpm: float  # the same, up to the 2550 that its finer byte can hold
    voltage: float
    throttle: float  # %
    air: float  # kg/h
    air_set: float  # kg/h
    injection: float  # ms
    fuel: float  # l/h
    mixture: float  # λ
    fuel_correction: float  # NEUTRAL: none; 0.1 above it: a tenth more petrol
    idle_co_correction: float  # likewise
    advance: float  # ° before top dead centre
    advance_correction: float  # °, negative: later because of knock
    knock: bool
    knock_corrected: bool
    idle: bool
    full_power: bool
    valve_set: float  # steps of the idle valve, 0 to 255
    valve: float
    fan: bool
    cycles: float  # engine cycles (two turns each) since the start
    fuel_used: float  # l since the start
    speed: float  # km/h


def state_of(plant: Plant, time: float, *, powered: bool) -> EngineState:
    """The state at `time`, which lies in the plant's present step."""
    program = plant.program
    sensors, phase, idle = program.sensors, program.phase, program.idle
    mixture, spark = program.mixture, program.spark
    return EngineState(
        time=time,
        ignition_on=powered,
        running=powered and phase.running,
        coolant=sensors.coolant,
        coolant_at_start=phase.coolant_at_start,
        intake_air=sensors.intake_air,
        rpm=sensors.rpm,
        idle_rpm=min(2550.0, sensors.rpm),
        voltage=sensors.voltage,
        throttle=sensors.throttle,
        air=sensors.air,
        air_set=idle.air_set,
        injection=mixture.injection,
        fuel=ph.fuel_flow(mixture.fuel, sensors.rpm),
        mixture=mixture.mixture,
        fuel_correction=NEUTRAL + mixture.trim,
        idle_co_correction=NEUTRAL + sensors.idle_co,
        advance=spark.advance,
        advance_correction=spark.correction,
        knock=spark.knock,
        knock_corrected=spark.knock_corrected,
        idle=idle.idle,
        full_power=mixture.full_power,
        valve_set=idle.valve_set,
        valve=idle.valve,
        fan=program.fan,
        cycles=plant.cycles + (time - plant.step_number * STEP) * plant.rpm / 120,
        fuel_used=plant.fuel_used,
        speed=plant.vehicle.speed * 3.6,
    )
