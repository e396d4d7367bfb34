"""Engine, car and control unit together, one step of the grid at a time.

All state is here and in the parts; `fork` copies it, to compute future steps. Noise comes from a
table made from the seed, indexed by the step's number, so reads change no result.
"""

from __future__ import annotations

import random
from copy import copy
from functools import lru_cache
from math import inf

from mikas.virtual.model import physics as ph
from mikas.virtual.model.physics import STEP, TO_RADIANS
from mikas.virtual.model.program import Program
from mikas.virtual.model.sensors import NOTHING, LostSignals, Signals
from mikas.virtual.model.vehicle import Board, Heat, Vehicle
from mikas.virtual.scenarios.scenario import Condition, Scenario, Start
from mikas.virtual.scenarios.timeline import ScenarioTimeline

NOISE = 16381  # entries, 8.5 minutes; a prime, so that every stride visits all of them
SETTLING = 1920  # steps of a running engine before second 0: a minute
BEGINNING = 64  # the last of them: two seconds with the faults of the scenario
SLOW = 8  # steps between two of the temperatures
EMPTYING = 4.0e-3 / 2.286e-3  # manifold against displacement


@lru_cache(maxsize=8)
def noise_table(seed: int) -> tuple[float, ...]:
    """Return normally distributed numbers, limited to ±3."""
    source = random.Random(seed)
    return tuple(max(-3.0, min(3.0, source.gauss(0.0, 1.0))) for _ in range(NOISE))


def plant_at_start(scenario: Scenario, seed: int, lost: LostSignals) -> Plant:
    """Return a new plant at second 0: a copy, since a running engine takes 0.1 s to settle."""
    car = scenario.start, scenario.condition, scenario.timeline
    return _settled_plant(*car, seed, lost).fork()


@lru_cache(maxsize=32)
def _settled_plant(
    start: Start, condition: Condition, timeline: ScenarioTimeline, seed: int, lost: LostSignals
) -> Plant:
    plant = _warm_plant(start, condition, timeline, seed).fork()
    plant.begin(lost)
    return plant


@lru_cache(maxsize=8)
def _warm_plant(start: Start, condition: Condition, timeline: ScenarioTimeline, seed: int) -> Plant:
    return Plant(start, condition, timeline, seed)


