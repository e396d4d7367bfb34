"""What the sums of a trip leave out, in words."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from mikas.drives.trip import LEAST_DISTANCE, Trip
from mikas.i18n import Text
from mikas.recording.formatting import digits

NO_FUEL: Final = Text(
    "No litres: neither JQT nor INJ with FREQ was recorded.",
    "Литров нет: в записи нет ни JQT, ни INJ с FREQ.",
)
NO_SPEED: Final = Text(
    "No distance: no instrument beside the unit measured the speed.",
    "Пути нет: скорость не измерял ни один прибор рядом с блоком.",
)
SHORT: Final = Text(
    f"No litres on 100 km: less than {LEAST_DISTANCE:g} km with fuel and speed both known.",
    f"Литров на 100 км нет: меньше {LEAST_DISTANCE:g} км с известными расходом и скоростью.",
)
_FUEL_MISSING: Final = Text(
    "Fuel is not known for {missing} s of {all} s; the litres leave them out.",
    "Расход неизвестен {missing} с из {all} с; в литры они не вошли.",
)
_SPEED_MISSING: Final = Text(
    "Speed is not known for {missing} s of {all} s; the distance leaves them out.",
    "Скорость неизвестна {missing} с из {all} с; в путь они не вошли.",
)
_BY_INJECTION: Final = Text(
    "The litres follow from the injection (FUEL_FLOW), not from the unit's own flow (JQT).",
    "Литры — по впрыску (FUEL_FLOW), а не по расходу, который даёт блок (JQT).",
)


def left_out(trip: Trip, least: float = 1.0) -> Iterator[Text]:
    """Yield a sentence for each sum that is missing, or lacks `least` seconds or more."""
    if trip.litres is None:
        yield NO_FUEL
    else:
        if trip.seconds - trip.fuel_seconds >= least:
            yield _seconds(_FUEL_MISSING, trip.seconds - trip.fuel_seconds, trip.seconds)
        if trip.litres_from != "JQT":
            yield _BY_INJECTION
    if trip.kilometres is None:
        yield NO_SPEED
        return
    if trip.seconds - trip.speed_seconds >= least:
        yield _seconds(_SPEED_MISSING, trip.seconds - trip.speed_seconds, trip.seconds)
    if trip.litres is not None and trip.litres_per_100_km is None:
        yield SHORT


def _seconds(sentence: Text, missing: float, whole: float) -> Text:
    return sentence.filled(missing=digits(missing, 0), all=digits(whole, 0))
