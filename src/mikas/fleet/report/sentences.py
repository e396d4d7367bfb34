"""The sentences of the report. Each stands there exactly when its rule holds: the table of rules in
docs/how-to/fleet.md, which `tests/fleet/test_fleet_sentences.py` evaluates.
"""

from __future__ import annotations

from collections.abc import Iterator
from datetime import UTC, datetime

from mikas.fleet.cars import KnownBy
from mikas.fleet.report.comparing import (
    FEWEST_DRIVES,
    FEWEST_OF_TREND,
    FEWEST_OTHERS,
    LATEST,
    Outlier,
    Trend,
)
from mikas.fleet.report.findings import CarFault, CarFindings, FleetFindings
from mikas.fleet.report.measures import MEASURES, CarMeasure
from mikas.i18n import Text, counted, joined
from mikas.recording.formatting import band, digits, quantity
from mikas.report.findings import Outcome

CARS = (("car", "cars"), ("машина", "машины", "машин"))
RECORDINGS = (("recording", "recordings"), ("запись", "записи", "записей"))
DRIVES = (("drive", "drives"), ("поездка", "поездки", "поездок"))


def headline(found: FleetFindings) -> Text:
    """Return the overall result."""
    bad = sum(car.found for car in found.cars)
    if found.outcome is Outcome.ATTENTION:
        return Text(
            f"{bad} of {len(found.cars)} cars: attention needed",
            f"Есть на что обратить внимание: машин {bad} из {len(found.cars)}",
        )
    if found.outcome is Outcome.GOOD:
        return Text("No car stands out", "Ни одна машина не выделяется")
    return Text("Not enough data for a comparison", "Для сравнения недостаточно данных")


def car_sentences(car: CarFindings, found: FleetFindings) -> Iterator[Text]:
    """Yield what was found of a car, faults first."""
    for fault in car.faults:
        if fault.is_stored:
            yield _stored(fault)
    for measure, value in car.out_of_range.items():
        yield _out_of_range(measure, value, found)
    for measure, outlier in car.stands_out.items():
        yield _stands_out(measure, outlier, found)
    for measure, trend in car.changes.items():
        yield _changes(measure, trend, found)


def remarks(car: CarFindings) -> Iterator[Text]:
    """Yield the gaps in the knowledge of a car."""
    figures = car.figures
    if not figures.read:
        yield Text("Its stored faults were never read.", "Ошибки ни разу не считывались.")
    if figures.known_by == {KnownBy.UNIT}:
        yield Text(
            "Known by its unit's passport only: several cars with the same program would be one "
            "here.",
            "Известна только по паспорту блока: несколько машин с одной программой здесь были бы "
            "одной.",
        )
    if not any(len(values) >= FEWEST_DRIVES for values in figures.series.values()):
        yield Text(
            f"Not compared: no value in {FEWEST_DRIVES} drives or more.",
            f"Не сравнивается: ни одного значения хотя бы в {FEWEST_DRIVES} поездках.",
        )
    if figures.ahead:
        drives = counted(figures.ahead, *DRIVES)
        yield Text(
            f"Left out: {drives.en} dated in the future, so the clock was wrong.",
            f"Не учтено: {drives.ru} с датой из будущего, то есть с неверными часами.",
        )
    if figures.undated:
        drives = counted(figures.undated, *DRIVES)
        yield Text(f"Left out: {drives.en} without a date.", f"Не учтено: {drives.ru} без даты.")


def method(found: FleetFindings) -> Iterator[Text]:
    """Yield how the cars were compared."""
    yield Text(
        f"A car's value is the median of its latest {LATEST} drives, and of {FEWEST_DRIVES} at "
        "least; a drive's value is the median of its readings.",
        f"Значение машины — медиана её последних поездок (до {LATEST}, не меньше {FEWEST_DRIVES}); "
        "значение поездки — медиана её замеров.",
    )
    if found.compared:
        yield Text(
            f"Compared with the other cars: {_listed(found.compared).en}.",
            f"Сравнивалось с другими машинами: {_listed(found.compared).ru}.",
        )
    if found.followed:
        cars = counted(found.followed, *CARS)
        yield Text(
            f"Followed over time, with {FEWEST_OF_TREND} drives or more: {cars.en}.",
            f"Прослежено во времени, от {FEWEST_OF_TREND} поездок: {cars.ru}.",
        )
    if any(car.figures.judged for car in found.cars):
        yield Text(
            "Causes are ranked for each drive by itself, known from a model of the engine and "
            "service literature, not from cars. They don't decide on attention.",
            "Причины ищутся по каждой поездке отдельно: известны по модели двигателя и сервисной "
            "литературе, а не по машинам. На оценку «внимание» они не влияют.",
        )


