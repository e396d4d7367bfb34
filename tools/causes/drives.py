"""Draw drivers and their drives: calm, hurried and hard ones, town and open road, pulls, blips.

Most of a drive is a speed that the model's driver follows. A driver of a hard temper also acts by
the pedal alone: the pedal to the floor in a gear, from low revs and from high ones (`Pull`); any
may blip the throttle standing.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields
from random import Random

from mikas.virtual.scenarios.scenario import Start
from mikas.virtual.scenarios.timeline import Inputs, ScenarioTimeline, Track

Points = list[tuple[float, float]]

PULLS: tuple[tuple[int, float, float], ...] = (
    # gear, km/h at which the pedal goes down, at most so many seconds
    (2, 22.0, 4.0), (2, 40.0, 3.0), (3, 35.0, 6.0), (3, 62.0, 5.0), (4, 45.0, 8.0), (4, 80.0, 7.0),
    (5, 60.0, 9.0),
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class PedalAct:
    """The pedal held by the foot alone for a while, in a gear."""

    begin: float
    end: float
    throttle: float  # %
    gear: int


@dataclass(frozen=True)
class PedalTimeline(ScenarioTimeline):
    """A timeline in which the driver now and then acts by the pedal, not by a speed."""

    acts: tuple[PedalAct, ...] = ()

    def at(self, time: float) -> Inputs:
        """Return the inputs at `time`; in an act those of the pedal."""
        inputs = super().at(time)
        for act in self.acts:
            if act.begin <= time < act.end:
                return inputs._replace(throttle=act.throttle, gear=act.gear, speed=None)
        return inputs


@dataclass(frozen=True, slots=True)
class Driver:
    """How somebody drives."""

    temper: float  # of accelerations and brakes, 1: usual
    floors: float  # how often an acceleration is a pull with the pedal to the floor
    open_road: float  # share of fast stretches
    stops: float  # share of stops
    nervous: float  # km/h by which the speed is never held


def driver_of(random: Random) -> Driver:
    """Return a driver: two in five are hard ones, who floor the pedal."""
    hard = random.random() < 0.4
    return Driver(
        temper=random.uniform(1.0, 2.0) if hard else random.uniform(0.5, 1.3),
        floors=random.uniform(0.2, 0.6) if hard else 0.0,
        open_road=random.choice((0.0, random.uniform(0.1, 0.8), random.uniform(0.2, 0.7))),
        stops=random.uniform(0.15, 0.45),
        nervous=random.choice((0.0, 0.0, random.uniform(0.5, 3.0))),
    )


def drive_of(kind: str, random: Random) -> tuple[ScenarioTimeline, Start]:
    """Return a driver's actions and the car at second 0."""
    ambient = random.uniform(-18.0, 35.0)
    consumers = _steps(random, 900.0, lambda: random.choice((0, 0, 6, 12, 20, 28)))
    if kind == "idle":
        seconds = random.uniform(175.0, 220.0)
        if random.random() < 0.6:
            start = _running(random, ambient)
            return _timeline(seconds, 0.0, consumers, [(0, 0.0)], ()), start
        start = _standing(ambient, random.uniform(70.0, 90.0))
        starter = random.uniform(2, 5)
        return _timeline(seconds, starter, consumers, [(0, 0.0)], ()), start
    if kind == "start":
        coolant = random.choice((ambient, random.uniform(45.0, 88.0)))
        starter = random.uniform(2, 5)
        return _timeline(120.0, starter, consumers, [(0, 0.0)], ()), _standing(ambient, coolant)
    if kind == "warm-up":
        starter = random.uniform(2, 5)
        return _timeline(600.0, starter, consumers, [(0, 0.0)], ()), _standing(ambient, ambient)
    turn = random.random()
    begin, starter = 0.0, 0.0
    if kind in ("whole", "pull"):  # with the start of the engine
        turn *= 0.75
    if turn < 0.45 and kind != "pull":
        start = _standing(ambient, ambient)
    elif turn < 0.75:
        start = _standing(ambient, random.uniform(45.0, 88.0))
    else:
        start = _running(random, ambient)
    if not start.running:
        starter = random.uniform(2.0, 5.0)
        begin = starter + random.uniform(12.0, 60.0)
    driver = driver_of(random)
    if kind == "pull":  # what the measurement asks for
        driver = Driver(1.5, 0.6, 0.5, 0.2, 0.0)
    end = 1300.0 if kind == "long" else random.uniform(660.0, 820.0)
    speed, acts = _journey(random, driver, begin, end)
    return _timeline(speed[-1][0] + random.uniform(30, 60), starter, consumers, speed, acts), start


