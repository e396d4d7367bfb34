"""The car around the engine and the person in it: speed, gears, clutch, pedal, brakes, starter.

A Volga GAZ-3110 with the five-speed box. The driver follows the scenario's speed; where a scenario
gives throttle or gear itself, its word goes. With both throttle and speed given the car stands on a
rolling road, which holds the speed whatever the engine does.
"""

from __future__ import annotations

from mikas.virtual.model import physics as ph
from mikas.virtual.model.physics import STEP, TO_RADIANS
from mikas.virtual.scenarios.timeline import Inputs

MASS = 1600.0  # kg with a driver
WHEEL = 0.31  # m
RATIOS = (0.0, *(3.9 * gear for gear in (3.618, 2.188, 1.304, 1.0, 0.794)))
UP = (0.0, 18.0, 34.0, 52.0, 72.0, 1e9)  # km/h at which the driver leaves each gear upwards
DOWN = (-1.0, -1.0, 11.0, 25.0, 40.0, 58.0)
SHIFT_TIME = 0.7  # s with the clutch down
CLUTCH = 320.0  # Nm that the closed clutch holds
GRIP = 200.0  # Nm per rad/s of slip: nearly rigid
TOO_FAST = 7000.0 * TO_RADIANS  # so low a gear does not go in
INERTIA = 0.26  # kg·m² of the engine with its flywheel
PATIENCE = 2.0  # s before the driver starts a stalled engine again
STARTER_LIMIT = 6.0  # s in one go
START_DONE = 600.0  # rpm at which the driver lets the key go


def resistance(speed: float) -> float:
    """Rolling and air, N, at `speed` in m/s."""
    return (MASS * 9.81 * 0.014 + 0.5 * speed * speed) if speed > 0 else 0.0


class Vehicle:
    """Body, gearbox and driver. `throttle`, `starter` and `load` are what the engine feels."""

    __slots__ = (
        "_foot",
        "_held",
        "_hill",
        "_shifting",
        "_starting",
        "_stood",
        "_was_running",
        "brake",
        "gear",
        "load",
        "speed",
        "starter",
        "throttle",
    )  # fmt: skip

    def __init__(self, first: Inputs, *, running: bool) -> None:
        self.speed = (first.speed or 0.0) / 3.6
        self.gear = 0
        self.throttle = 0.0
        self.starter = False
        self.load = 0.0
        self.brake = 0.0  # N
        self._foot = 0.0
        self._hill = 0.0  # m/s², the road's ups and downs
        self._held = False  # on a rolling road
        self._shifting = 0.0  # s left
        self._stood = 0.0  # s that the engine has stood still with the key on
        self._starting = 0.0  # s left of the driver's own attempt to start
        self._was_running = running

    def drive(
        self, inputs: Inputs, rpm: float, coolant: float, *, alive: bool, road: float
    ) -> None:
        """One step of the driver. `alive`: it can run at all; `road`: a random number."""
        self.load = inputs.load
        again = self._start_again(inputs, rpm, alive)
        self.starter = inputs.key and rpm < START_DONE and (inputs.starter or again)
        self._held = inputs.speed is not None and inputs.throttle is not None
        self._hill += (road * 0.8 - self._hill) * (STEP / 4)
        wanted = 0.0
        self.brake = 0.0
        if inputs.speed is not None:
            self._choose_gear(inputs, rpm)
            if self._held:
                self.speed = inputs.speed / 3.6
            else:
                wanted = self._follow(inputs, rpm, coolant)
        elif inputs.gear is not None:
            self.gear = inputs.gear
        if inputs.throttle is not None:
            wanted = inputs.throttle
        self._foot += (wanted - self._foot) * (STEP / (0.15 + STEP))
        self.throttle = self._foot if self._foot > 0.3 else 0.0

    def turn(self, omega: float, torque: float) -> float:
        """One step of crankshaft and wheels with `torque` on the crank; the new crank speed."""
        free = omega + torque / INERTIA * STEP
        drag = resistance(self.speed) + self.brake - MASS * self._hill
        ratio = RATIOS[self.gear] if self._shifting <= 0 else 0.0
        wheels = self.speed / WHEEL * ratio  # the wheels' speed as the crankshaft would see it
        if ratio == 0.0 or wheels > TOO_FAST:
            self._roll(-drag)
            return max(0.0, free)
        lever = ratio * 0.93 / WHEEL  # N of drive a Nm
        heavy = 0.0 if self._held else lever * ratio / WHEEL / MASS
        slip = free - wheels + (0.0 if self._held else drag / MASS * ratio / WHEEL * STEP)
        passed = GRIP * slip / (1 + STEP * GRIP * (1 / INERTIA + heavy))
        limit = self._clutch(free, wheels)
        passed = max(-limit, min(limit, passed))
        self._roll(passed * lever - drag)
        return max(0.0, free - passed / INERTIA * STEP)

    def _clutch(self, omega: float, wheels: float) -> float:
        """What the clutch can pass on: all, or what a gentle start or a slow car leaves of it."""
        if wheels > 950 * TO_RADIANS:
            return CLUTCH
        return max(0.0, min(CLUTCH, (omega / TO_RADIANS - 1000) * 0.25))

    def _roll(self, force: float) -> None:
        if not self._held:
            self.speed = max(0.0, self.speed + force / MASS * STEP)

    def _follow(self, inputs: Inputs, rpm: float, coolant: float) -> float:
        """The pedal that brings the car to the speed asked for; the brake likewise."""
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
        elif self._shifting <= -1.0:  # not twice within a second
            rising = goal >= now - 1
            self.gear += (now > UP[old] and rising) - (now < DOWN[old])
        if self.gear != old and self.gear:
            self._shifting = SHIFT_TIME

    def _start_again(self, inputs: Inputs, rpm: float, alive: bool) -> bool:
        """The driver turns the key once more when an engine that was running has died."""
        if not inputs.key:
            self._was_running = False
        if rpm > 500:
            self._was_running, self._stood, self._starting = True, 0.0, 0.0
        elif rpm < 40:
            self._stood += STEP
        if self._was_running and alive and self._stood > PATIENCE:
            self._stood, self._starting = 0.0, STARTER_LIMIT
        self._starting -= STEP
        return self._starting > 0


def pedal(torque: float, rpm: float, coolant: float) -> float:
    """The throttle in % that gives about this torque at the clutch: a driver knows his car."""
    charge = (torque + ph.friction(rpm) * ph.VISCOSITY(coolant) + 8.0) / 0.41 * (rpm + 450) / rpm
    wanted = ph.demand(rpm)
    ratio = charge / (ph.STROKE_AIR * ph.FILLING(rpm))
    return ph.throttle_for(ph.inlet_for(min(0.985, ratio), wanted) - 12.0)
