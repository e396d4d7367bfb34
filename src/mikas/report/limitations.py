"""What could not be known: the other half of an honest report."""

from __future__ import annotations

from collections.abc import Iterator

from mikas.catalog import Confidence, Parameter
from mikas.i18n import Text, counted
from mikas.report.findings import Findings
from mikas.report.formatting import within
from mikas.report.warm_idle import COOLANT


def unknowns(found: Findings) -> tuple[Text, ...]:
    """One sentence each, the weightiest first."""
    return tuple(
        text
        for group in (_of_the_unit, _of_the_judging, _of_the_data, _of_the_car)
        for text in group(found)
    )


def _of_the_unit(found: Findings) -> Iterator[Text]:
    unit = found.subject.unit
    if unit is None:
        yield Text(
            "Which unit this was: it was not asked who it is.",
            "Что это за блок: его об этом не спрашивали.",
        )
    elif not any((*unit.program, *unit.data)):
        yield Text(
            "The unit's passports: it does not tell them.",
            "Паспорта блока: он их не сообщает.",
        )
    if found.faults is None:
        yield Text(
            "Which faults are stored: they were not read in this session.",
            "Какие ошибки в памяти: в этом сеансе их не читали.",
        )
    elif not found.real_faults and not found.gone:
        yield Text(
            "Whether there were faults before: the unit is said (by one source) to keep them for "
            "about two hours, and loses them when the battery is taken off.",
            "Были ли ошибки раньше: по одному источнику, блок хранит их около двух часов и "
            "забывает, если снять аккумулятор.",
        )
    if any(each.fault.confidence is Confidence.UNKNOWN for each in found.faults or ()):
        yield Text(
            "What the fault numbers without a text mean.", "Что значат номера ошибок без текста."
        )


def _of_the_judging(found: Findings) -> Iterator[Text]:
    judged = [value.channel for value in found.judged if isinstance(value.channel, Parameter)]
    if any(each.reference_confidence is Confidence.UNCONFIRMED for each in judged):
        yield Text(
            "How exact the bands are: they are what is commonly printed for a sound ZMZ-406 at "
            "warm idle; no source was seen. A value outside is a reason to look, not a proof.",
            "Насколько точны нормы: это то, что обычно пишут об исправном ЗМЗ-406 на прогретом "
            "холостом ходу; источника мы не видели. Значение вне нормы — повод проверить, а не "
            "доказательство.",
        )
    if found.off or found.real_faults:
        yield Text(
            "The cause: what to check is general knowledge of such engines, put in the order of "
            "what is easy to look at.",
            "Причина: советы, что проверить, — общее знание таких двигателей, начиная с того, "
            "что легко осмотреть.",
        )
    doubtful = [
        value
        for value in (*found.judged, *found.others)
        if found.at_idle and value.faults and value.channel.name in COOLANT.names
    ]
    if doubtful:
        codes = ", ".join(map(str, doubtful[0].faults))
        yield Text(
            f"Whether the engine was warm: fault {codes} concerns the coolant temperature, and "
            "then the unit may work with a substitute for it.",
            f"Был ли двигатель прогрет: ошибка {codes} касается температуры охлаждающей жидкости, "
            "и вместо неё блок может подставлять своё число.",
        )


def _of_the_data(found: Findings) -> Iterator[Text]:
    measured, how, catalog = found.measured, found.subject.how, found.subject.catalog
    there = {channel.name for channel in measured.channels}
    if there:
        absent = [p for p in catalog.parameters if p.reference and p.name not in there]
        if absent:
            yield Text(
                f"Not measured: {', '.join(within(p.text).en for p in absent)}.",
                f"Не измерено: {', '.join(within(p.text).ru for p in absent)}.",
            )
    else:
        yield Text("Any value: there is none in the data.", "Значения: в данных нет ни одного.")
    if doubted := [c.name for c in measured.channels if getattr(c, "errata", ())]:
        names = ", ".join(doubted)
        yield Text(
            f"{names}: the protocol's source is doubtful here; the reading that makes sense is "
            "taken.",
            f"{names}: источник протокола здесь сомнителен; взято толкование, в котором есть "
            "смысл.",
        )
    if how.sessions > 1:
        yield Text(
            f"The file holds {how.sessions} sessions; this report is of the last one.",
            f"В файле несколько сеансов ({how.sessions}); отчёт — о последнем.",
        )
    if how.damaged:
        places = counted(
            how.damaged, ("damaged place", "damaged places"),
            ("повреждённое место", "повреждённых места", "повреждённых мест"),
        )  # fmt: skip
        yield Text(
            f"What stood in {places.en} of the file; all that can be read was used.",
            f"Что было в файле там, где он повреждён ({places.ru}); всё, что читается, учтено.",
        )


def _of_the_car(found: Findings) -> Iterator[Text]:
    if found.at_idle:
        yield Text(
            "Whether the car stood: the unit sends no speed, so that rolling in neutral looks like "
            "idle.",
            "Стояла ли машина: скорость блок не передаёт, и накат на нейтрали выглядит как "
            "холостой ход.",
        )
    yield Text(
        "What the unit does not measure: compression, fuel pressure, the spark, the exhaust.",
        "То, чего блок не измеряет: компрессия, давление топлива, искра, состав выхлопа.",
    )
