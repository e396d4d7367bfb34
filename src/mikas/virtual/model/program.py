"""The control unit's program: from sensors to injection, spark and idle valve.

The real unit's program is not public. This one controls what the real one is known to control:
idle speed by the idle valve and a little spark advance, mixture by temperature and a λ loop,
full-power enrichment, fuel cut on overrun and at the speed limit, retard after knock. A tester
reads the attributes of its parts.
"""

from __future__ import annotations

from copy import copy

from mikas.virtual.model import physics as ph
from mikas.virtual.model.physics import STEP, LookupTable
from mikas.virtual.model.sensors import SAFE_RETARD, LostSignals, Sensors, Signals
from mikas.virtual.scenarios.scenario import Condition

# Over coolant °C. The speeds are those of the facts about the car: 850 warm, 1100 to 1500 cold.
TARGET_SPEED = LookupTable(
    {-40: 1500, -20: 1450, 0: 1330, 20: 1200, 40: 1060, 60: 930, 75: 860, 80: 850}, 5
)
IDLE_AIR = LookupTable(
    {-40: 44, -20: 38, 0: 29, 20: 22.5, 40: 18.5, 60: 16, 80: 14.5, 100: 14.2}, 5
)
START_AIR = LookupTable({-40: 60, -20: 48, 0: 38, 20: 31, 60: 23, 90: 18.5}, 5)
CRANKING_MIXTURE = LookupTable({-40: 0.52, -20: 0.58, 0: 0.68, 20: 0.78, 60: 0.88, 90: 0.93}, 5)
WARM_UP_MIXTURE = LookupTable(
    {-40: 0.74, -20: 0.80, 0: 0.86, 20: 0.91, 40: 0.96, 60: 1.0, 100: 1.0}, 5
)
START_SPEED = 480.0  # rpm at which starting is over
TABLES_PERIOD = 16  # steps between two look-ups in the tables


class Phase:
    """Standing, starting or running, and the tables' values at the present coolant temperature.

    `turned`: engine cycles since the crankshaft began to turn; `run_time`: seconds of running;
    `after_start` falls from 1 to 0 after a start.
    """

    __slots__ = (
        "_idle_target", "_tables_in", "after_start", "air_at_start", "coolant_at_start",
        "cranking_mixture", "idle_air", "run_time", "running", "start_air", "target_speed",
        "turned", "warm_up_mixture",
    )  # fmt: skip

    def __init__(self, coolant: float, intake_air: float, idle_target: float = 0.0) -> None:
        self._idle_target = idle_target  # rpm above the table
        self.coolant_at_start: float = coolant
        self.air_at_start: float = intake_air
        self.running: bool = False
        self.turned = self.run_time = self.after_start = 0.0
        self._read_tables(coolant)

    def step(self, sensors: Sensors) -> None:
        """Advance one step."""
        rpm = sensors.rpm
        if rpm == 0:
            self.turned = self.run_time = 0.0
            self.running = False
        else:
            if self.turned == 0:
                self.air_at_start = sensors.intake_air
                self.coolant_at_start = sensors.coolant
            self.turned += rpm / 120 * STEP
            if rpm > START_SPEED and not self.running:
                self.running = True
                self.after_start = 1.0
        if self.running:
            self.run_time += STEP
            lasting = 6 + 0.25 * max(0.0, 60 - sensors.coolant)
            self.after_start -= self.after_start * STEP / lasting
        if self._tables_in == 0:
            self._read_tables(sensors.coolant)
        self._tables_in -= 1

    def _read_tables(self, coolant: float) -> None:
        self._tables_in = TABLES_PERIOD
        self.target_speed = TARGET_SPEED(coolant) + self._idle_target
        self.idle_air = IDLE_AIR(coolant)
        self.start_air = START_AIR(coolant)
        self.cranking_mixture = CRANKING_MIXTURE(coolant)
        self.warm_up_mixture = WARM_UP_MIXTURE(coolant)


CLOSED = 1.0  # % below which the throttle counts as closed
FAN_AIR = 0.8  # kg/h more while the fan loads the alternator
FASTEST = 3.0  # valve steps a grid step