def unknowns(found: FleetFindings) -> Iterator[Text]:
    """Yield what the data can't show."""
    if too_few := tuple(each for each in MEASURES if each not in found.compared):
        listed = _listed(too_few)
        yield Text(
            f"Too few cars to compare ({FEWEST_OTHERS + 1} are needed): {listed.en}.",
            f"Слишком мало машин для сравнения (нужно {FEWEST_OTHERS + 1}): {listed.ru}.",
        )
    if len(found.cars) > found.followed:
        cars = counted(len(found.cars) - found.followed, *CARS)
        yield Text(
            f"Too few drives for changes over time ({FEWEST_OF_TREND} are needed): {cars.en}.",
            f"Слишком мало поездок, чтобы судить об изменениях (нужно {FEWEST_OF_TREND}): "
            f"{cars.ru}.",
        )
    if found.figures.unknown:
        drives = counted(found.figures.unknown, *DRIVES)
        yield Text(
            f"Of which car: {drives.en} have neither a plate nor a name nor a unit's passport.",
            f"Чьи это поездки: {drives.ru} без номера, названия машины и паспорта блока.",
        )
    if found.figures.refused:
        recordings = counted(found.figures.refused, *RECORDINGS)
        yield Text(
            f"Left out: {recordings.en} of the dataset whose files can't be used.",
            f"Не учтено: {recordings.ru} набора, файлы которых непригодны.",
        )
    if unjudged := sum(car.figures.unjudged for car in found.cars):
        drives = counted(unjudged, *DRIVES)
        yield Text(
            f"The causes in {drives.en}: an earlier version of mikas added them. Add the same "
            "recordings again.",
            f"Причины неисправностей: {drives.ru} из более старой версии mikas. Добавьте те же "
            "записи ещё раз.",
        )
    yield Text(
        "Why a car differs. Cars with other equipment, other loads or another program do too: a "
        "difference is a reason to check, not a proof.",
        "Почему машина отличается. Отличаются и машины с другим оборудованием, нагрузкой или "
        "программой: отличие — повод проверить, а не доказательство.",
    )


def fault_state(fault: CarFault) -> Text:
    """Return whether a fault is stored, and when it was seen."""
    first, last = date(fault.first), date(fault.last)
    if fault.is_stored:
        return Text(
            f"stored at the latest reading; first seen {first}",
            f"есть при последнем считывании; впервые {first}",
        )
    return Text(
        f"no longer stored at the latest reading; seen from {first} to {last}",
        f"при последнем считывании уже нет; была с {first} по {last}",
    )


def date(time: datetime) -> str:
    """Return the local date of a UTC time."""
    return f"{time.replace(tzinfo=UTC).astimezone():%d.%m.%Y}"


def fault_text(fault: CarFault) -> Text:
    """Return the fault in words."""
    unknown = Text("unknown fault number", "неизвестный номер ошибки")
    return fault.fault.text if fault.fault.known else unknown


def _stored(fault: CarFault) -> Text:
    words, code = fault_text(fault), fault.fault.code
    return Text(
        f"Fault {code} is stored: {words.en}.", f"В памяти блока ошибка {code}: {words.ru}."
    )


def _out_of_range(measure: CarMeasure, value: float, found: FleetFindings) -> Text:
    channel, title = measure.channel(found.catalog), measure.title
    shown = quantity(value, channel)
    return Text(
        f"{title.en}: {shown.en}, outside the normal range ({band(channel, 'en')}).",
        f"{title.ru}: {shown.ru}, вне нормы ({band(channel, 'ru')}).",
    )


def _stands_out(measure: CarMeasure, it: Outlier, found: FleetFindings) -> Text:
    channel, title = measure.channel(found.catalog), measure.title
    value, others = quantity(it.value, channel), quantity(it.others, channel)
    low, high = (digits(end, channel.decimals) for end in (it.low, it.high))
    return Text(
        f"{title.en}: {value.en}; the other {it.count} cars: {others.en}, from {low.en} to "
        f"{high.en}.",
        f"{title.ru}: {value.ru}; у остальных машин ({it.count}): {others.ru}, от {low.ru} до "
        f"{high.ru}.",
    )


def _changes(measure: CarMeasure, it: Trend, found: FleetFindings) -> Text:
    channel, title = measure.channel(found.catalog), measure.title
    first, last = digits(it.first, channel.decimals), quantity(it.last, channel)
    return Text(
        f"{title.en} has changed over {it.count} drives: from {first.en} to {last.en}.",
        f"{title.ru}: изменение за поездки ({it.count}), с {first.ru} до {last.ru.rstrip('.')}.",
    )


def _listed(measures: tuple[CarMeasure, ...]) -> Text:
    return joined(", ", (each.text for each in measures))
