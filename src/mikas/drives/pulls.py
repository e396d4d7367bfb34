"""Power and torque at the wheels from a measured pull: full throttle in one gear, uphill of speed.

    power = speed · (mass · rotating · acceleration + mass · g · (rolling + slope) + drag · speed²)

The speed is the crankshaft's in a known gear, or the one of a GPS receiver. Each figure has its
doubt: the square root of the squares of what mass, slope, drag, gear and the fit may be wrong by.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from math import hypot, pi
from typing import TYPE_CHECKING, Final

import numpy as np

from mikas.catalog.ignition_only import RUNNING
from mikas.catalog.instrument_channels import is_labelled
from mikas.drives.curves import PAUSE, SampledCurve, sampled_curve
from mikas.drives.finding import SPEED, instrument_curve, session_rows
from mikas.errors import usage_error
from mikas.i18n import Text
from mikas.recording.exchanges.arrays import Floats

if TYPE_CHECKING:
    from mikas.recording.recording import Recording

GRAVITY: Final = 9.81
_AIR: Final = 1.2  # kg/m³
_RADIUS: Final = 0.31  # m of a wheel, for the share of what rotates
FULL_THROTTLE: Final = 60.0  # %
LEAST_RISE: Final = 1000.0  # rpm
LEAST_LENGTH: Final = 2.5  # s
SLIPS: Final = 0.12  # of the gear, from which the clutch slips or the receiver is too slow
_FALL: Final = 120.0  # rpm below the highest one so far: the pull is over
_SLOWEST: Final = 60.0  # rpm a second
_BIN: Final = 250.0  # rpm of a row
_FIT: Final = {"FREQ": 1.2, SPEED: 3.2}
"""Seconds over which the acceleration is fitted."""
_MASS_DOUBT, _ROTATING_DOUBT, _SLOPE_DOUBT, _DRAG_DOUBT = 0.03, 0.04, 0.005, 0.15
_MASSES, _GEAR_SPEEDS = (400.0, 20_000.0), (2.0, 80.0)
_DRAG_AREAS, _SLOPES = (0.1, 20.0), (-30.0, 30.0)
_SCALE_DOUBT: Final = {"FREQ": 0.02, SPEED: 0.005}


@dataclass(frozen=True, slots=True)
class PullSettings:
    """The car. `mass`: kg, with driver and load. `per_1000`: km/h at 1000 rpm in the gear of the
    pull; None: a GPS receiver measured the speed.

    `drag_area`: m², the front by its coefficient. `rolling`: of the weight. `slope`: of the road,
    up is positive; 0.01 is 1 %. `rotating`: the inertia of all that turns, as a factor of the mass;
    None: by the gear (1.04 + 0.0025 · ratio², Gillespie).

    Raises `UsageError` for figures that no car and no road has: tonnes in place of kg.
    """

    mass: float
    per_1000: float | None = None
    drag_area: float = 0.9
    rolling: float = 0.014
    slope: float = 0.0
    rotating: float | None = None

    def __post_init__(self) -> None:
        _check(
            self.mass,
            *_MASSES,
            Text("Mass with driver and load, kg", "Масса с водителем и грузом, кг"),
        )
        if self.per_1000 is not None:
            speed = Text("Speed at 1000 rpm, km/h", "Скорость при 1000 об/мин, км/ч")
            _check(self.per_1000, *_GEAR_SPEEDS, speed)
        _check(self.drag_area, *_DRAG_AREAS, Text("Drag area, m²", "Сопротивление воздуха, м²"))
        _check(100 * self.slope, *_SLOPES, Text("Slope, %", "Уклон, %"))


def _check(value: float, low: float, high: float, name: Text) -> None:
    if low <= value <= high:
        return
    found, *ends = (f"{each:g}".replace("-", "−") for each in (value, low, high))
    raise usage_error(
        f"{name.en}: {found} is not possible; it must be from {ends[0]} to {ends[1]}",
        f"{name.ru}: {found} не бывает; нужно от {ends[0]} до {ends[1]}",
    )


@dataclass(frozen=True, slots=True)
class PullPoint:
    """Of one range of the engine's speed: the means at the wheels."""

    rpm: float
    speed: float
    """km/h."""
    power: float
    """kW at the wheels."""
    torque: float
    """Nm, of that power at the engine's speed."""
    doubt: float
    """kW, that the power may be more or less."""

    @property
    def torque_doubt(self) -> float:
        """Nm, that the torque may be more or less."""
        return self.torque * self.doubt / self.power if self.power else 0.0


