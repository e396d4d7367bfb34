"""The car around the engine, and its driver.

Cooling, intake air, battery and alternator are first-order balances: 60 kJ/K of iron and water
heated by a share of the petrol's heat, cooled through thermostat, radiator, fan and wind; a 12 V
battery with its inner resistance; an alternator that gives little at idle.

The car is a Volga GAZ-3110 with the five-speed box. The driver follows the scenario's speed, unless
the scenario gives throttle or gear. With both throttle and speed given, the car stands on a rolling
road, which holds the speed whatever the engine does.
"""

from __future__ import annotations

from dataclasses import dataclass

from mikas.virtual.model import physics as ph
from mikas.virtual.model.physics import STEP, TO_RADIANS
from mikas.virtual.scenarios.scenario import Condition, Start
from mikas.virtual.scenarios.timeline import Inputs

HEAT_CAPACITY = 60e3  # J/K
TO_COOLANT = 0.29  # share of the petrol's heat
BOILING = 112.0  # °C under the cap's pressure; steam then takes the heat away
FLAT = 5.5  # V: below this the starter only clicks
EMPTYING = 0.02  # V that a battery loses with each Ah
THERMOSTAT = (80.0, 92.0)  # °C: begins to open, fully open


class Heat:
    """Temperatures: `coolant`, and `intake_air` at its sensor."""

    __slots__ = ("_condition", "ambient", "coolant", "intake_air")

    def __init__(self, start: Start, condition: Condition) -> None:
        self._condition = condition
        self.ambient: float = start.ambient
        self.coolant: float = start.coolant
        self.intake_air: float = self._steady_air(14.0, 0.0) if start.running else start.ambient

    def step(self, fuel: float, air: float, speed: float, seconds: float, *, fan: bool) -> None:
        """Advance by `seconds` with `fuel` in l/h, `air` in kg/h, `speed` in m/s."""
        burnt = fuel * ph.PETROL / 3600 * ph.PETROL_HEAT * 1e6  # W
        open_share = (self.coolant - THERMOSTAT[0]) / (THERMOSTAT[1] - THERMOSTAT[0])
        radiator = max(self._condition.thermostat, min(1.0, open_share)) * (
            12 + (110 if fan else 0) + 28 * speed
        )
        radiator *= self._condition.radiator
        lost = (self.coolant - self.ambient) * (16 + 1.2 * speed + radiator)
        lost += max(0.0, self.coolant - BOILING) * 4000
        self.coolant += (burnt * TO_COOLANT - lost) / HEAT_CAPACITY * seconds
        lag = 3000 / (12 + air + 4 * speed)
        self.intake_air += (self._steady_air(air, speed) - self.intake_air) * seconds / lag

    def _steady_air(self, air: float, speed: float) -> float:
        """Return the temperature of air past a hot engine: the lower, the more air flows."""
        soak = 0.42 / (1 + speed / 6 + air / 80)
        return self.ambient + soak * (self.coolant - self.ambient)


class Board:
    """Battery and alternator: the board's voltage."""

    __slots__ = ("_condition", "_deficit", "_resistance", "_rest", "voltage")

    def __init__(self, start: Start, condition: Condition) -> None:
        self._condition = condition
        cold = max(0.0, 20.0 - start.ambient)
        self._resistance = 0.0125 * (1 + 0.006 * cold) / start.battery  # Ohm
        self._rest = 12.75 - 0.006 * cold - 0.8 * (1 - start.battery)
        self._rest -= EMPTYING * start.discharged
        self._deficit = 0.0 if start.running else 1.0  # Ah to recharge
        self._deficit += start.discharged
        self.voltage: float = 14.0 if start.running else self._rest

    def step(
        self, rpm: float, consumers: float, *, key: bool, starter: bool, burning: bool, fan: bool
    ) -> float:
        """Advance one step; return the alternator's torque on the crankshaft, Nm."""
        used = (9.0 if key else 0.1) + (14.0 if burning else 0.0) + (13.0 if fan else 0.0)
        used += consumers
        torque = 0.0
        if rpm > 500 and key and not starter:
            supply = min(65.0, 34.0 + (rpm - 850) * 0.018)
            supply *= self._condition.alternator
            charge = min(20.0, 2.0 + 12.0 * self._deficit)
            lack = max(0.0, used + charge - supply)
            goal = self._condition.regulator - 0.04 * lack - 0.004 * (used - 20)
            if supply < used and self._condition.alternator < 1:  # the battery gives the rest
                charge = supply - used
                goal = self._rest + self._resistance * charge - EMPTYING * self._deficit
            self._deficit = max(0.0, self._deficit - charge * STEP / 3600)
            torque = min(supply, used + charge) * goal / 0.55 / (rpm * ph.TO_RADIANS)
        else:
            current = used + (max(120.0, 330.0 - 0.6 * rpm) if starter else 0.0)
            goal = max(FLAT, self._rest - self._resistance * current)
            self._deficit += current * STEP / 3600
        self.voltage += (goal - self.voltage) * STEP / (0.09 + STEP)
        return torque


