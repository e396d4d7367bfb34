"""The summary in a sentence or two, and a description of how warm idle was found or why not."""

from __future__ import annotations

from collections.abc import Iterator
from math import isfinite

from mikas.catalog import Catalog
from mikas.causes.result import CauseVerdict
from mikas.i18n import Language, Text, counted, joined
from mikas.recording.formatting import duration, moment, number, within
from mikas.report.findings import BandPosition, Findings, Outcome, Unrated, is_open
from mikas.report.measurements.knock import FAST, Knock
from mikas.report.measurements.warm_idle import ENOUGH, SETTLING, RuleResult, WarmIdle
from mikas.report.sections.alarm_texts import NOTED, alarm_summary
from mikas.report.sections.causes import cause_sentences
from mikas.report.subject import ClearedFaults

HEADLINES = {
    Outcome.GOOD: Text("No problems found", "Отклонений не найдено"),
    Outcome.ATTENTION: Text("Attention needed", "Есть на что обратить внимание"),
    Outcome.OPEN: Text("Not enough data for a conclusion", "Для вывода недостаточно данных"),
}
_NOTHING_FOUND = Text(
    "Nothing found, but not everything was checked", "Отклонений не найдено, но проверено не всё"
)
MARKS = {
    BandPosition.INSIDE: Text("normal", "в норме"),
    BandPosition.LOW: Text("low", "ниже нормы"),
    BandPosition.HIGH: Text("high", "выше нормы"),
    BandPosition.NONE: Text("not rated", "без оценки"),
}


def headline(found: Findings) -> Text:
    """Return the outcome in words. Where the values speak against no cause, data were enough."""
    ranking = found.subject.causes
    sound = ranking is not None and ranking.verdict is CauseVerdict.SOUND
    return _NOTHING_FOUND if sound and found.outcome is Outcome.OPEN else HEADLINES[found.outcome]


def summary_sentence(found: Findings) -> Text:
    """Return the summary: causes first, then faults, alarms, values, and guided tests."""
    alarms = [alarm_summary(found)] if found.measured.alarms else []
    knock = _of_knock(found.measured.knock)
    unit = [_IGNITION_ONLY] if found.measured.ignition_only else []
    parts = (_of_faults(found), *unit, *alarms, *knock, *_of_values(found), *_of_tests(found))
    said = joined("; ", parts)
    return joined(" ", (*cause_sentences(found), Text(f"{said.en}.", f"{said.ru}.")))


_IGNITION_ONLY = Text(
    "this unit controls the ignition alone (injection and air flow are zero while the engine "
    "runs), so nothing of injection, mixture, air meter and idle valve is judged",
    "этот блок управляет только зажиганием (впрыск и расход воздуха на работающем двигателе "
    "нулевые), поэтому впрыск, смесь, ДМРВ и РДВ не оцениваются",
)


def _of_knock(knock: Knock) -> Iterator[Text]:
    """Yield how often the engine knocked, and how often the ignition was retarded for that."""
    if knock.knocks:
        times = counted(knock.knocks, ("time", "times"), ("раз", "раза", "раз"))
        speed = f"{FAST:.0f}"
        yield Text(
            f"the engine knocked {times.en}, above {speed} rpm {knock.fast}",
            f"детонация {times.ru}, выше {speed} об/мин {knock.fast}",
        )
    if knock.share is not None and (knock.knocks or knock.often_retarded):
        share = f"{100 * knock.share:.0f}"
        yield Text(
            f"the ignition was retarded for knock in {share} % of the readings",
            f"УОЗ снижен по детонации в {share} % опросов",
        )


def _of_tests(found: Findings) -> Iterator[Text]:
    """Yield the guided tests that found something."""
    for test in found.failed_tests:
        yield Text(
            f"the guided test “{test.title.en}” found: {within(_bare(test.verdict)).en}",
            f"проверка «{test.title.ru}» нашла: {within(_bare(test.verdict)).ru}",
        )


def _bare(sentence: Text) -> Text:
    """Return a sentence without its full stop."""
    return Text(sentence.en.rstrip("."), sentence.ru.rstrip("."))


def _of_faults(found: Findings) -> Text:
    if found.subject.conditions.empty:
        return Text("The file has no packets", "В файле нет пакетов")
    if found.subject.faults is None:
        return Text("The stored faults were not read", "Ошибки не считывались")
    stored = found.real_faults
    if not stored:
        none = Text("No faults are stored", "Ошибок в памяти блока нет")
        if found.cleared:
            none = Text("No faults are stored now", "Сейчас ошибок в памяти блока нет")
        return joined("; ", (none, *(_cleared_sentence(found, gone) for gone in found.cleared)))
    number = counted(len(stored), ("fault is", "faults are"), ("ошибка", "ошибки", "ошибок"))
    codes = ", ".join(str(each.code) for each in stored)
    return Text(f"{number.en} stored: {codes}", f"В памяти блока {number.ru}: {codes}")


