"""One moment of the engine model, in physical units, named by what §4's mnemonics mean.

The engine model as the virtual unit sees it: advance it to a time, read its state.

    engine = Engine(SCENARIOS["warm-idle"], seed=1)
    engine.advance(12.5)             # seconds since the start; going back does nothing
    engine.state.coolant             # physical units, named by what §4's mnemonics mean
    engine.faults.add(13)            # from the next step on the air meter's substitute is used
    engine.next_cycle_time(1, 12.5)  # when the next engine cycle starts (D15)

Values hold for a step of the grid (1/32 s), only `cycles` runs on in between. The same scenario,
seed and changes of faults give the same states at the same times, however often they are read.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Collection, Iterable
from dataclasses import dataclass
from math import floor, inf

from mikas.virtual.model import physics as ph
from mikas.virtual.model.physics import STEP
from mikas.virtual.model.plant import Plant, plant_at_start
from mikas.virtual.model.sensors import Lost
from mikas.virtual.scenarios.scenario import DEFAULT, SCENARIOS, Scenario

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
"""The field of `EngineState` by the parameter of §4."""

NEUTRAL = -0.5  # E3: byte 128, no correction, by the letter of the formula


@dataclass(frozen=True, slots=True)
class EngineState:
    """One moment: the control unit's values, then some true values of the car.

    The field of a failed sensor holds its substitute (`sensors.TABLE`).
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
    """Return the state at `time`, which is in the plant's present step."""
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


ROUNDING = 5e-5  # cycles: a rounded time this close to a stroke is the stroke's own
HORIZON = 4.0  # s that `next_cycle_time` looks ahead


class Engine:
    """An engine in its car with its control unit, in one scenario.

    `faults`: the numbers of those present; may be changed or replaced at any time.
    """

    def __init__(
        self, scenario: Scenario = SCENARIOS[DEFAULT], seed: int = 0, faults: Iterable[int] = ()
    ) -> None:
        self.scenario = scenario
        self.faults: Collection[int] = set(faults)
        self.time = 0.0
        self._applied = frozenset(self.faults)
        lost = Lost.by(self._applied)
        self._plant = plant_at_start(scenario.start, scenario.timeline, seed, lost)
        self._state: EngineState | None = None  # at `time`, once computed
        self._future: Plant | None = None  # a copy of the plant, advanced further
        self._ahead: deque[tuple[float, float]] = deque()  # (cycles, rpm) of each step from now

    def advance(self, to: float) -> None:
        """Advance to `to`, seconds since the start."""
        self._apply_faults()
        if to <= self.time:
            return
        self.time = to
        self._state = None
        last = floor(to / STEP)
        plant, ahead = self._plant, self._ahead
        while plant.step_number < last:
            plant.step()
            if ahead:
                ahead.popleft()

    @property
    def state(self) -> EngineState:
        """The state at the present time."""
        if self._state is None:
            self._state = state_of(self._plant, self.time, powered=self.powered)
        return self._state

    @property
    def powered(self) -> bool:
        """Whether the unit has supply now."""
        return self.scenario.timeline.key_on(self.time)

    def next_cycle_time(self, stroke: int, after: float) -> float:
        """Return the next time later than `after` at which this stroke begins (D15).

        Strokes 0 and 1 begin with the engine cycle, 2 to 4 a quarter, a half and three quarters
        later. Exact until `faults` change. Infinity: none within `HORIZON` seconds, because the
        engine stands or the unit has no supply or no crank signal. `after` may be in the future;
        of the past only the present step is known.
        """
        self._apply_faults()
        phase = (stroke - 1) / 4 if stroke else 0.0
        first = self._plant.step_number
        after = max(after, first * STEP)
        index = floor(after / STEP)
        place, rpm = self._predict(index - first)
        place += (after - index * STEP) * rpm / 120
        target = floor(place - phase + ROUNDING) + 1 + phase
        begin = after
        while begin <= after + HORIZON:
            end = (index + 1) * STEP
            time = begin + max(0.0, target - place) * 120 / rpm if rpm > 0 else inf
            if time < end:
                return time
            index, begin = index + 1, end
            place, rpm = self._predict(index - first)
        return inf

    def _predict(self, steps: int) -> tuple[float, float]:
        """Return cycles and the unit's speed, `steps` after the present one."""
        ahead = self._ahead
        if not ahead:
            self._future = self._plant.fork()
            ahead.append((self._plant.cycles, self._plant.unit_rpm))
        future = self._future
        assert future is not None  # made with the first entry of `ahead`
        while len(ahead) <= steps:
            future.step()
            ahead.append((future.cycles, future.unit_rpm))
        return ahead[steps]

    def _apply_faults(self) -> None:
        if self._applied != (faults := frozenset(self.faults)):
            self._applied = faults
            self._plant.program.sensors.lost = Lost.by(self._applied)
            self._ahead.clear()
