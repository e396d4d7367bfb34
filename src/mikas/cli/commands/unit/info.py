"""`mikas info`: model, passports, supported commands."""

from __future__ import annotations

from mikas.catalog import Catalog
from mikas.cli.click_extensions import command, flag
from mikas.cli.context import CommandContext
from mikas.cli.language import decimal, localized, tr
from mikas.cli.options.common import RELEARN
from mikas.client import Ecu, Info, Support
from mikas.client.limits import STARTING_LIST
from mikas.client.parameters.polling import FixedMethod
from mikas.client.support import each_command
from mikas.commands.unit import version_text
from mikas.i18n import Text
from mikas.link.urls import parse
from mikas.sampling.plan import Plan, PlannedParameter
from mikas.sampling.running.method_knowledge import rates_of

_BAUD = 9600  # §1


@command(
    en="Shows the ECU's model and passports and the commands that it knows. Every command is "
    "tried once that changes nothing but the unit's list (64; a list that another program has "
    "set is lost): 1 s for each without a response, 2 s for each stream; streams by strokes "
    "only with the engine turning. For a recording (replay:) the result is that of the "
    "recorded requests.",
    ru="Показывает модель и паспорта блока и команды, которые он знает. Один раз проверяется "
    "каждая команда, которая не меняет ничего, кроме списка блока (64; список, заданный другой "
    "программой, будет потерян): 1 с на каждую без ответа, 2 с на каждый поток; потоки по "
    "тактам — только при вращающемся двигателе. Для записи (replay:) результат берётся из "
    "записанных запросов.",
    examples=("mikas info", "mikas info --quick", "mikas info --port socket://192.168.1.5:2000"),
)
@flag("--quick", en="do not try the commands", ru="не проверять команды")
@RELEARN
def info(context: CommandContext, *, quick: bool) -> None:
    with context.ecu() as ecu:
        found = ecu.info()
        recorded = parse(ecu.tester.link.url).scheme == "replay"
        supported = [] if quick else _recorded_support(ecu) if recorded else list(ecu.supported())
        catalog = ecu.catalog
    if context.output.json:
        context.output.data(
            {
                "model": found.model.text.en,
                "version_code": version_text(found.version_code),
                "program_passport": found.passport.program,
                "data_passport": found.passport.data,
                "parameter_count": found.parameter_count,
                "echo": found.echo,
                "supported": {support.name: support.known for support in supported},
                "not_tried": {it.name: it.reason._asdict() for it in supported if it.reason},
                "pause": found.pause,
                "limits": {
                    "max_list": found.limits.max_list,
                    "max_block": found.limits.max_block,
                    "refused": [f"{code:02X}" for code in found.limits.refused],
                    "pause": found.limits.pause,
                    "methods": {
                        adapter: {method: round(rate, 1) for method, rate in rates.items()}
                        for adapter, rates in _rates(found, catalog).items()
                    },
                },
                "catalog": catalog.version,
            }
        )
        return
    unreported = (
        tr("not in the recording", "в записи нет")
        if recorded
        else tr("not reported by this unit", "блок не сообщает")
    )
    rows = _rows(found, catalog, unreported)
    context.output.table([], [*rows, *_support_rows(supported, unreported if recorded else None)])


def _recorded_support(ecu: Ecu) -> list[Support]:
    """Return which commands the recorded unit knew: trying them shows only the recorded ones."""
    from mikas.replay import playing

    car = playing(ecu.tester.link)
    if car is None:
        return []
    return [Support(each, codes[0], car.recorded.knows(codes)) for each, codes in each_command()]


def _rows(found: Info, catalog: Catalog, unknown: str) -> list[list[str]]:
    passport = found.passport
    rows = [
        [tr("model", "модель"), f"{localized(found.model.text)} ({found.version_code:02X})"],
        [tr("program", "программа"), _pieces(passport.program) or unknown],
        [tr("data", "данные"), _pieces(passport.data) or unknown],
        [
            tr("parameters", "параметры"),
            unknown if found.parameter_count is None else str(found.parameter_count),
        ],
        [tr("echo", "эхо"), tr("yes", "есть") if found.echo else tr("no", "нет")],
    ]
    if found.pause:
        rows.append([tr("pause", "пауза"), _pause(found.pause)])
    limits = found.limits
    if limits.max_list != STARTING_LIST or limits.max_block or limits.refused:
        blocks = ", ".join(f"{space} {count}" for space, count in limits.max_block.items())
        refused = " ".join(f"{code:02X}" for code in limits.refused)
        rows.append(
            [
                tr("limits", "ограничения"),
                tr(
                    f"lists up to {limits.max_list}; blocks {blocks or '–'}; "
                    f"unknown parameters {refused or '–'}",
                    f"списки до {limits.max_list}; блоки {blocks or '–'}; "
                    f"неизвестные параметры {refused or '–'}",
                ),
            ]
        )
    for adapter, rates in _rates(found, catalog).items():
        order = sorted(rates, key=lambda method: -rates[method])
        listed = ", ".join(f"{m} {rates[m]:.1f}" if rates[m] else f"{m} –" for m in order)
        rows.append(
            [
                tr("sampling", "опрос"),
                tr(
                    f"all parameters, readings/s: {listed} ({adapter})",
                    f"все параметры, опр/с: {decimal(listed)} ({adapter})",
                ),
            ]
        )
    return rows


def _pause(seconds: float) -> str:
    """Return the pause before each request, in words."""
    milliseconds = f"{seconds * 1000:g}"
    return tr(
        f"{milliseconds} ms between a response and the next request",
        f"{decimal(milliseconds)} мс между ответом и следующим запросом",
    )


def _rates(found: Info, catalog: Catalog) -> dict[str, dict[FixedMethod, float]]:
    """Return readings of all parameters a second, by kind of adapter; 0: not supported."""
    refused = set(found.limits.refused)
    wanted = tuple(PlannedParameter(p) for p in catalog.parameters if p.code not in refused)
    if not wanted:
        return {}
    plan = Plan(wanted, max_list=found.limits.max_list)
    learnt = found.limits.methods
    return {adapter: rates_of(plan, paces, _BAUD) for adapter, paces in learnt.items()}


def _pieces(pieces: tuple[str | None, ...]) -> str:
    return " · ".join(piece for piece in pieces if piece)


def _named(support: Support) -> str:
    return f"{support.code:02X} {localized(support.title)}"


def _support_rows(supported: list[Support], unreported: str | None) -> list[list[str]]:
    words = {
        True: tr("known", "знает"),
        False: tr("unknown", "не знает"),
        None: unreported or tr("not tried", "не проверялось"),
    }
    names: dict[tuple[bool | None, Text | None], list[str]] = {}
    for support in sorted(supported, key=lambda it: list(words).index(it.known)):
        names.setdefault((support.known, support.reason), []).append(_named(support))
    return [
        [words[known], (f"{localized(why)}: " if why else "") + "; ".join(each)]
        for (known, why), each in names.items()
    ]
