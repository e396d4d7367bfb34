"""A trip: the sums of a drive, or of a part of one, and what follows from them."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from math import fsum
from typing import Any, Final

from mikas.json_values import picked

LEAST_DISTANCE: Final = 1.0
"""The kilometres below which litres on 100 km say little, and are None."""
_FACTS: Final = (
    "session", "begin", "end", "seconds", "gap_seconds", "litres", "litres_from", "fuel_seconds",
    "idle_seconds", "idle_known", "kilometres", "speed_seconds", "litres_per_100_km", "mean_speed",
    "highest_speed", "mean_rpm", "highest_rpm",
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class Trip:
    """The engine ran from `begin` to `end`: one drive, or several that were joined.

    A sum is None where nothing was measured of it, and else holds for the seconds beside it.
    """

    session: int
    """The number of its session in the file."""
    begin: float
    """When the engine ran first, on the link's clock; or the mark."""
    end: float
    """When it ran last."""
    seconds: float
    """How long it ran, gaps included."""
    rpm_seconds: float
    """Seconds of which the engine's speed is known."""
    turns: float
    """Turns of the crankshaft in these seconds."""
    highest_rpm: float | None
    """The highest speed of the engine."""
    fuel_seconds: float
    """Seconds of which the fuel flow is known."""
    litres: float | None
    """Fuel of these seconds."""
    litres_from: str | None
    """The channel of the fuel flow: JQT, or FUEL_FLOW where JQT was not recorded."""
    speed_seconds: float
    """Seconds of which the road speed is known."""
    kilometres: float | None
    """Distance in these seconds; None without an instrument that measures the speed."""
    highest_speed: float | None
    """The highest road speed, km/h."""
    idle_known: float
    """Seconds of which it is known whether the car stood."""
    idle_seconds: float | None
    """Seconds of them in which it stood, with the engine running."""
    shared_litres: float
    """Fuel of the seconds in which the road speed is known, too."""
    shared_kilometres: float
    """Distance of the seconds in which the fuel flow is known, too."""

    @property
    def gap_seconds(self) -> float:
        """The seconds without values of the unit."""
        return max(0.0, self.seconds - self.rpm_seconds)

    @property
    def litres_per_100_km(self) -> float | None:
        """Fuel on 100 km, of the time in which both are known; None below a kilometre."""
        if self.shared_kilometres < LEAST_DISTANCE:
            return None
        return 100 * self.shared_litres / self.shared_kilometres

    @property
    def mean_speed(self) -> float | None:
        """The mean road speed, km/h, with the time in which the car stood."""
        if self.kilometres is None:
            return None
        return 3600 * self.kilometres / self.speed_seconds

    @property
    def mean_rpm(self) -> float | None:
        """The mean speed of the engine."""
        return 60 * self.turns / self.rpm_seconds if self.rpm_seconds else None

    def as_json(self) -> dict[str, Any]:
        """Return the sums and what follows from them, by name."""
        return picked(self, *_FACTS)


def joined_trips(parts: Iterable[Trip]) -> Trip | None:
    """Return the sums of all parts as one trip; None without any.

    `seconds` are those of the parts, not of the time between them.
    """
    trips = list(parts)
    if not trips:
        return None
    sources = dict.fromkeys(each.litres_from for each in trips if each.litres_from)
    return Trip(
        session=trips[0].session,
        begin=trips[0].begin,
        end=trips[-1].end,
        seconds=fsum(each.seconds for each in trips),
        rpm_seconds=fsum(each.rpm_seconds for each in trips),
        turns=fsum(each.turns for each in trips),
        highest_rpm=_most(each.highest_rpm for each in trips),
        fuel_seconds=fsum(each.fuel_seconds for each in trips),
        litres=_sum(each.litres for each in trips),
        litres_from=", ".join(sources) or None,
        speed_seconds=fsum(each.speed_seconds for each in trips),
        kilometres=_sum(each.kilometres for each in trips),
        highest_speed=_most(each.highest_speed for each in trips),
        idle_known=fsum(each.idle_known for each in trips),
        idle_seconds=_sum(each.idle_seconds for each in trips),
        shared_litres=fsum(each.shared_litres for each in trips),
        shared_kilometres=fsum(each.shared_kilometres for each in trips),
    )


def _sum(parts: Iterable[float | None]) -> float | None:
    known = [each for each in parts if each is not None]
    return fsum(known) if known else None


def _most(parts: Iterable[float | None]) -> float | None:
    return max((each for each in parts if each is not None), default=None)
