"""`mikas params`: every known parameter. Needs no port."""

from __future__ import annotations

from typing import Any

from mikas.catalog import Catalog, Derived, Parameter
from mikas.cli.click_extensions import command
from mikas.cli.context import CommandContext
from mikas.cli.language import localized, tr
from mikas.cli.render.readings import reference
from mikas.i18n import Text


@command(
    "params",
    Text(
        "Lists every known parameter with its code, unit, formula, limits and errata, then the "
        "derived channels. Needs no port.",
        "Показывает все известные параметры: код, единицу, формулу, пределы, сомнительные места; "
        "затем расчётные каналы. Порт не нужен.",
    ),
    examples=("mikas params", "mikas params --interpretation literal", "mikas params --json"),
)
def params(context: CommandContext) -> None:
    catalog = context.catalog()
    if context.output.json:
        context.output.data(
            {
                "catalog": catalog.version,
                "parameters": [
                    _as_json(catalog, p, context.interpretation) for p in catalog.parameters
                ],
                "derived": [_derived_as_json(channel) for channel in catalog.derived.values()],
            }
        )
        return
    headers = [
        tr("name", "имя"), tr("code", "код"), tr("bytes", "байт"), tr("formula", "формула"),
        tr("unit", "ед."), tr("warm idle", "на ХХ"), tr("meaning", "параметр"), tr("notes", "см."),
    ]  # fmt: skip
    rows = [_row(p, context.interpretation) for p in catalog.parameters]
    rows += [_derived_row(channel) for channel in catalog.derived.values()]
    context.output.table(headers, rows, right="2")
    used = sorted({name for p in catalog.parameters for name in p.errata})
    for name in used:
        erratum = catalog.errata[name]
        context.output.note(f"{name}: {localized(erratum.title)}. {localized(erratum.reason)}")


def _row(parameter: Parameter, interpretation: str) -> list[str]:
    return [
        parameter.name,
        f"{parameter.code:02X}",
        str(parameter.size),
        parameter.formula(interpretation),
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


def _derived_as_json(channel: Derived) -> dict[str, Any]:
    return {
        "name": channel.name,
        "unit": channel.unit,
        "formula": channel.formula,
        "constants": dict(channel.constants),
        "inputs": channel.inputs,
        "accumulates": channel.accumulates,
        "text": {"en": channel.text.en, "ru": channel.text.ru},
        "source": channel.source,
        "confidence": channel.confidence,
    }


def _as_json(catalog: Catalog, parameter: Parameter, interpretation: str) -> dict[str, Any]:
    errata = [catalog.errata[name] for name in parameter.errata]
    return {
        "name": parameter.name,
        "code": f"{parameter.code:02X}",
        "size": parameter.size,
        "unit": parameter.interpretation(interpretation).unit,
        "formula": parameter.formula(interpretation),
        "limits": parameter.limits(interpretation),
        "plausible": parameter.plausible,
        "reference": parameter.reference,
        "text": {"en": parameter.text.en, "ru": parameter.text.ru},
        "source": parameter.source,
        "confidence": parameter.confidence,
        "errata": [
            {"name": e.name, "title": {"en": e.title.en, "ru": e.title.ru},
             "reason": {"en": e.reason.en, "ru": e.reason.ru}}
            for e in errata
        ],
    }  # fmt: skip