@dataclass(frozen=True, slots=True)
class Pull:
    """One pull, with its points by the engine's speed. `per_1000`: km/h at 1000 rpm in its gear.

    `slip`: how far the gear seems to change in it, of `per_1000`; 0 where the gear was given.
    `throttle_known`: THR was recorded; else any rise of the engine's speed is taken for a pull.
    """

    session: int
    begin: float
    end: float
    speed_from: str
    per_1000: float
    slip: float
    points: tuple[PullPoint, ...]
    throttle_known: bool = True
    from_rpm: float = 0.0
    """The engine's speed at the begin of the rise; a point is a mean within it."""
    to_rpm: float = 0.0
    """The engine's speed at its end."""

    @property
    def most_power(self) -> PullPoint:
        """The point of the greatest power."""
        return max(self.points, key=lambda point: point.power)

    @property
    def most_torque(self) -> PullPoint:
        """The point of the greatest torque."""
        return max(self.points, key=lambda point: point.torque)


def pulls(recording: Recording, settings: PullSettings) -> list[Pull]:
    """Return the pulls of a recording: full throttle, and engine speed that rises by 1,000 rpm.

    Raises `UsageError` without FREQ, or if neither the gear is given nor a GPS was recorded.
    """
    known = recording.catalog.channels
    names = [name for name in ("FREQ", "THR") if name in known]
    corrected = recording.interpreted("corrected", names)
    if "FREQ" not in names or "FREQ" in corrected.absent:
        raise usage_error(
            "FREQ: not in this recording, so no pull can be found",
            "FREQ: в этой записи нет, поэтому разгон не найти",
        )
    if settings.per_1000 is None and not has_speed(recording):
        raise usage_error(
            "No GPS was recorded: give the speed at 1000 rpm in the gear of the pull "
            "(--per-1000 KM/H)",
            "GPS в записи нет: укажите скорость при 1000 об/мин на передаче разгона "
            "(--per-1000 КМ/Ч)",
        )
    has_throttle = "THR" in names and "THR" not in corrected.absent
    found: list[Pull] = []
    for source, rows in session_rows(corrected):
        rpm = sampled_curve(rows.times, rows.values["FREQ"])
        throttle = sampled_curve(rows.times, rows.values["THR"]) if has_throttle else None
        if throttle is not None and not len(throttle.times):
            throttle = None
        for first, last in _stretches(rpm, throttle):
            stretch = SampledCurve(rpm.times[first:last], rpm.values[first:last], rpm.longest)
            pull = _pull(recording, source.recording, stretch, settings)
            if pull is not None:
                found.append(replace(pull, throttle_known=throttle is not None))
    return found


def has_speed(recording: Recording) -> bool:
    """Return whether an instrument measured the speed of the car."""
    return any(is_labelled(each, SPEED) for each in recording.instrument_channels)


def _stretches(rpm: SampledCurve, throttle: SampledCurve | None) -> Iterator[tuple[int, int]]:
    """Yield the rows of each rise of the engine's speed at full throttle."""
    is_full = rpm.values >= RUNNING
    if throttle is not None:
        place = np.searchsorted(throttle.times, rpm.times, "right") - 1
        latest = np.maximum(place, 0)
        is_fresh = (place >= 0) & (rpm.times - throttle.times[latest] <= PAUSE)
        is_full = is_full & is_fresh & (throttle.values[latest] >= FULL_THROTTLE)
    at, speeds, full = rpm.times.tolist(), rpm.values.tolist(), is_full.tolist()
    begin, lowest, highest = -1, 0, 0  # rows of the present rise
    for row in [*range(len(at)), len(at)]:
        is_over = (
            row == len(at)
            or not full[row]
            or (begin >= 0 and not 0 < at[row] - at[row - 1] <= rpm.longest)
            or (begin >= 0 and speeds[row] < speeds[highest] - _FALL)
        )
        if begin >= 0 and is_over:
            if _is_pull(at, speeds, lowest, highest):
                yield lowest, highest + 1
            begin = -1
        if row < len(at) and full[row]:
            if begin < 0:
                begin = lowest = highest = row
            elif speeds[row] <= speeds[lowest]:  # it begins where the speed last was lowest
                lowest = highest = row
            elif speeds[row] > speeds[highest]:
                highest = row


def _is_pull(at: Sequence[float], speeds: Sequence[float], first: int, last: int) -> bool:
    seconds, rise = at[last] - at[first], speeds[last] - speeds[first]
    return seconds >= LEAST_LENGTH and rise >= max(LEAST_RISE, _SLOWEST * seconds)


