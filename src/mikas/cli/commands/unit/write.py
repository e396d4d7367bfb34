"""`mikas write`: a parameter by its physical value, or by raw bytes; reads back."""

from __future__ import annotations

from functools import partial

import click

from mikas.catalog import Parameter
from mikas.cli.click_extensions import YES, command, option
from mikas.cli.context import CommandContext
from mikas.cli.language import tr
from mikas.cli.parameter_types import HexBytes
from mikas.cli.render.readings import shown_unit, shown_value
from mikas.client import Reading
from mikas.client.parameters import decode
from mikas.errors import UsageError
from mikas.i18n import Text


@command(
    "write",
    Text(
        "Writes parameter NAME by its physical VALUE or by raw bytes (low byte first): asks "
        "first, then reads it back.",
        "Записывает в параметр NAME физическое значение VALUE или байты (младший первым): "
        "спрашивает подтверждение, затем проверяет чтением.",
    ),
    examples=("mikas write UOZ 12.5", "mikas write INJ --raw 5802", "mikas write UOZ 12.5 --yes"),
    context_settings={"ignore_unknown_options": True},
)
@click.argument("name", metavar="NAME")
@click.argument("value", metavar="[VALUE]", required=False)
@option(
    "--raw",
    type=HexBytes(),
    metavar="HEX",
    text=Text("raw bytes instead of VALUE", "байты вместо VALUE"),
)
@YES
def write(
    context: CommandContext, name: str, value: str | None, raw: bytes | None, *, yes: bool
) -> None:
    number = None if value is None else _number(value)
    if (number is None) == (raw is None):
        raise UsageError(
            problem=Text(
                "Give either a VALUE or --raw HEX", "Нужно либо значение VALUE, либо --raw HEX"
            )
        )
    meaning = partial(_meaning, context.catalog().parameter(name), context.interpretation)
    with context.ecu(context.confirm(yes=yes, meaning=meaning)) as ecu:
        written = ecu.write_parameter(name, number, raw=raw)
    if context.output.json:
        context.output.data(
            {
                "name": written.name,
                "before": written.before and written.before.value,
                "after": written.after and written.after.value,
                "raw_before": written.before and written.before.raw,
                "raw_after": written.after and written.after.raw,
            }
        )
        return
    context.output.line(f"{written.name}: {_shown(written.before)} → {_shown(written.after)}")


def _number(text: str) -> float:
    try:
        number = float(text.replace(",", "."))
    except ValueError:
        raise UsageError(
            problem=Text(f"“{text}” is not a number", f"«{text}» — не число")
        ) from None
    return int(number) if number.is_integer() else number


def _meaning(parameter: Parameter, interpretation: str, hexed: str) -> str:
    """`13.5 ° crank (1B)`."""
    shown = _shown(decode(parameter, bytes.fromhex(hexed), 0.0, interpretation))
    return f"{shown} ({hexed})"


def _shown(reading: Reading | None) -> str:
    if reading is None:
        return tr("can't be read", "не читается")
    return f"{shown_value(reading)} {shown_unit(reading)}".rstrip()
