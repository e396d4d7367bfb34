"""`mikas read`: one reading of each parameter named, or of all."""

from __future__ import annotations

import click

from mikas.cli.click_extensions import command
from mikas.cli.context import CommandContext
from mikas.cli.language import localized, tr
from mikas.cli.render.readings import as_json, shown_unit, shown_value, verdict
from mikas.client import Reading
from mikas.i18n import Text


@command(
    "read",
    Text(
        "Reads each NAME once; with no name, every parameter that the unit knows. A raw code is "
        "written 0x1A, or 0x3F:2 for two bytes.",
        "Читает каждый параметр NAME один раз; без имён — все, которые знает блок. Код без имени "
        "пишется 0x1A, двухбайтовый 0x3F:2.",
    ),
    examples=("mikas read", "mikas read TWAT FREQ UACC", "mikas read 0x3F:2 --json"),
)
@click.argument("names", metavar="[NAME]...", nargs=-1)
def read(context: CommandContext, names: tuple[str, ...]) -> None:
    with context.ecu() as ecu:
        readings = ecu.read(*names)
        missing = [p.name for p in ecu.catalog.parameters if p.name not in readings]
    if context.output.json:
        context.output.data({"readings": {name: as_json(r) for name, r in readings.items()}})
    else:
        headers = [
            tr("name", "имя"), tr("value", "значение"), tr("unit", "ед."),
            tr("raw", "байты"), tr("warm idle", "на ХХ"), tr("meaning", "параметр"),
            tr("notes", "см."),
        ]  # fmt: skip
        context.output.table(headers, [_row(name, r) for name, r in readings.items()], right="1")
        if any(r.parameter.errata for r in readings.values()):
            context.output.note(
                tr("Notes E1 … are explained by: mikas params", "Пояснения к E1 …: mikas params")
            )
    if missing and not names:
        context.output.note(
            tr("This unit does not know: ", "Этот блок не знает: ") + ", ".join(missing)
        )


def _row(name: str, reading: Reading) -> list[str]:
    return [
        name,
        shown_value(reading),
        shown_unit(reading),
        reading.raw.hex(" ").upper(),
        verdict(reading),
        localized(reading.parameter.text),
        " ".join(reading.parameter.errata),
    ]