class IdleControl:
    """Idle speed by air: a set air flow, and the position of the idle valve for that flow.

    The speed's error changes the set air flow, the air's error the valve's set position. The valve
    follows with a lag, at most 96 steps a second. `idle`: the engine idles; `air_set` in kg/h;
    `valve_set` and `valve` in steps.
    """

    __slots__ = ("_air_trim", "_speed_trim", "_sticks", "air_set", "idle", "valve", "valve_set")

    def __init__(self, phase: Phase, valve: float, sticks: float = 0.0) -> None:
        self._sticks = sticks  # steps; the valve moves only when it is further off
        self.idle: bool = False
        self.air_set: float = phase.start_air
        self.valve_set = self.valve = valve
        self._speed_trim = self._air_trim = 0.0

    def step(self, sensors: Sensors, phase: Phase, *, fan: bool) -> None:
        """Advance one step."""
        closed = sensors.throttle < CLOSED
        error = phase.target_speed - sensors.rpm
        self.idle = phase.running and closed and error > -600
        if not phase.running:
            self._speed_trim = 0.0
            goal = phase.start_air
        else:
            goal = phase.idle_air + phase.after_start * 5 + self._speed_trim + FAN_AIR * fan
            if self.idle:
                goal += max(-1.2, min(5.0, 0.012 * error))
                if error < 400 and phase.run_time > 3:
                    self._learn(error, sensors.air)
            elif not closed:
                goal += min(8.0, 1.2 * sensors.throttle)  # dashpot: air for the moment of closing
        self.air_set += (goal - self.air_set) * STEP / (0.15 + STEP)
        flow = self.air_set / ph.density(sensors.intake_air) - ph.THROTTLE_LEAK
        self.valve_set = max(0.0, min(255.0, flow / ph.VALVE_FLOW + self._air_trim))
        off = self.valve_set - self.valve
        if abs(off) > self._sticks:
            self.valve += max(-FASTEST, min(FASTEST, off * 0.3))

    def _learn(self, error: float, air: float) -> None:
        limited = min(120.0, error) if error > -250 else -20.0  # above: it may be coasting
        change = max(-60.0, limited) * 0.008 * STEP
        self._speed_trim = max(-8.0, min(12.0, self._speed_trim + change))
        if abs(error) < 120:
            off = max(-5.0, min(5.0, self.air_set - air))
            self._air_trim = max(-30.0, min(60.0, self._air_trim + 0.8 * off * STEP))


LEANEST, RICHEST = 1.49, 0.5  # the range of VALF (§4)
FULL_POWER = 0.88
TRIM_LIMIT = 0.25
LIMIT, LIMIT_BACK = 6120.0, 6000.0  # rpm: fuel off and on again
OVERRUN, OVERRUN_BACK = 1900.0, 1450.0  # rpm of a warm engine; a cold one's are higher


class MixtureControl:
    """Mixture and injection: tables, λ loop, full power, and the two fuel cuts.

    `mixture` is λ, `trim` the λ loop's share, `fuel` mg a stroke, `injection` ms.
    """

    __slots__ = (
        "_exhaust", "_last_rpm", "_last_throttle", "_limited", "_overrun", "_tip_in", "fuel",
        "full_power", "injection", "mixture", "trim",
    )  # fmt: skip

    def __init__(self, phase: Phase) -> None:
        self.mixture: float = phase.cranking_mixture
        self.trim: float = 0.0
        self.fuel: float = 0.0
        self.injection: float = 0.0
        self.full_power: bool = False
        self._exhaust = 1.0  # λ at the probe, delayed and averaged
        self._tip_in = self._last_throttle = self._last_rpm = 0.0
        self._overrun = self._limited = False

    def step(
        self, sensors: Sensors, phase: Phase, demand: float, burnt: float, *, idle: bool
    ) -> None:
        """Advance one step. `demand`: air with the throttle wide open; `burnt`: the true λ."""
        self._watch_throttle(sensors, phase, demand)
        self._watch_speed(sensors, phase)
        if phase.running:
            self._set_mixture(sensors, phase, burnt, idle=idle)
        else:
            self.mixture = phase.cranking_mixture
        cut = self._overrun or self._limited
        self.fuel = 0.0
        if cut:
            self.mixture = LEANEST
        elif phase.turned > 0.7:  # after the tooth gap: the crank angle is known
            counted = ph.air_per_stroke(sensors.air, sensors.rpm)
            self.fuel = counted / (ph.STOICHIOMETRIC * self.mixture)
        self.injection = ph.injection(self.fuel, sensors.voltage)

    def _watch_throttle(self, sensors: Sensors, phase: Phase, demand: float) -> None:
        opening = (sensors.throttle - self._last_throttle) / STEP  # % a second
        self._last_throttle = sensors.throttle
        self._tip_in = max(self._tip_in * 0.93, min(0.12, max(0.0, opening - 15) * 0.0012))
        breathing = sensors.air > 0.8 * demand and sensors.rpm > 1000
        self.full_power = phase.running and (
            sensors.throttle > (65 if self.full_power else 70)
            or (breathing and sensors.throttle > 45)
        )

    def _watch_speed(self, sensors: Sensors, phase: Phase) -> None:
        rpm = sensors.rpm
        soon = 2 * rpm - self._last_rpm
        self._last_rpm = rpm
        self._limited = soon > (LIMIT_BACK if self._limited else LIMIT)
        floor = (OVERRUN_BACK if self._overrun else OVERRUN) + phase.target_speed - 850
        closed = sensors.throttle < 1.0
        self._overrun = phase.running and closed and rpm > floor and phase.run_time > 8

    def _set_mixture(self, sensors: Sensors, phase: Phase, burnt: float, *, idle: bool) -> None:
        mixture = phase.warm_up_mixture - 0.12 * phase.after_start - self._tip_in
        if self.full_power:
            mixture = min(mixture, FULL_POWER)
        warm = sensors.coolant > 45 and phase.run_time > 25
        if warm and not (self.full_power or self._overrun or self._limited):
            self._regulate(sensors.air, burnt)
        else:
            self.trim -= self.trim * STEP / 3
            if idle:
                mixture /= 1 + sensors.idle_co
        self.mixture = max(RICHEST, min(LEANEST, mixture / (1 + self.trim)))

    def _regulate(self, air: float, burnt: float) -> None:
        """Two-point control: richer while the probe reads lean, leaner while it reads rich."""
        self._exhaust += (burnt - self._exhaust) * min(0.5, STEP * (0.7 + air / 25))
        slope = (0.012 + air * 0.0004) * STEP
        change = slope if self._exhaust > 1.0 else -slope
        self.trim = max(-TRIM_LIMIT, min(TRIM_LIMIT, self.trim + change))