def _standing(ambient: float, coolant: float) -> Start:
    return Start(ambient=ambient, coolant=coolant, coolant_at_start=coolant)


def _running(random: Random, ambient: float) -> Start:
    return Start(ambient=ambient, coolant=random.uniform(80.0, 91.0), coolant_at_start=ambient,
                 running=True)  # fmt: skip


def _timeline(
    duration: float, starter: float, consumers: Track, speed: Points, acts: tuple[PedalAct, ...]
) -> ScenarioTimeline:
    turning = (0.0, starter, starter + 7.0) if starter else (0.0,)
    plain = ScenarioTimeline(
        duration=duration, loops=False, loop_from=0.0, key=Track((0.0,), (1.0,), smooth=False),
        starter=Track(turning, (0.0, 1.0, 0.0)[: len(turning)], smooth=False),
        load=Track((0.0,), (0.0,), smooth=False), consumers=consumers,
        speed=Track(tuple(t for t, _ in speed), tuple(v for _, v in speed)),
    )  # fmt: skip
    return PedalTimeline(
        **{each.name: getattr(plain, each.name) for each in fields(plain)}, acts=acts
    )


def _steps(random: Random, seconds: float, draw: Callable[[], float]) -> Track:
    times, time = [0.0], 0.0
    while time < seconds:
        time += random.uniform(40.0, 250.0)
        times.append(time)
    return Track(tuple(times), tuple(float(draw()) for _ in times), smooth=False)


def _journey(
    random: Random, driver: Driver, begin: float, end: float
) -> tuple[Points, tuple[PedalAct, ...]]:
    """Return speeds over time, and what the foot does: lights, streets and an open road."""
    points: Points = [(0.0, 0.0), (begin + 0.1, 0.0)]
    acts: list[PedalAct] = []
    time, now = begin + 0.1, 0.0
    while time < end:
        here = random.random()
        if here < driver.stops and now > 0:
            goal, stay = 0.0, random.uniform(6.0, 40.0)
        elif here < driver.stops + driver.open_road * 0.5:
            goal, stay = random.uniform(70.0, 118.0), random.uniform(15.0, 60.0)
        else:
            goal, stay = random.uniform(18.0, 65.0), random.uniform(8.0, 30.0)
        if goal > now + 10 and random.random() < driver.floors:
            time, now = _pull(random, points, acts, time, now)
        rate = driver.temper * (random.uniform(2.0, 4.0) if goal > now else random.uniform(3, 7))
        time += max(2.0, abs(goal - now) / rate)
        points.append((time, goal))
        if goal > 20 and driver.nervous:
            for second in range(3, int(stay), 3):
                points.append((time + second, goal + random.uniform(-1, 1) * driver.nervous))
        time, now = time + stay, goal
        points.append((time, goal))
        if goal == 0.0 and random.random() < 0.15:
            acts.append(PedalAct(time - 3.0, time - 3.0 + random.uniform(0.4, 1.5),
                            random.uniform(4.0, 25.0), 0))  # fmt: skip
    if now:
        time += now / 5.0 + 2.0
        points.append((time, 0.0))
    return [*points, (time + random.uniform(40.0, 90.0), 0.0)], tuple(acts)


def _pull(
    random: Random, points: Points, acts: list[PedalAct], time: float, now: float
) -> tuple[float, float]:
    """Add a pull from about this speed; return when it ends, and about at which speed."""
    gear, from_speed, longest = random.choice(PULLS)
    if abs(from_speed - now) > 1:
        time += max(2.0, abs(from_speed - now) / random.uniform(3.0, 6.0))
        points.append((time, from_speed))
    time += 2.0
    points.append((time, from_speed))
    seconds = longest * random.uniform(0.6, 1.0)
    acts.append(PedalAct(time, time + seconds, 100.0, gear))
    # About 2.4 m/s² in the second gear, less in higher ones.
    reached = from_speed + 3.6 * {2: 2.4, 3: 1.7, 4: 1.2, 5: 0.8}[gear] * seconds
    end = time + seconds
    points += [(time + 0.1, from_speed + 1), (end, reached), (end + 2, reached)]
    return end + 2, reached
