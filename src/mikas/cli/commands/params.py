"""`mikas params`: every known parameter. Needs no port."""

from __future__ import annotations

from typing import Any

from mikas.catalog import Catalog, Parameter
from mikas.cli.grammar import command
from mikas.cli.readings import reference
from mikas.cli.run import Run
from mikas.cli.words import say, shown
from mikas.language import Text


@command(
    "params",
    Text(
        "Lists every known parameter with its code, unit, formula, limits and errata. Needs no "
        "port.",
        "Показывает все известные параметры: код, единицу, формулу, пределы, сомнительные места. "
        "Порт не нужен.",
    ),
    examples=("mikas params", "mikas params --reading literal", "mikas params --json"),
)
def params(run: Run) -> None:
    catalog = run.catalog()
    if run.output.json:
        run.output.data(
            {
                "catalog": catalog.version,
                "parameters": [_as_json(catalog, p, run.reading) for p in catalog.parameters],
            }
        )
        return
    headers = [
        say("name", "имя"), say("code", "код"), say("bytes", "байт"), say("formula", "формула"),
        say("unit", "ед."), say("warm idle", "на хх"), say("meaning", "что это"), say("see", "см."),
    ]  # fmt: skip
    run.output.table(headers, [_row(p, run.reading) for p in catalog.parameters], right="2")
    used = sorted({name for p in catalog.parameters for name in p.errata})
    for name in used:
        erratum = catalog.errata[name]
        run.output.note(f"{name}: {shown(erratum.title)}. {shown(erratum.reason)}")


def _row(parameter: Parameter, reading: str) -> list[str]:
    return [
        parameter.name,
        f"{parameter.code:02X}",
        str(parameter.size),
        parameter.formula(reading),
        shown(parameter.reading(reading).unit_text),
        reference(parameter),
        shown(parameter.text),
        " ".join(parameter.errata),
    ]


def _as_json(catalog: Catalog, parameter: Parameter, reading: str) -> dict[str, Any]:
    errata = [catalog.errata[name] for name in parameter.errata]
    return {
        "name": parameter.name,
        "code": f"{parameter.code:02X}",
        "size": parameter.size,
        "unit": parameter.reading(reading).unit,
        "formula": parameter.formula(reading),
        "limits": parameter.limits(reading),
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