def _cleared_sentence(found: Findings, gone: ClearedFaults) -> Text:
    """`faults 13, 53 were erased at 12:05, and whether they come back is not known yet`."""
    when = moment(gone.time, found.measured.began)
    codes = ", ".join(str(fault.code) for fault in gone.faults)
    only = len(gone.faults) == 1
    if only:
        who = Text(f"fault {codes} was", f"ошибка {codes}")
    else:
        who = Text(f"faults {codes} were", f"ошибки {codes}")
    if gone.erased:
        done = Text("erased", "сброшена" if only else "сброшены")
    else:
        done = Text("no longer stored", "исчезла" if only else "исчезли")
    how = Text(f"{who.en} {done.en} {when.en}", f"{who.ru} {done.ru} {when.ru}")
    if is_open(found.subject, gone):
        back = "it comes" if only else "they come"
        again = "появится" if only else "появятся"
        return Text(
            f"{how.en}, and whether {back} back is not known yet",
            f"{how.ru}, и {again} ли снова, пока не известно",
        )
    read = moment(found.subject.faults_read or gone.time, found.measured.began)
    there = "её" if only else "их"
    return Text(f"{how.en}, and not back {read.en}", f"{how.ru}, и {read.ru} {there} всё ещё нет")


def _of_values(found: Findings) -> Iterator[Text]:
    """Yield the ratings, then what they can't say: values of a faulty sensor, a doubtful idle."""
    idle = found.measured.idle
    yield _of_ratings(found) if idle.enough else _no_idle(idle)
    if found.suspended:
        sensors = (
            NOTED.filled(name=within(v.channel.text), note=", ".join(map(str, v.sensor)))
            for v in found.suspended
        )
        listed = joined(", ", sensors)
        yield Text(
            f"not rated because of a fault of the sensor: {listed.en}",
            f"без оценки из-за ошибки датчика: {listed.ru}",
        )
    if doubtful_idle(found):
        yield Text(
            "whether that was warm idle is not certain",
            "был ли это прогретый холостой ход, точно не известно",
        )


def _no_idle(idle: WarmIdle) -> Text:
    """Return why no value is rated: the data can't show warm idle, or have too little, or none."""
    if idle.unknown:
        return Text(
            "the data can't show whether there was warm idle, so no value is rated",
            "по этим данным не видно, был ли прогретый холостой ход, поэтому значения без оценки",
        )
    if idle.spans:
        lasted = duration(idle.seconds)
        return Text(
            f"warm idle lasted only {lasted.en}, so no value is rated",
            f"прогретый холостой ход длился всего {lasted.ru}, поэтому значения без оценки",
        )
    if any(seen.missing >= ENOUGH for seen in idle.rules):
        return Text(
            "no warm idle was found, so no value is rated",
            "прогретый холостой ход не найден, поэтому значения без оценки",
        )
    if (least := idle.never_below) is not None:
        return Text(
            f"the speed was never below {least:.0f} rpm, so no value is rated at warm idle; if it "
            "stays there with a warm engine and the pedal released, the idle is too fast",
            f"обороты не опускались ниже {least:.0f} об/мин, поэтому значения без оценки на "
            "холостом ходу; если они такие на прогретом двигателе с отпущенной педалью, холостой "
            "ход завышен",
        )
    return Text(
        "there was no warm idle, so no value is rated",
        "прогретого холостого хода в данных нет, поэтому значения без оценки",
    )


def doubtful_idle(found: Findings) -> dict[str, tuple[int, ...]]:
    """Return the faults of the sensors by which warm idle was found, by channel; empty: none."""
    if not found.measured.idle.enough:
        return {}
    names = (seen.name for seen in found.measured.idle.rules if seen.name is not None)
    return {name: found.sensor[name] for name in names if name in found.sensor}