CRANKING = 6.0  # °
LATEST = -12.0  # most retard by knock
KNOCK_STEP, KNOCK_BACK = -3.0, 0.8  # ° at once; ° a second
KNOCK_SHOWN = 0.125  # s that the flag is set
KNOCK_FILLING = 0.55  # filling below which knock is not detected


class SparkControl:
    """Ignition advance: from the table, corrected for idle speed and after knock.

    `advance` contains `correction` (negative, after knock).
    """

    __slots__ = ("_idle", "_shown", "advance", "correction", "knock", "knock_corrected")

    def __init__(self, idle: float) -> None:
        self._idle = idle  # ° at the set speed
        self._reset()

    def _reset(self) -> None:
        self.advance: float = CRANKING
        self.correction: float = 0.0
        self.knock: bool = False
        self.knock_corrected: bool = False
        self._shown = 0.0

    def step(self, sensors: Sensors, phase: Phase, limit: float, *, firing: bool) -> None:
        """Advance one step. `limit`: the advance at which the engine knocks now."""
        if not phase.running:
            self._reset()
            return
        filling = min(1.0, ph.air_per_stroke(sensors.air, sensors.rpm) / ph.STROKE_AIR)
        self._control_knock(sensors, limit if firing else 90.0, filling)
        if sensors.throttle < 1.0:
            error = phase.target_speed - sensors.rpm
            goal = self._idle + max(-2.8, min(2.8, 0.05 * error))
            goal += max(0.0, min(16.0, -0.015 * (error + 150)))  # coasting
        else:
            goal = min(42.0, ph.base_advance(sensors.rpm, filling))
        goal += self.correction
        self.advance += max(-3.0, min(2.0, goal - self.advance))  # per step: 96 and 64 °/s

    def _control_knock(self, sensors: Sensors, limit: float, filling: float) -> None:
        if sensors.lost.knock:
            self.knock = self.knock_corrected = False
            self.correction = SAFE_RETARD if filling > KNOCK_FILLING else 0.0
            return
        self._shown -= STEP
        self.correction = min(0.0, self.correction + KNOCK_BACK * STEP)
        if filling > KNOCK_FILLING and self._shown <= 0 and self.advance > limit:
            self.correction = max(LATEST, self.correction + KNOCK_STEP)
            self._shown = KNOCK_SHOWN
        self.knock = self._shown > 0
        self.knock_corrected = self.correction < -0.25


FAN_ON, FAN_OFF = 93.5, 88.5  # °C
PARKED = 40.0  # position of the idle valve before it is first driven


class Program:
    """One control unit."""

    __slots__ = ("_condition", "fan", "idle", "mixture", "phase", "sensors", "spark")

    def __init__(
        self, lost: LostSignals, coolant: float, intake_air: float, condition: Condition
    ) -> None:
        self._condition = condition
        self._begin(lost, coolant, intake_air, PARKED)

    def _begin(self, lost: LostSignals, coolant: float, intake_air: float, valve: float) -> None:
        self.fan: bool = False
        self.sensors: Sensors = Sensors(lost, coolant, intake_air)
        self.phase: Phase = Phase(coolant, intake_air, self._condition.idle_target)
        self.idle: IdleControl = IdleControl(self.phase, valve, self._condition.idle_valve)
        self.mixture: MixtureControl = MixtureControl(self.phase)
        self.spark: SparkControl = SparkControl(self._condition.idle_advance)

    def fork(self) -> Program:
        """Return an independent copy."""
        other = copy(self)
        for part in ("sensors", "phase", "idle", "mixture", "spark"):
            setattr(other, part, copy(getattr(self, part)))
        return other

    def restart(self, coolant: float, intake_air: float) -> None:
        """Begin again with the key on, or stop with it off; the valve keeps its position."""
        self._begin(self.sensors.lost, coolant, intake_air, self.idle.valve)

    def step(self, signals: Signals, burnt: float, knock_limit: float) -> None:
        """Advance one step: read the sensors, set all outputs.

        `burnt`: the true λ; `knock_limit`: the advance at which the engine knocks.
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
