"""The trip: fuel, distance, idling of the drives in the session, and the way drawn."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from markupsafe import Markup

from mikas.drives.trip import Trip, joined_trips
from mikas.drives.way_lines import SPEEDS
from mikas.drives.wording import left_out
from mikas.i18n import Language, Text
from mikas.recording.formatting import digits, duration, moment
from mikas.report.findings import Findings
from mikas.report.sections.section import PageSection, items, paragraph, table
from mikas.report.way_drawing import way_drawing

_MOST: Final = 12  # drives, each with a row
TITLE: Final = Text("Trip", "Поездка")
_HEAD: Final = (
    Text("Begin", "Начало"), Text("Engine ran", "Двигатель работал"), Text("Car stood", "Стояла"),
    Text("Litres", "Литров"), Text("km", "км"), Text("l/100 km", "л/100 км"),
    Text("km/h, mean (highest)", "км/ч, средняя (наибольшая)"),
)  # fmt: skip
_WAY: Final = Text(
    "The way, north above; green dot: begin, red dot: end. Colour: speed, from blue (below {low}) "
    "to red ({high} km/h and more); grey: unknown.",
    "Путь, север вверху; зелёная точка — начало, красная — конец. Цвет — скорость, от синего "
    "(ниже {low}) до красного (от {high} км/ч); серый — неизвестна.",
)


def drive_section(found: Findings, language: Language) -> PageSection | None:
    """Return the section; None for a session in which no instrument measured speed or place."""
    drive = found.subject.drive
    if drive is None:
        return None
    parts: list[Markup] = []
    if drive.trips:
        rows = [_row(each, found, language) for each in drive.trips[:_MOST]]
        total = joined_trips(drive.trips)
        if total is not None and len(drive.trips) > 1:
            words = Text("All {count}", "Все {count}").filled(count=len(drive.trips))
            rows.append((words.to(language), *_figures(total, language)))
        parts.append(table((each.to(language) for each in _HEAD), rows))
        missing = [each.to(language) for each in left_out(total)] if total is not None else []
        if missing:
            parts.append(items(missing))
    if drive.way:
        parts.append(way_drawing(drive.way, language, TITLE.to(language)))
        legend = _WAY.filled(low=digits(SPEEDS[0], 0), high=digits(SPEEDS[-1], 0))
        parts.append(paragraph(legend.to(language)))
    return PageSection(TITLE.to(language), Markup("").join(parts)) if parts else None


def _row(trip: Trip, found: Findings, language: Language) -> tuple[str, ...]:
    begin = moment(trip.begin, found.measured.began).to(language)
    return (begin, *_figures(trip, language))


def _figures(trip: Trip, language: Language) -> Iterator[str]:
    yield duration(trip.seconds).to(language)
    yield "–" if trip.idle_seconds is None else duration(trip.idle_seconds).to(language)
    for value, decimals in (
        (trip.litres, 2),
        (trip.kilometres, 1),
        (trip.litres_per_100_km, 1),
    ):
        yield "–" if value is None else digits(value, decimals).to(language)
    if trip.mean_speed is None or trip.highest_speed is None:
        yield "–"
    else:
        yield f"{trip.mean_speed:.0f} ({trip.highest_speed:.0f})"