def _of_ratings(found: Findings) -> Text:
    if not found.rated:
        if any(
            value.unrated not in (Unrated.NO_REFERENCE, Unrated.IGNITION_ONLY)
            for value in found.values
        ):
            return Text(
                "no value could be rated at warm idle",
                "на прогретом холостом ходу ни одно значение оценить не удалось",
            )
        return Text(
            "none of the values has a reference to judge it by",
            "ни для одного из значений нет нормы, чтобы его оценить",
        )
    off, count = found.abnormal, len(found.rated)
    if not off:
        if count == 1:
            return Text(
                "the one value that can be rated is normal at warm idle",
                "единственное значение, которое можно оценить, на прогретом холостом ходу в норме",
            )
        return Text(
            f"all {count} values that can be rated are normal at warm idle",
            f"все значения, которые можно оценить ({count}), на прогретом холостом ходу в норме",
        )
    marked = (NOTED.filled(name=within(v.channel.short), note=MARKS[v.mark]) for v in off)
    listed = joined(", ", marked)
    out = counted(len(off), ("is", "are"), ("значение", "значения", "значений"))
    return Text(
        f"at warm idle {len(off)} of the {count} values that can be rated "
        f"{out.en.split()[1]} outside the normal range: {listed.en}",
        f"на прогретом холостом ходу вне нормы {out.ru} из {count}: {listed.ru}",
    )


def idle_sentence(found: Findings) -> Text:
    """Return the rules for warm idle, and how much of it was found."""
    idle, catalog = found.measured.idle, found.subject.catalog
    rules = joined(", ", (seen.rule.text for seen in idle.rules))
    definition = Text(
        f"Warm idle means: {rules.en}; values count after {SETTLING:g} s of this.",
        f"Прогретым холостым ходом считается: {rules.ru}; значения учитываются через "
        f"{SETTLING:g} с после этого.",
    )
    substitutes, missing = _substitute_rules(idle), _missing(found, catalog)
    return joined(" ", (definition, *substitutes, _idle_found(found, catalog), *missing))


def _substitute_rules(idle: WarmIdle) -> Iterator[Text]:
    for seen in idle.rules:
        if seen.instead is not None:
            yield Text(
                f"Where this was not read ({seen.rule.text.en}): {seen.instead.text.en}.",
                f"Где это не опрашивалось ({seen.rule.text.ru}): {seen.instead.text.ru}.",
            )


def _missing(found: Findings, catalog: Catalog) -> Iterator[Text]:
    """Yield the channels that were read for a part of the time only."""
    whole = duration(found.measured.seconds)
    for seen in found.measured.idle.rules:
        if seen.name is not None and seen.missing >= ENOUGH:
            lacked, what = duration(seen.missing), within(catalog.channel(seen.name).text)
            yield Text(
                f"For {lacked.en} of {whole.en} the {what.en} ({seen.name}) was not read; that "
                "time does not count. Read it together with the other values to rate all of it.",
                f"{lacked.ru} из {whole.ru} не опрашивалось: {what.ru} ({seen.name}); это время не "
                "учтено. Чтобы его учесть, опрашивайте этот параметр вместе с остальными.",
            )


def _idle_found(found: Findings, catalog: Catalog) -> Text:
    idle = found.measured.idle
    lasted = duration(idle.seconds)
    if idle.enough:
        times = counted(len(idle.spans), ("stretch", "stretches"), ("раз", "раза", "раз"))
        return Text(f"Found: {lasted.en} in {times.en}.", f"Найдено: {lasted.ru}, {times.ru}.")
    if missing := idle.unknown:
        names = joined(", ", (rule.text for rule in missing))
        return Text(
            f"Can't be determined, as this was not recorded: {names.en}.",
            f"Определить нельзя, не записано: {names.ru}.",
        )
    if seen := [_range_sentence(each, catalog) for each in idle.rules if not each.held]:
        ranges = joined(", ", seen)
        return Text(f"Not found: {ranges.en}.", f"Не найден: {ranges.ru}.")
    return Text(
        f"Only {lasted.en} found; {ENOUGH:g} s are needed.",
        f"Найдено только {lasted.ru}; нужно {ENOUGH:g} с.",
    )


def _range_sentence(seen: RuleResult, catalog: Catalog) -> Text:
    """`coolant temperature was 20 to 45 °C`."""
    if seen.name is None or not isfinite(seen.least):
        return Text(f"no values ({seen.rule.text.en})", f"нет значений ({seen.rule.text.ru})")
    channel = catalog.channel(seen.name)

    def ends(language: Language, between: str) -> str:
        low, high = (number(end, channel.decimals, language) for end in (seen.least, seen.most))
        unit = channel.unit_text.to(language)
        return f"{low if low == high else low + between + high} {unit}".rstrip()

    return Text(
        f"{within(channel.text).en} was {ends('en', ' to ')}",
        f"{within(channel.text).ru} — {ends('ru', '…')}",
    )
