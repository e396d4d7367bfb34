"""What remains unknown: the limits of the report."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from mikas.catalog import Confidence, Parameter, shipped
from mikas.i18n import Text, counted, joined
from mikas.recording.formatting import within
from mikas.report.findings import Findings
from mikas.report.sections.summary import doubtful_idle

_MOST_CARS: Final = 10  # that are named


def unknowns(found: Findings) -> tuple[Text, ...]:
    """Return one sentence each, the most important first."""
    return tuple(
        text
        for group in (_of_the_unit, _of_the_rating, _of_the_data, _of_the_car)
        for text in group(found)
    )


def _of_the_unit(found: Findings) -> Iterator[Text]:
    unit = found.subject.unit
    if unit is None:
        yield Text(
            "The model of the unit: it was not identified.", "Модель блока: она не запрашивалась."
        )
    elif not (unit.program or unit.data):
        yield Text("The unit's passports: they were not read.", "Паспорта блока: не считывались.")
    elif not any((*unit.program, *unit.data)):
        yield Text(
            "The unit's passports: it does not report them.", "Паспорта блока: он их не сообщает."
        )
    if found.subject.faults is None:
        yield Text(
            "Which faults are stored: they were not read in this session.",
            "Какие ошибки в памяти: в этом сеансе они не считывались.",
        )
    elif not found.real_faults and not found.cleared:
        yield Text(
            "Whether there were faults before: according to one source the unit keeps them for "
            "about two hours and loses them when the battery is disconnected.",
            "Были ли ошибки раньше: по одному источнику, блок хранит их около двух часов и "
            "теряет при отключении аккумулятора.",
        )
    if any(each.confidence is Confidence.UNKNOWN for each in found.subject.faults or ()):
        yield Text(
            "The meaning of the unknown fault numbers.", "Значение неизвестных номеров ошибок."
        )


def _of_the_rating(found: Findings) -> Iterator[Text]:
    judged = [value.channel for value in found.rated if isinstance(value.channel, Parameter)]
    doubted = [p for p in judged if p.reference_confidence is Confidence.UNCONFIRMED]
    if any(_is_shipped(each) for each in doubted):
        yield Text(
            "How exact the normal ranges are: they are commonly printed ones for a good ZMZ-406 at "
            "warm idle, without a known source. A value outside is a reason to check, not a "
            "proof.",
            "Насколько точны нормы: это распространённые данные для исправного ЗМЗ-406 на "
            "прогретом холостом ходу, первоисточник неизвестен. Значение вне нормы — повод "
            "проверить, а не доказательство.",
        )
    if own := [each for each in doubted if not _is_shipped(each)]:
        names = joined(", ", (within(each.text) for each in own))
        yield Text(
            f"How exact these normal ranges are: {names.en}. They come from the user's catalog.",
            f"Насколько точны эти нормы: {names.ru}. Они из каталога пользователя.",
        )
    meanings = any(value.meaning.en for value in found.abnormal)
    if meanings or any(each.check.en for each in found.real_faults):
        yield Text(
            "The cause: the checks are general knowledge of such engines, the easiest first.",
            "Причина: рекомендации по проверке — общие для таких двигателей, начиная с самых "
            "простых.",
        )
    for name, faults in doubtful_idle(found).items():
        codes = ", ".join(map(str, faults))
        what = within(found.subject.catalog.channel(name).text)
        yield Text(
            f"Whether the engine was at warm idle: the {what.en} shows it, and because of the "
            f"sensor's fault {codes} the unit may use a substitute value for it.",
            f"Был ли это прогретый холостой ход: об этом говорит {what.ru}, а из-за ошибки датчика "
            f"{codes} блок может подставлять вместо неё расчётное значение.",
        )


def _is_shipped(parameter: Parameter) -> bool:
    """Whether the reference is the shipped catalog's, not one of a user's file."""
    own = shipped().channels.get(parameter.name)
    return own is not None and own.reference == parameter.reference


def _of_the_data(found: Findings) -> Iterator[Text]:
    measured, how, catalog = found.measured, found.subject.conditions, found.subject.catalog
    there = {channel.name for channel in measured.channels}
    if there:
        absent = [p for p in catalog.parameters if p.reference and p.name not in there]
        if absent:
            names = joined(", ", (within(p.text) for p in absent))
            yield Text(f"Not measured: {names.en}.", f"Не измерено: {names.ru}.")
    else:
        yield Text("All values: the data contain none.", "Значения: в данных нет ни одного.")
    if there and not measured.watched:
        yield Text(
            "Whether a limit was crossed: no value with limits was measured.",
            "Был ли нарушен предел: ни одно значение с пределами не измерялось.",
        )
    if doubted := [c.name for c in measured.channels if c.errata]:
        listed = ", ".join(doubted)
        yield Text(
            f"{listed}: the protocol's source is doubtful here; the plausible interpretation is "
            "used.",
            f"{listed}: описание протокола здесь сомнительно; принято правдоподобное толкование.",
        )
    if len(how.cars) > 1:
        others = joined(", ", how.cars[-_MOST_CARS:])
        yield Text(
            f"The file holds recordings of {len(how.cars)} cars ({others.en}); this report is of "
            "the last recording's car alone. “mikas split” makes a file of each.",
            f"В файле записи нескольких машин, их {len(how.cars)} ({others.ru}); этот отчёт — "
            "только о машине последней записи. «mikas split» делает по файлу на каждую.",
        )
    elif how.sessions > 1:
        yield Text(
            f"The file holds {how.sessions} sessions; this report covers the last one.",
            f"В файле несколько сеансов ({how.sessions}); отчёт — о последнем.",
        )
    if how.ports > 1:
        yield Text(
            f"The session used {how.ports} ports; this report covers the one with most values.",
            f"В сеансе несколько портов ({how.ports}); отчёт — о том, где больше всего значений.",
        )
    if how.damaged:
        places = counted(
            how.damaged, ("damaged place", "damaged places"),
            ("повреждённое место", "повреждённых места", "повреждённых мест"),
        )  # fmt: skip
        yield Text(
            f"The data in {places.en} of the file; all readable data were used.",
            f"Данные в повреждённой части файла ({places.ru}); всё остальное учтено.",
        )


def _of_the_car(found: Findings) -> Iterator[Text]:
    if found.measured.idle.enough:
        yield Text(
            "Whether the car stood still: the unit sends no vehicle speed, so coasting in neutral "
            "looks like idle.",
            "Стояла ли машина: скорость блок не передаёт, и движение накатом на нейтрали "
            "выглядит как холостой ход.",
        )
    yield Text(
        "Quantities that the unit does not measure: compression, fuel pressure, spark, exhaust.",
        "То, чего блок не измеряет: компрессия, давление топлива, искра, состав выхлопа.",
    )