def _pull(
    recording: Recording, session: int, rpm: SampledCurve, settings: PullSettings
) -> Pull | None:
    """Return the pull of a stretch; None if the receiver gave too little of it."""
    source, slip = "FREQ", 0.0
    per_1000 = settings.per_1000
    speed = rpm
    if per_1000 is None:
        received = instrument_curve(recording, session, SPEED)
        if received is None:
            return None
        source = SPEED
        inside = (received.times >= rpm.times[0]) & (received.times <= rpm.times[-1])
        inside = inside & np.isfinite(received.values)
        speed = SampledCurve(
            received.times[inside], received.values[inside] / 3.6, received.longest
        )
        if len(speed.times) < 4:
            return None
        place = np.searchsorted(rpm.times, speed.times, "right") - 1
        gears = 3600 * speed.values / rpm.values[np.maximum(place, 0)]
        per_1000 = float(np.median(gears))
        if per_1000 <= 0:  # the wheels or the clutch spun while the car stood
            return None
        ends = float(np.percentile(gears, 90)) - float(np.percentile(gears, 10))
        slip = ends / per_1000
    else:
        speed = SampledCurve(rpm.times, rpm.values * (per_1000 / 3600), rpm.longest)
    points = tuple(_binned(_measured(rpm, speed, source, per_1000, settings)))
    if not points:
        return None
    begin, end = float(rpm.times[0]), float(rpm.times[-1])
    low, high = float(rpm.values[0]), float(rpm.values[-1])
    return Pull(session, begin, end, source, per_1000, slip, points, from_rpm=low, to_rpm=high)


def _measured(
    rpm: SampledCurve, speed: SampledCurve, source: str, per_1000: float, settings: PullSettings
) -> Iterator[PullPoint]:
    """Yield a point for each time at which speed and acceleration could be fitted."""
    width = _FIT[source]
    times = np.arange(int((rpm.times[-1] - rpm.times[0] - width) / 0.25) + 1) * 0.25
    for middle in (times + (rpm.times[0] + width / 2)).tolist():
        fitted = _fit(speed, middle, width)
        turning = _fit(rpm, middle, width)
        if fitted is None or turning is None or fitted[0] <= 1 or turning[0] < RUNNING:
            continue
        power, doubt = _power(fitted, _SCALE_DOUBT[source], per_1000, settings)
        if power > 0:
            torque = 1000 * power / (turning[0] * pi / 30)
            yield PullPoint(turning[0], fitted[0] * 3.6, power, torque, doubt)


def _fit(curve: SampledCurve, middle: float, width: float) -> tuple[float, float, float] | None:
    """Return value, slope and the slope's standard error of a straight line around `middle`."""
    inside = np.abs(curve.times - middle) <= width / 2 + 1e-9
    times, values = curve.times[inside] - middle, curve.values[inside]
    count = len(times)
    if count < 3:
        return None
    mean_time, mean = float(times.mean()), float(values.mean())
    spread = float(((times - mean_time) * (times - mean_time)).sum())
    if spread <= 0:
        return None
    slope = float(((times - mean_time) * (values - mean)).sum()) / spread
    rest = values - mean - slope * (times - mean_time)
    error = (float((rest * rest).sum()) / (count - 2) / spread) ** 0.5
    return mean - slope * mean_time, slope, error


def _power(
    fitted: tuple[float, float, float], scale: float, per_1000: float, settings: PullSettings
) -> tuple[float, float]:
    """Return the power at the wheels in kW, and its doubt. `scale`: how wrong the speed may be."""
    speed, acceleration, error = fitted
    mass = settings.mass
    rotating = settings.rotating or rotating_factor(per_1000)
    inertia = mass * rotating * acceleration * speed
    weight = mass * GRAVITY * speed
    drag = 0.5 * _AIR * settings.drag_area * speed**3
    doubt = hypot(
        (inertia + weight * (settings.rolling + settings.slope)) * _MASS_DOUBT,
        inertia * _ROTATING_DOUBT,
        weight * _SLOPE_DOUBT,
        drag * _DRAG_DOUBT,
        (2 * inertia + weight * (settings.rolling + settings.slope) + 3 * drag) * scale,
        mass * rotating * error * speed,
    )
    whole = inertia + weight * (settings.rolling + settings.slope) + drag
    return whole / 1000, doubt / 1000


def rotating_factor(per_1000: float) -> float:
    """Return the inertia of all that turns, as a factor of the mass, by the gear."""
    metres = per_1000 / 3.6
    ratio = 1000 * pi / 30 * _RADIUS / metres
    return 1.04 + 0.0025 * ratio * ratio


def _binned(points: Iterator[PullPoint]) -> Iterator[PullPoint]:
    """Yield the mean of the points of each 250 rpm."""
    bins: dict[int, list[PullPoint]] = {}
    for point in points:
        bins.setdefault(int(point.rpm / _BIN), []).append(point)
    for _, mine in sorted(bins.items()):
        columns: list[Floats] = [
            np.array([getattr(point, name) for point in mine])
            for name in ("rpm", "speed", "power", "torque", "doubt")
        ]
        yield PullPoint(*(float(column.mean()) for column in columns))
