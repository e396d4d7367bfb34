"""The page of the report: self-contained, with the style, the signs and the charts of a car's."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from datetime import UTC, datetime
from functools import cache
from pathlib import Path
from statistics import median
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from mikas.cancellation import check_cancelled
from mikas.fleet.report import causes, sentences
from mikas.fleet.report.findings import CarFault, CarFindings, FleetFindings
from mikas.fleet.report.measures import MEASURES, CarMeasure
from mikas.i18n import Language, Text, plural
from mikas.recording.formatting import duration, number, with_unit
from mikas.report.charts import chart
from mikas.report.labels import Labels
from mikas.report.measurements.statistics import BlockTimes, Envelope
from mikas.report.page import templates

if TYPE_CHECKING:
    from jinja2 import Template

CHARTS: Final = 3
_FIRST: Final = ("idle_voltage", "coolant", "idle_air")
_ROOM: Final = 1.08  # of the time axis: its last label has a place
_MOST_MARKS: Final = 40
_MOST_CARS: Final = 40
"""With more cars, only those that need attention have charts."""

_LABELS: Final = {
    "title": Text("Fleet report", "Отчёт по автопарку"),
    "cars": Text("Cars", "Машины"),
    "car": Text("Car", "Машина"),
    "drives": Text("Drives", "Поездки"),
    "latest": Text("Latest", "Последняя"),
    "cause": Text("Likeliest cause", "Вероятная причина"),
    "result": Text("Result", "Итог"),
    "values": Text("All cars", "Все машины"),
    "value": Text("Value", "Параметр"),
    "count": Text("Cars", "Машин"),
    "median": Text("Median", "Медиана"),
    "spread": Text("From … to", "От … до"),
    "attention": Text("attention", "внимание"),
    "nothing": Text("nothing found", "замечаний нет"),
    "faults": Text("Faults over time", "Ошибки по времени"),
    "causes": Text("Causes by drive", "Причины по поездкам"),
    "drive": Text("Drive", "Поездка"),
    "length": Text("Length", "Длительность"),
    "legend": Text(
        "Charts: a value for each drive; days since {date}. Shaded: normal range at warm idle. "
        "Faults: ● stored, ○ not, one mark a reading, the latest on the right.",
        "Графики: значение за каждую поездку, дни с {date}. Полоса: норма на прогретом холостом "
        "ходу. Ошибки: ● есть, ○ нет, знак на каждое считывание, последнее справа.",
    ),
    "how": Text("How it was compared", "Как сравнивалось"),
    "unknown": Text("What remains unknown", "Чего узнать не удалось"),
    "made_by": Text("Made by {program}", "Создано программой {program}"),
}


def render(found: FleetFindings, language: Language) -> str:
    """Return the page in one language."""
    return _template().render(_context(found, language))


def _context(found: FleetFindings, language: Language) -> dict[str, Any]:
    label, now = Labels(language, _LABELS), sentences.date(found.figures.now)
    began = min((car.first for car in found.figures.cars if car.first), default=None)
    cars, drives = len(found.cars), sum(car.figures.drives for car in found.cars)
    length = duration(sum(car.figures.seconds for car in found.cars))
    ranked = sorted(found.cars, key=lambda car: not car.found)  # stable: then by name
    draws_all = len(found.cars) <= _MOST_CARS
    about = Text(
        f"{plural(cars, *sentences.CARS[0])}, {plural(drives, *sentences.DRIVES[0])}, {length.en}",
        f"машин: {cars}, поездок: {drives}, {length.ru}",
    )
    return {
        "language": language,
        "label": label,
        "outcome": found.outcome,
        "title": f"{label('title')} · {now}",
        "date": now,
        "about": about.to(language),
        "headline": sentences.headline(found).to(language),
        "cars": [
            _car(car, found, began if draws_all or car.found else None, language) for car in ranked
        ],
        "values": [_value(*each, found, language) for each in found.values.items()],
        "legend": label("legend", date=sentences.date(began)) if began else "",
        "how": [text.to(language) for text in sentences.method(found)],
        "unknowns": [text.to(language) for text in sentences.unknowns(found)],
    }


def _value(
    measure: CarMeasure, values: Collection[float], found: FleetFindings, language: Language
) -> dict[str, object]:
    channel = measure.channel(found.catalog)
    ends = (number(end, channel.decimals, language) for end in (min(values), max(values)))
    return {
        "text": measure.title.to(language),
        "count": len(values),
        "median": with_unit(median(values), channel, language),
        "spread": " … ".join(ends),
    }


def _car(
    car: CarFindings, found: FleetFindings, began: datetime | None, language: Language
) -> dict[str, object]:
    """Return the row and the part of a car; `began`: of its charts, None: it has none."""
    check_cancelled()
    it = car.figures
    cause = causes.car_words(it.judged)
    return {
        "car": it.car,
        "name": it.name,
        "drives": f"{it.drives} · {duration(it.seconds).to(language)}",
        "latest": sentences.date(it.last) if it.last else "–",
        "found": car.found,
        "cause": cause.to(language) if cause else "–",
        "causes": [_judged(drive, language) for drive in it.judged[: -causes.MOST - 1 : -1]],
        "sentences": [text.to(language) for text in sentences.car_sentences(car, found)],
        "remarks": [text.to(language) for text in sentences.remarks(car)],
        "faults": [_fault(fault, language) for fault in car.faults],
        "charts": list(_charts(car, found, began, language)) if began else [],
    }


def _judged(drive: causes.JudgedDrive, language: Language) -> dict[str, object]:
    return {
        "date": sentences.date(drive.began),
        "length": duration(drive.seconds).to(language),
        "words": drive.words.to(language),
    }


def _fault(fault: CarFault, language: Language) -> dict[str, object]:
    marks = fault.marks[-_MOST_MARKS:]
    return {
        "code": fault.fault.code,
        "text": sentences.fault_text(fault).to(language),
        "state": sentences.fault_state(fault).to(language),
        "marks": "".join("●" if mark else "○" for mark in marks),
    }


def _charts(
    car: CarFindings, found: FleetFindings, began: datetime, language: Language
) -> Iterator[dict[str, str]]:
    measures = {measure.key: measure for measure in MEASURES}
    order = [measure.key for measure in car.measures] + [*_FIRST, *measures]
    keys = [key for key in dict.fromkeys(order) if car.figures.series.get(key)]
    last = max(each.figures.last for each in found.cars if each.figures.last)
    seconds = _ROOM * (last - began).total_seconds()
    for key in keys[:CHARTS]:
        measure: CarMeasure = measures[key]
        channel = measure.channel(found.catalog)
        title = f"{measure.title.to(language)}, {channel.unit_text.to(language)}"
        times = [(time - began).total_seconds() for time, _ in car.figures.series[key]]
        curve = Envelope()
        values = np.array(car.figures.values(key), np.float64)
        curve.add(BlockTimes(np.array(times, np.float64), 0.0), values)
        yield {"title": title, "drawing": chart(channel, curve, seconds, language, label=title)}


@cache
def _template() -> Template:
    return templates(Path(__file__).parent).get_template("fleet.html")


def today() -> datetime:
    """Return the time now, in UTC without a zone, as a dataset has it."""
    return datetime.now(UTC).replace(tzinfo=None)
