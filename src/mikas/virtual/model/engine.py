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
from dataclasses import dataclass, field, fields
from math import floor, inf
from typing import Any

from mikas.virtual.model import physics as ph
from mikas.virtual.model.physics import STEP
from mikas.virtual.model.plant import Plant, plant_at_start
from mikas.virtual.model.sensors import LostSignals
from mikas.virtual.scenarios.scenario import DEFAULT, SCENARIOS, Scenario

NEUTRAL = -0.5  # E3: byte 128, no correction, by the letter of the formula


def _of(parameter: str) -> Any:  # noqa: ANN401  (`field` is typed as its default, of any type)
    """Return the field that the unit gives as this parameter of §4."""
    return field(metadata={"of": parameter})


@dataclass(frozen=True, slots=True)
class EngineState:
    """One moment: some true values of the car, then the control unit's values.

    The field of a failed sensor holds its substitute (`sensors.TABLE`).
    """

    time: float  # s since the start
    ignition_on: bool
    running: bool
    fan: bool
    cycles: float  # engine cycles (two turns each) since the start
    fuel_used: float  # l since the start
    speed: float  # km/h
    burnt: float  # λ in the exhaust, whatever the unit counts; infinity: air
    coolant: float = _of("TWAT")  # °C
    coolant_at_start: float = _of("TWATI")  # °C
    intake_air: float = _of("TAIR")  # °C
    rpm: float = _of("FREQ")
    idle_rpm: float = _of("FREQX")  # the same, up to the 2550 that its finer byte can hold
    voltage: float = _of("UACC")
    throttle: float = _of("THR")  # %
    air: float = _of("JAIR")  # kg/h
    air_set: float = _of("UGB")  # kg/h
    injection: float = _of("INJ")  # ms
    fuel: float = _of("JQT")  # l/h
    mixture: float = _of("VALF")  # λ
    fuel_correction: float = _of("RCOK")  # NEUTRAL: none; 0.1 above it: a tenth more petrol
    idle_co_correction: float = _of("RCOD")  # likewise
    advance: float = _of("UOZ")  # ° before top dead centre
    advance_correction: float = _of("UOZOC")  # °, negative: later because of knock
    knock: bool = _of("DET")
    knock_corrected: bool = _of("RDET")
    idle: bool = _of("RXX")
    full_power: bool = _of("BITPOW")
    valve_set: float = _of("SSM")  # steps of the idle valve, 0 to 255
    valve: float = _of("FSM")


FIELDS = {each.metadata["of"]: each.name for each in fields(EngineState) if each.metadata}
"""The field of `EngineState` by the parameter of §4."""


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
        burnt=plant.burnt,
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
        self.time: float = 0.0
        self._applied = frozenset(self.faults)
        lost = LostSignals.by(self._applied)
        self._plant = plant_at_start(scenario, seed, lost)
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
            self._plant.program.sensors.lost = LostSignals.by(self._applied)
            self._ahead.clear()