MASS = 1600.0  # kg with a driver
WHEEL = 0.31  # m
RATIOS = (0.0, *(3.9 * gear for gear in (3.618, 2.188, 1.304, 1.0, 0.794)))
UP = (0.0, 18.0, 34.0, 52.0, 72.0, 1e9)  # km/h at which the driver leaves each gear upwards
DOWN = (-1.0, -1.0, 11.0, 25.0, 40.0, 58.0)
SHIFT_TIME = 0.7  # s with the clutch down
CLUTCH = 320.0  # Nm that the closed clutch holds
GRIP = 200.0  # Nm per rad/s of slip: nearly rigid
TOO_FAST = 7000.0 * TO_RADIANS  # crankshaft speed above which a gear is not engaged
INERTIA = 0.26  # kg·m² of the engine with its flywheel
PATIENCE = 2.0  # s before the driver starts a stalled engine again
STARTER_LIMIT = 6.0  # s of one attempt
START_DONE = 600.0  # rpm at which the driver releases the key


def resistance(speed: float) -> float:
    """Return rolling and air resistance in N at `speed` in m/s."""
    return (MASS * 9.81 * 0.014 + 0.5 * speed * speed) if speed > 0 else 0.0


@dataclass(slots=True, eq=False)
class Vehicle:
    """Body, gearbox and driver. `throttle`, `starter`, `load`, `consumers` act on the engine."""

    speed: float  # m/s
    _was_running: bool
    _stops: tuple[float, float]  # % between which the throttle can move
    gear: int = 0
    throttle: float = 0.0
    starter: bool = False
    load: float = 0.0
    consumers: float = 0.0  # A
    brake: float = 0.0  # N
    _foot: float = 0.0
    _hill: float = 0.0  # m/s², the road's ups and downs
    _rolling_road: bool = False
    _shifting: float = 0.0  # s left
    _stalled: float = 0.0  # s that the engine has stood with the key on
    _starting: float = 0.0  # s left of the driver's own attempt to start

    def drive(
        self, inputs: Inputs, rpm: float, coolant: float, *, alive: bool, road: float
    ) -> None:
        """Advance the driver one step. `alive`: the engine can run; `road`: a random number."""
        self.load, self.consumers = inputs.load, inputs.consumers
        restart = self._restart(inputs, rpm, alive)
        self.starter = inputs.key and rpm < START_DONE and (inputs.starter or restart)
        self._rolling_road = inputs.speed is not None and inputs.throttle is not None
        self._hill += (road * 0.8 - self._hill) * (STEP / 4)
        goal = 0.0
        self.brake = 0.0
        if inputs.speed is not None:
            self._choose_gear(inputs, rpm)
            if self._rolling_road:
                self.speed = inputs.speed / 3.6
            else:
                goal = self._follow(inputs, rpm, coolant)
        elif inputs.gear is not None:
            self.gear = inputs.gear
        if inputs.throttle is not None:
            goal = inputs.throttle
        self._foot += (goal - self._foot) * (STEP / (0.15 + STEP))
        closed, widest = self._stops
        self.throttle = max(closed, min(widest, self._foot if self._foot > 0.3 else 0.0))

    def turn(self, omega: float, torque: float) -> float:
        """Advance crankshaft and wheels one step under `torque`; return the crank speed."""
        free = omega + torque / INERTIA * STEP
        drag = resistance(self.speed) + self.brake - MASS * self._hill
        ratio = RATIOS[self.gear] if self._shifting <= 0 else 0.0
        wheels = self.speed / WHEEL * ratio  # their speed at the crankshaft
        if ratio == 0.0 or wheels > TOO_FAST:
            self._roll(-drag)
            return max(0.0, free)
        lever = ratio * 0.93 / WHEEL  # N of drive a Nm
        heavy = 0.0 if self._rolling_road else lever * ratio / WHEEL / MASS
        slip = free - wheels + (0.0 if self._rolling_road else drag / MASS * ratio / WHEEL * STEP)
        passed = GRIP * slip / (1 + STEP * GRIP * (1 / INERTIA + heavy))
        limit = self._clutch(free, wheels)
        passed = max(-limit, min(limit, passed))
        self._roll(passed * lever - drag)
        return max(0.0, free - passed / INERTIA * STEP)

    def _clutch(self, omega: float, wheels: float) -> float:
        """Return the most torque of the clutch: less at a gentle start or a slow speed."""
        if wheels > 950 * TO_RADIANS:
            return CLUTCH
        return max(0.0, min(CLUTCH, (omega / TO_RADIANS - 1000) * 0.25))

    def _roll(self, force: float) -> None:
        if not self._rolling_road:
            self.speed = max(0.0, self.speed + force / MASS * STEP)

    def _follow(self, inputs: Inputs, rpm: float, coolant: float) -> float:
        """Return the pedal for the scenario's speed; set the brake likewise."""
        goal = inputs.soon / 3.6
        push = max(-2.6, min(2.0, (goal - self.speed) / 1.2))
        if goal < 0.3 and self.speed < 0.5:
            self.brake = 4000.0
            return 0.0
        force = MASS * (push - 0.5 * self._hill) + resistance(self.speed)
        ratio = RATIOS[self.gear]
        torque = force * WHEEL / ratio / 0.93 if ratio else 0.0
        if torque < 4 or self._shifting > 0 or not inputs.key:
            engine = 30.0 * ratio / WHEEL if ratio and rpm > 950 else 0.0
            self.brake = max(0.0, -MASS * push - resistance(self.speed) - engine)
            return 0.0
        return pedal(torque, max(rpm, 1000.0), coolant)

    def _choose_gear(self, inputs: Inputs, rpm: float) -> None:
        self._shifting -= STEP
        old = self.gear
        now, goal = self.speed * 3.6, inputs.soon
        if inputs.gear is not None:
            self.gear = inputs.gear
        elif (goal < 1 and now < 9) or rpm < 500:
            self.gear = 0
        elif old == 0:
            self.gear = next(g for g in (5, 4, 3, 2, 1) if now >= DOWN[g])
        elif self._shifting <= -1.0:  # at most once a second
            rising = goal >= now - 1
            self.gear += (now > UP[old] and rising) - (now < DOWN[old])
        if self.gear != old and self.gear:
            self._shifting = SHIFT_TIME

    def _restart(self, inputs: Inputs, rpm: float, alive: bool) -> bool:
        """Return whether the driver turns the key again, because a running engine has died."""
        if not inputs.key:
            self._was_running = False
        if rpm > 500:
            self._was_running, self._stalled, self._starting = True, 0.0, 0.0
        elif rpm < 40:
            self._stalled += STEP
        if self._was_running and alive and self._stalled > PATIENCE:
            self._stalled, self._starting = 0.0, STARTER_LIMIT
        self._starting -= STEP
        return self._starting > 0


def pedal(torque: float, rpm: float, coolant: float) -> float:
    """Return the throttle in % that gives about this torque at the clutch."""
    charge = (torque + ph.friction(rpm) * ph.VISCOSITY(coolant) + 8.0) / 0.41 * (rpm + 450) / rpm
    demand = ph.demand(rpm)
    ratio = charge / (ph.STROKE_AIR * ph.FILLING(rpm))
    return ph.throttle_for(ph.inlet_for(min(0.985, ratio), demand) - 12.0)
