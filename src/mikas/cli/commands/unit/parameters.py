"""`mikas params`, `read`, `write`: parameters of the catalog and of the connected unit."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Any

from mikas.catalog import Catalog, Derived, Parameter
from mikas.catalog.undecided import otherwise
from mikas.cli.click_extensions import YES, argument, command, option
from mikas.cli.completion.values import channel_names
from mikas.cli.context import CommandContext
from mikas.cli.language import localized, tr
from mikas.cli.options.common import RELEARN
from mikas.cli.options.parameter_types import hex_bytes
from mikas.cli.render.values import (
    meaning_text,
    reading_json,
    reading_name,
    reference,
    unit_text,
    value_text,
)
from mikas.client import Reading
from mikas.client.parameters.derived import DerivedValue
from mikas.client.parameters.once import Once
from mikas.client.parameters.parameters import datum_to_write
from mikas.client.parameters.readings import decode
from mikas.errors import usage_error
from mikas.json_values import picked


@command(
    en="Lists every known parameter with its code, unit, formula, limits and errata, then the "
    "derived channels. Needs no port.",
    ru="Показывает все известные параметры: код, единицу, формулу, пределы, сомнительные места; "
    "затем производные каналы. Порт не нужен.",
    examples=("mikas params", "mikas params --interpretation literal", "mikas params --json"),
)
def params(context: CommandContext) -> None:
    catalog = context.options.catalog
    if context.output.json:
        context.output.data(
            {
                "catalog": catalog.version,
                "parameters": [
                    _parameter_json(catalog, p, context.options.interpretation)
                    for p in catalog.parameters
                ],
                "derived": [_derived_json(channel) for channel in catalog.derived.values()],
            }
        )
        return
    headers = [
        tr("name", "имя"), tr("code", "код"), tr("bytes", "байт"), tr("formula", "формула"),
        tr("unit", "ед."), tr("warm idle", "на ХХ"), tr("meaning", "параметр"), tr("notes", "см."),
    ]  # fmt: skip
    rows = [_parameter_row(p, context.options.interpretation) for p in catalog.parameters]
    rows += [_derived_row(channel) for channel in catalog.derived.values()]
    context.output.table(headers, rows, right="2")
    used = sorted({name for p in catalog.parameters for name in p.errata})
    for name in used:
        erratum = catalog.errata[name]
        context.output.print_note(
            f"{name}: {localized(erratum.title)}. {localized(erratum.reason)}"
        )
    context.say("What each rests on: mikas evidence", "На чём что держится: mikas evidence")


def _parameter_row(parameter: Parameter, interpretation: str) -> list[str]:
    formulas = [parameter.formula(interpretation)]
    for name, each in otherwise(parameter, interpretation).items():
        formulas.append(f"{reading_name(name)}: {each.formula}")
    return [
        parameter.name,
        f"{parameter.code:02X}",
        str(parameter.size),
        "; ".join(formulas),
        localized(parameter.interpretation(interpretation).unit_text),
        reference(parameter),
        localized(parameter.text),
        " ".join(parameter.errata),
    ]


def _derived_row(channel: Derived) -> list[str]:
    """Return a row; a computed channel has no code and no bytes."""
    formula = f"∫ {channel.formula}" if channel.accumulates else channel.formula
    unit, text = localized(channel.unit_text), localized(channel.text)
    return [channel.name, "", "", formula, unit, "", text, ""]


def _derived_json(channel: Derived) -> dict[str, Any]:
    names = ("inputs", "accumulates", "text", "source", "confidence")
    constants = {"constants": dict(channel.constants)}
    return picked(channel, "name", "unit", "formula") | constants | picked(channel, *names)


def _parameter_json(catalog: Catalog, parameter: Parameter, interpretation: str) -> dict[str, Any]:
    from mikas.catalog.grounds import parameter_grounds

    errata = (catalog.errata[name] for name in parameter.errata)
    others = otherwise(parameter, interpretation)
    return {
        "name": parameter.name,
        "code": f"{parameter.code:02X}",
        "size": parameter.size,
        "unit": parameter.interpretation(interpretation).unit,
        "formula": parameter.formula(interpretation),
        "limits": parameter.limits(interpretation),
        **picked(parameter, "plausible", "reference", "text", "source", "confidence"),
        "errata": [picked(each, "name", "title", "reason") for each in errata],
        "otherwise": [
            picked(each, "formula", "unit") | {"name": it} for it, each in others.items()
        ],
        "evidence": parameter_grounds(parameter).statement_json(),
    }


@command(
    en="Reads each NAME once; with no name, every parameter that the unit knows. A raw code is "
    "written 0x1A, or 0x3F:2 for two bytes. A derived channel is computed from the parameters that "
    "it needs.",
    ru="Читает каждый параметр NAME один раз; без имён — все, которые знает блок. Код без имени "
    "пишется 0x1A, двухбайтовый 0x3F:2. Производный канал вычисляется из нужных ему параметров.",
    examples=("mikas read", "mikas read TWAT FREQ FUEL_FLOW", "mikas read 0x3F:2 --json"),
)
@argument("names", "[NAME]...", nargs=-1, shell_complete=channel_names)
@RELEARN
def read(context: CommandContext, names: tuple[str, ...]) -> None:
    Once(context.options.catalog, names)  # checks, before anything is opened
    with context.ecu() as ecu:
        readings = ecu.read(*names)
        missing = [p.name for p in ecu.catalog.parameters if p.name not in readings]
    show_readings(context, readings)
    if missing and not names:
        context.output.print_note(
            tr("This unit does not know: ", "Этот блок не знает: ") + ", ".join(missing)
        )


def show_readings(context: CommandContext, readings: Mapping[str, Reading | DerivedValue]) -> None:
    """Print `readings` by name, as JSON or as a table."""
    if context.output.json:
        context.output.data({"readings": {name: reading_json(r) for name, r in readings.items()}})
        return
    context.output.listing(
        readings.items(),
        {
            tr("name", "имя"): lambda it: it[0],
            tr("value", "значение"): lambda it: value_text(it[1]),
            tr("unit", "ед."): lambda it: unit_text(it[1]),
            tr("raw", "байты"): lambda it: it[1].raw.hex(" ").upper(),
            tr("warm idle", "на ХХ"): lambda it: _reference(it[1]),
            tr("meaning", "параметр"): lambda it: meaning_text(it[1]),
            tr("notes", "см."): lambda it: " ".join(it[1].channel.errata),
        },
        right="1",
    )
    for each in readings.values():
        if isinstance(each, DerivedValue) and not each.has_value:
            context.output.print_note(_no_result(each))
    if any(r.channel.errata for r in readings.values()):
        context.say("Notes E1 … are explained by: mikas params", "Пояснения к E1 …: mikas params")


def _reference(reading: Reading | DerivedValue) -> str:
    """Return the reference range; nothing under an interpretation in which it would not hold."""
    return reference(reading.channel) if reading.interpretation == "corrected" else ""


def _no_result(value: DerivedValue) -> str:
    """Return why a derived channel has no value: its formula has no result now."""
    at = ", ".join(f"{name} {value_text(each)}" for name, each in value.inputs.items())
    return tr(
        f"{value.name}: the formula {value.channel.formula} has no result at {at}",
        f"{value.name}: у формулы {value.channel.formula} нет результата при {at}",
    )


@command(
    en="Writes parameter NAME by its physical VALUE or by raw bytes (low byte first): asks "
    "first, then reads it back.",
    ru="Записывает в параметр NAME физическое значение VALUE или байты (младший первым): "
    "спрашивает подтверждение, затем проверяет чтением.",
    examples=("mikas write UOZ 12.5", "mikas write INJ --raw 5802", "mikas write UOZ 12.5 --yes"),
    context_settings={"ignore_unknown_options": True},
)
@argument("name", "NAME", shell_complete=channel_names)
@argument("value", "[VALUE]", required=False)
@option(
    "--raw",
    type=hex_bytes,
    metavar="HEX",
    en="raw bytes instead of VALUE",
    ru="байты вместо VALUE",
)
@RELEARN
@YES
def write(
    context: CommandContext, name: str, value: str | None, raw: bytes | None, *, yes: bool
) -> None:
    number = None if value is None else _number(value)
    if (number is None) == (raw is None):
        raise usage_error(
            "Give either a VALUE or --raw HEX", "Нужно либо значение VALUE, либо --raw HEX"
        )
    interpretation = context.options.interpretation
    parameter = context.options.catalog.parameter(name)
    datum_to_write(parameter, number, raw, interpretation)  # checks, before anything is opened
    meaning = partial(_meaning, parameter, interpretation)
    with context.ecu(context.confirm(yes=yes, meaning=meaning)) as ecu:
        written = ecu.write_parameter(name, number, raw=raw)
    context.output.result(
        {
            "name": written.name,
            "before": written.before and written.before.value,
            "after": written.after and written.after.value,
            "raw_before": written.before and written.before.raw,
            "raw_after": written.after and written.after.raw,
        },
        f"{written.name}: {_shown(written.before)} → {_shown(written.after)}",
    )


def _number(text: str) -> float:
    try:
        number = float(text.replace(",", "."))
    except ValueError:
        raise usage_error(f"“{text}” is not a number", f"«{text}» — не число") from None
    return int(number) if number.is_integer() else number


def _meaning(parameter: Parameter, interpretation: str, hexed: str) -> str:
    """`13.5 ° crank (1B)`."""
    shown = _shown(decode(parameter, bytes.fromhex(hexed), 0.0, interpretation))
    return f"{shown} ({hexed})"


def _shown(reading: Reading | None) -> str:
    if reading is None:
        return tr("can't be read", "не читается")
    return f"{value_text(reading)} {unit_text(reading)}".rstrip()
