"""`mikas survey`: a real unit from top to bottom, for the project; reads only."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mikas.cli.click_extensions import OVERWRITE, YES, command, flag, option, output_option
from mikas.cli.context import CommandContext
from mikas.cli.language import current_language, localized, tr
from mikas.cli.options.parameter_types import positive
from mikas.errors import MikasError, NotConfirmed, usage_error
from mikas.files import absolute
from mikas.i18n import Text

if TYPE_CHECKING:
    from mikas.cli.surveying import TerminalPrompter
    from mikas.client import Ecu
    from mikas.survey import Survey, SurveyAnswer


@command(
    en="Surveys a real unit for the project: what it supports, its limits and times, codes 00–FF, "
    "how streams end, the source's errata. Leads from ignition on, engine off, to warm idle; about "
    "ten minutes with a warm engine. Reads only: nothing is written but the unit's list (64), "
    "which a power cycle ends. OUT is one ZIP without name, place or date, shown before it is "
    "saved. Stopped by Ctrl-C or a lost cable, the same command goes on.",
    ru="Обследует настоящий блок для проекта: что он умеет, его пределы и времена, коды 00–FF, как "
    "кончаются потоки, опечатки источника. Ведёт от включённого зажигания без пуска до прогретого "
    "холостого хода; около десяти минут на прогретом двигателе. Только чтение: записывается лишь "
    "список блока (64), который пропадает с питанием. OUT — один ZIP без имён, места и даты; перед "
    "сохранением показывается. После Ctrl-C или потери кабеля та же команда продолжает.",
    examples=(
        "mikas survey -o unit.zip",
        "mikas survey -o unit.zip --without-engine",
        "mikas survey -o unit.zip --passports --memory --voltmeter 12.4 --yes",
        "mikas survey --port 'sim:?clock=simulated&scenario=survey' -o virtual.zip --yes",
    ),
)
@output_option(endings=["zip"])
@flag(
    "--memory",
    en="read memory too (11 13 15 21 23 25 31): its commands, forms and blocks",
    ru="читать и память (11 13 15 21 23 25 31): команды, вид ответов, размер блоков",
)
@flag(
    "--passports",
    en="keep the texts of the unit's passports; without it they are in no file",
    ru="сохранить тексты паспортов блока; без ключа их нет ни в одном файле",
)
@option(
    "--voltmeter",
    type=positive,
    metavar="V",
    en="what a voltmeter at the battery shows, ignition on, engine off",
    ru="показание вольтметра на аккумуляторе при включённом зажигании без пуска, В",
)
@option(
    "--tachometer",
    type=positive,
    metavar="RPM",
    en="what the tachometer on the dashboard shows at idle",
    ru="показание тахометра на щитке на холостом ходу, об/мин",
)
@option(
    "--starter",
    type=positive,
    metavar="PUFFS",
    en="puffs of the engine in a second (two a turn) while the starter turned it, timed by hand",
    ru="тактов сжатия в секунду (два за оборот) при работе стартёра, счёт вручную",
)
@flag(
    "--without-engine",
    en="with the ignition on only; what needs the engine stays open",
    ru="только с включённым зажиганием; что требует двигателя, останется открытым",
)
@YES
@OVERWRITE
def survey(
    context: CommandContext,
    out: Path,
    *,
    memory: bool,
    passports: bool,
    voltmeter: float | None,
    tachometer: float | None,
    starter: float | None,
    without_engine: bool,
    yes: bool,
    overwrite: bool,
) -> None:
    from mikas.survey import SurveyOptions
    from mikas.survey.folder import check_free

    _check_name(out)
    check_free(out, overwrite=overwrite)
    if not yes and not sys.stdin.isatty():
        raise NotConfirmed(change=_CHANGE, how=_NO_TERMINAL)
    figures = _figures(voltmeter=voltmeter, tachometer=tachometer, starter=starter)
    with context.ecu() as ecu:
        options = SurveyOptions(memory=memory, passports=passports, engine=not without_engine)
        run, person = _prepared(context, ecu, out, options, figures, asks=not yes)
        try:
            run.run(lambda step, place, total: person.begin(step.title, place, total))
        except (KeyboardInterrupt, MikasError):
            person.clear()
            if run.folder.path.is_dir():
                context.say(
                    f"Stopped. What was measured is kept in {run.folder.path}; the same command "
                    "goes on from there.",
                    f"Прервано. Измеренное сохранено в {run.folder.path}; та же команда продолжит "
                    "с этого места.",
                )
            raise
        person.clear()
        answers = run.answers
        _show(context, answers)
        if not yes and not person.consents(_SAVE.filled(out=out)):
            raise NotConfirmed(
                change=_WRITING.filled(out=out), how=_KEPT.filled(folder=run.folder.path)
            )
        run.save(overwrite=overwrite)
    _end(context, out, answers, run)


def _check_name(out: Path) -> None:
    if out.suffix.lower() != ".zip":
        raise usage_error(f"{out}: a survey is a .zip file", f"{out}: обследование — это файл .zip")
    if not absolute(out).parent.is_dir():
        raise usage_error(f"{out}: there is no such folder", f"{out}: такой папки нет")


def _figures(**given: float | None) -> dict[str, float]:
    """Return the figures that were given. Raises `UsageError` for one that no car has."""
    from mikas.survey.steps.engine import FIGURES

    figures = {name: figure for name, figure in given.items() if figure is not None}
    for name, figure in figures.items():
        unit, low, high = FIGURES[name]
        if not low <= figure <= high:
            raise usage_error(
                f"--{name} {figure:g}: it must be from {low:g} to {high:g} {unit.en}",
                f"--{name} {figure:g}: нужно число от {low:g} до {high:g} {unit.ru}",
            )
    return figures


def _prepared(
    context: CommandContext,
    ecu: Ecu,
    out: Path,
    options: Any,  # noqa: ANN401  (SurveyOptions, which is imported late)
    figures: dict[str, float],
    *,
    asks: bool,
) -> tuple[Survey, TerminalPrompter]:
    """Return the survey, with the consents asked for where it begins, and the person."""
    from dataclasses import replace

    from mikas.cli.surveying import TerminalPrompter
    from mikas.survey import Survey
    from mikas.survey.folder import SurveyFolder

    person = TerminalPrompter(context.output, ecu.tester.link.now, asks, figures)
    if asks and SurveyFolder(out).load() is None:
        options = replace(
            options,
            memory=options.memory or person.consents(_MEMORY),
            passports=options.passports or person.consents(_PASSPORTS),
        )
    run = Survey(ecu, out, options, person)
    if run.goes_on:
        context.say(
            f"A survey that was stopped goes on: {run.folder.path}",
            f"Продолжается прерванное обследование: {run.folder.path}",
        )
        for consent, asked, begun in (
            ("--memory", options.memory, run.measured["memory"]),
            ("--passports", options.passports, run.measured["passports_consent"]),
        ):
            if asked and not begun:
                context.say(
                    f"It was begun without {consent}, and stays so. To begin again with it, remove "
                    f"{run.folder.path}",
                    f"Оно начато без {consent}, так и останется. Чтобы начать заново, удалите "
                    f"{run.folder.path}",
                )
    return run, person


def _show(context: CommandContext, answers: Sequence[SurveyAnswer]) -> None:
    """Print what will be in the file: on stdout for people, on stderr beside JSON nothing."""
    from mikas.survey.readme import verdict_word

    if context.output.json:
        return
    context.output.listing(
        answers,
        {
            tr("question", "вопрос"): lambda each: localized(each.title),
            tr("clause", "пункт"): lambda each: " ".join(each.clauses),
            tr("verdict", "итог"): lambda each: verdict_word(each, current_language()),
            tr("answer", "ответ"): lambda each: localized(each.text),
        },
    )
    context.say(
        "The file holds these answers, the figures behind them, the unit's profile and the bytes "
        "on the wire, without name, place or date.",
        "В файле будут эти ответы, измеренные числа, профиль блока и байты на линии, без имён, "
        "места и даты.",
    )


def _end(context: CommandContext, out: Path, answers: Sequence[SurveyAnswer], run: Survey) -> None:
    seconds = run.seconds
    if context.output.json:
        context.output.data(
            {
                "out": str(out),
                "steps": [
                    {
                        "name": each.id,
                        "ok": True if each.verdict.value == "found" else None,
                        "detail": localized(each.text),
                        "verdict": each.verdict.value,
                        "clauses": each.clauses,
                    }
                    for each in answers
                ],
                "seconds": seconds,
            }
        )
        return
    found = sum(each.verdict.value == "found" for each in answers)
    minutes = sum(seconds.values()) / 60
    context.say(
        f"{out}: {found} of {len(answers)} questions found, {minutes:.1f} min of measuring.",
        f"{out}: найдено ответов {found} из {len(answers)}, измерения заняли {minutes:.1f} мин.",
    )
    context.say(*(_FOR_TRYING if run.is_virtual else _SEND))


_CHANGE = Text("survey the unit", "обследовать блок")
_SEND = Text(
    "Send the file with an issue at github.com/mikas-diagnostics/mikas: thank you.",
    "Приложите файл к обращению на github.com/mikas-diagnostics/mikas: спасибо.",
)
_FOR_TRYING = Text(
    "This is a virtual unit, for trying only (a pty counts as one, too): don't send the file.",
    "Это виртуальный блок, только для пробы (им считается и pty): файл не отправляйте.",
)
_NO_TERMINAL = Text(
    "There is no terminal to ask on; --yes confirms in advance.",
    "Нет терминала, чтобы спросить; подтвердить заранее можно ключом --yes.",
)
_MEMORY = Text(
    "May memory be read, too (commands 11–31)? It is not known how a real unit takes them. Its "
    "blocks are in the file only if the passports' texts may be.",
    "Можно ли прочитать и память (команды 11–31)? Как их примет настоящий блок, неизвестно. В файл "
    "блоки памяти попадут, только если можно сохранить и тексты паспортов.",
)
_PASSPORTS = Text(
    "May the texts of the unit's passports be in the file (part number, date of the program, "
    "perhaps the unit's serial number)?",
    "Можно ли сохранить в файле тексты паспортов блока (номер, дата программы, возможно, серийный "
    "номер блока)?",
)
_SAVE = Text("Save it as {out}?", "Сохранить в {out}?")
_WRITING = Text("write {out}", "записать {out}")
_KEPT = Text(
    "What was measured stays in {folder}; remove that folder to forget it.",
    "Измеренное остаётся в {folder}; чтобы забыть, удалите эту папку.",
)