class Plant:
    """The state at one step of the grid; `plant_at_start` returns a new one.

    A running engine is at first two seconds before second 0, warm; `begin` brings it there.
    """

    __slots__ = (
        "_burning", "_burnt", "_condition", "_fuel", "_noise", "_signals", "_start", "_timeline",
        "_viscosity", "board", "crank", "cycles", "fuel_used", "heat", "key", "manifold", "program",
        "step_number", "vehicle",
    )  # fmt: skip

    def __init__(
        self, start: Start, condition: Condition, timeline: ScenarioTimeline, seed: int
    ) -> None:
        self._start = start
        self._condition = condition
        self._timeline = timeline
        self._noise = noise_table(seed)
        self.heat: Heat = Heat(start, condition)
        self.board: Board = Board(start, condition)
        self.vehicle: Vehicle = Vehicle(
            (timeline.at(0.0).speed or 0.0) / 3.6, start.running, condition.throttle_stops
        )
        shown = start.coolant + condition.coolant_sensor
        self.program: Program = Program(NOTHING, shown, self.heat.intake_air, condition)
        self._signals = Signals(shown, self.heat.intake_air)
        self._viscosity = ph.VISCOSITY(start.coolant)
        self._burning = start.running
        self.key: bool = start.running
        self._fuel = 0.0  # mg a stroke, really injected
        self._burnt = 1.0  # λ
        self.crank: float = 850 * TO_RADIANS if start.running else 0.0  # rad/s
        self.manifold: float = 0.35 if start.running else 1.0  # pressure against outside
        self.cycles: float = 0.0
        self.fuel_used: float = 0.0
        self.step_number: int = 0
        if start.running:
            self._settle(range(-SETTLING, -BEGINNING))

    def fork(self) -> Plant:
        """Return an independent copy."""
        other = copy(self)
        other.vehicle, other.heat = copy(self.vehicle), copy(self.heat)
        other.board = copy(self.board)
        other.program = self.program.fork()
        other._signals = copy(self._signals)  # noqa: SLF001  (its own class)
        return other

    @property
    def rpm(self) -> float:
        """The crankshaft's true speed."""
        return self.crank / TO_RADIANS

    @property
    def unit_rpm(self) -> float:
        """The speed by which the unit counts strokes; 0 without supply or crank signal."""
        return self.rpm if self.key and self.program.sensors.rpm > 0 else 0.0

    def step(self) -> None:
        """Advance to the next point of the grid."""
        self.cycles += self.crank * (STEP / TO_RADIANS / 120)
        self.step_number += 1
        self._move(self.step_number)

    def begin(self, lost: LostSignals) -> None:
        """Advance to second 0, with the sensors failed by `lost`: only in a car that is warm."""
        start, program = self._start, self.program
        program.sensors.lost = lost
        if not start.running:
            self._move(0)
            return
        program.phase.run_time = 600.0
        program.phase.air_at_start = start.ambient
        self._settle(range(-BEGINNING, 1))
        program.phase.coolant_at_start = start.coolant_at_start + self._condition.coolant_sensor
        self.cycles = self.fuel_used = 0.0

    def _settle(self, numbers: range) -> None:
        """Run as at second 0 until idle valve, λ loop and speed are steady."""
        for number in numbers:
            self._move(number)
            self.heat.coolant = self._start.coolant

    def _move(self, number: int) -> None:
        """Compute the grid's point `number`."""
        table, program, signals = self._noise, self.program, self._signals
        inputs = self._timeline.at(number * STEP)
        self._turn_key(inputs.key)
        rpm = self.crank / TO_RADIANS
        alive, road = not program.sensors.lost.crank, table[(number * 7 + 4001) % NOISE]
        self.vehicle.drive(inputs, rpm, self.heat.coolant, alive=alive, road=road)
        signals.demand = ph.demand(rpm)
        charge, flow = self._breathe(rpm, signals.demand)
        if inputs.key:
            signals.rpm = rpm
            signals.throttle = self._shown_throttle()
            heard = flow * (1 + 0.006 * table[(number * 3 + 991) % NOISE])
            signals.air = self._shown_air(heard)
            signals.coolant = self._shown_coolant
            signals.intake_air = self.heat.intake_air
            ripple = 0.02 if rpm > 500 else 0.12 if self.vehicle.starter else 0.005
            signals.voltage = self.board.voltage + ripple * table[(number * 5 + 2003) % NOISE]
            program.step(signals, self._burnt, self._knock_limit(rpm, charge, number))
        self._fuel = ph.injected(program.mixture.injection, self.board.voltage)
        if self._fuel > 0:
            self._burnt = min(1.6, charge / (ph.STOICHIOMETRIC * self._fuel))
        self._burning = self._fuel > 0 and self._catches()
        self._turn(rpm, charge, table[number % NOISE])
        if number % SLOW == 0:
            self._warm(rpm, charge)

    @property
    def burnt(self) -> float:
        """λ in the exhaust; infinity while nothing burns: air."""
        return self._burnt if self._burning and self.rpm > 0 else inf

    def _turn_key(self, key: bool) -> None:
        if key and not self.key:
            self.program.restart(self._shown_coolant, self.heat.intake_air)
        elif self.key and not key:
            sensors = self.program.sensors
            self.program.restart(sensors.coolant, sensors.intake_air)
        self.key = key

    def _knock_limit(self, rpm: float, charge: float, number: int) -> float:
        chance = 1.1 * self._noise[(number * 11 + 7001) % NOISE]
        heat = self.heat
        limit = ph.knock_limit(rpm, charge / ph.STROKE_AIR, heat.intake_air, heat.coolant)
        return limit - chance - self._condition.knock

    @property
    def _shown_coolant(self) -> float:
        return self.heat.coolant + self._condition.coolant_sensor

    def _shown_throttle(self) -> float:
        """Return what the throttle's sensor shows: 0 where its track is worn through."""
        opening, dead = self.vehicle.throttle, self._condition.throttle_dead
        return 0.0 if dead is not None and dead[0] <= opening <= dead[1] else opening

    def _shown_air(self, flow: float) -> float:
        """Return what the air meter shows: 0 while its connector has no contact."""
        condition, loose = self._condition, self._condition.air_meter_loose
        if loose is not None and loose[0] <= self.vehicle.throttle <= loose[1]:
            return 0.0
        return max(0.0, flow * condition.air_meter + condition.air_meter_zero)

    def _breathe(self, rpm: float, demand: float) -> tuple[float, float]:
        """Set the manifold's pressure; return mg into a cylinder, kg/h through the air meter.

        Air from a leak enters downstream of the throttle: the engine gets it, the meter does not.
        """
        before = self.manifold
        if demand <= 0.05:
            self.manifold += (1.0 - before) * 0.2
            return 0.0, 0.0
        condition = self._condition
        bypass = self.program.idle.valve * ph.VALVE_FLOW * condition.idle_passage
        metered = ph.throttle_air(self.vehicle.throttle) + bypass
        inlet = metered + condition.leak
        delay = EMPTYING * 120 / (rpm * ph.FILLING(rpm))
        self.manifold += (ph.manifold(inlet, demand) - before) * STEP / (delay + STEP)
        thick = demand * ph.density(self.heat.intake_air)
        taken = self.manifold * thick
        filled = (self.manifold - before) / STEP * delay * thick
        return ph.air_per_stroke(taken, rpm), (taken + filled) * (metered / inlet)

    def _catches(self) -> bool:
        """Return whether the engine fires: a cold one only after some turns."""
        phase = self.program.phase
        if phase.running or self._burning:
            return True
        cold = max(0.0, 60.0 - self.heat.coolant) * 0.03
        return phase.turned > 1.2 + cold + self._condition.fuel_drained / 2

    def _turn(self, rpm: float, charge: float, chance: float) -> None:
        """Apply the torques to crankshaft and wheels."""
        program, car, burning = self.program, self.vehicle, self._burning
        torque = -car.load if rpm > 300 else 0.0
        if burning:
            made = ph.indicated_torque(charge, rpm, self._burnt, program.spark.advance)
            torque += made * (1 + 0.045 * chance)
        elif rpm < 600:
            torque -= 9.0  # lost by compression
        if rpm < 330 and not car.starter:
            torque -= 40.0  # too slow for the flywheel to overcome the compression
        if car.starter:
            pull = 75.0 * (self.board.voltage / 9.5) * self._condition.starter
            torque += max(0.0, pull - 0.22 * rpm)
        torque -= self.board.step(
            rpm,
            car.consumers,
            key=self.key,
            starter=car.starter,
            burning=burning,
            fan=program.fan,
        )
        torque -= ph.friction(rpm) * self._viscosity + ph.pumping(self.manifold)
        self.crank = car.turn(self.crank, torque)
        if self.crank < 3.0 and not car.starter:
            self.crank = 0.0
        self.fuel_used += ph.fuel_flow(self._fuel, rpm) * (STEP / 3600)

    def _warm(self, rpm: float, charge: float) -> None:
        """Advance the temperatures."""
        burnt = ph.fuel_flow(self._fuel, rpm) if self._burning else 0.0
        air = ph.air_flow(charge, rpm)
        self.heat.step(burnt, air, self.vehicle.speed, SLOW * STEP, fan=self.program.fan)
        self._viscosity = ph.VISCOSITY(self.heat.coolant)
