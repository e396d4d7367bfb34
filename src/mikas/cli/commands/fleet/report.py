"""`mikas fleet report`: all cars of a dataset, compared and followed over time."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from mikas.cli.click_extensions import OVERWRITE, argument, command, output_option
from mikas.cli.commands.fleet.refused import say_refused
from mikas.cli.completion.values import folders
from mikas.cli.context import CommandContext
from mikas.cli.language import current_language, localized
from mikas.cli.render.terminal import cell_text
from mikas.json_values import picked

if TYPE_CHECKING:
    from mikas.fleet.report.causes import JudgedDrive
    from mikas.fleet.report.findings import CarFindings, FleetFindings
    from mikas.i18n import Text


@command(
    en="Reports on all cars of DATASET: faults over time, values at warm idle that drift or leave "
    "their normal range, charging and thermostat, and cars that differ from the others. With "
    "-o a page to read, print or send; without it the findings as text.",
    ru="Отчёт по всем машинам набора DATASET: ошибки по времени, значения на прогретом холостом "
    "ходу, которые уходят или вышли из нормы, зарядка и термостат, машины, непохожие на "
    "остальные. С ключом -o — страница, которую можно прочитать, напечатать или переслать; без "
    "него — список найденного.",
    examples=(
        "mikas fleet report dataset",
        "mikas fleet report dataset -o fleet.html --lang ru",
    ),
)
@argument("dataset", "DATASET", shell_complete=folders)
@output_option(
    required=False,
    en="the page, an .html file",
    ru="страница, файл .html",
)
@OVERWRITE
def report(context: CommandContext, dataset: str, out: Path | None, *, overwrite: bool) -> None:
    from mikas.fleet.places import require_database

    require_database(asked=True)
    from mikas.fleet.query.database import opened
    from mikas.fleet.report.figures import figures
    from mikas.fleet.report.findings import find
    from mikas.fleet.report.page import render, today
    from mikas.report.page import check_output, write_page

    if out is not None:
        check_output(out, overwrite=overwrite)
    catalog = context.options.catalog
    with opened(dataset) as database:
        found = find(figures(database, catalog, today()), catalog)
        refused = database.ledger.refused
    if out is not None:
        write_page(out, render(found, current_language()), overwrite=overwrite)
    say_refused(context, refused)
    _print(context, found, out, refused)


def _print(
    context: CommandContext, found: FleetFindings, out: Path | None, refused: Mapping[str, Text]
) -> None:
    from mikas.fleet.report.causes import car_words, latest
    from mikas.fleet.report.sentences import car_sentences, headline, unknowns

    if context.output.json:
        context.output.data(
            {
                "out": None if out is None else str(out),
                "outcome": found.outcome.value,
                "verdict": headline(found)._asdict(),
                "cars": [_as_json(car, found) for car in found.cars],
                "unknown": [text._asdict() for text in unknowns(found)],
                "refused": [{"file": name, "reason": it._asdict()} for name, it in refused.items()],
            }
        )
        return
    verdict = cell_text(localized(headline(found)))
    if out is not None:
        context.output.print_note(f"{verdict}\n{out}")
        return
    context.output.line(verdict)
    for car in found.cars:
        for text in car_sentences(car, found):
            context.output.line(cell_text(f"{car.figures.car}: {localized(text)}"))
        judged = latest(car.figures.judged)
        if judged is not None and judged.text is not None:
            words = car_words(car.figures.judged) or judged.words
            context.output.line(cell_text(f"{car.figures.car}: {localized(words)}"))


def _judged(drive: JudgedDrive) -> dict[str, object]:
    return {
        "began": drive.began.isoformat(),
        "seconds": round(drive.seconds, 3),
        "verdict": drive.verdict,
        "likelihood": drive.likelihood,
        "text": drive.text._asdict() if drive.text else None,
    }


def _as_json(car: CarFindings, found: FleetFindings) -> dict[str, object]:
    from mikas.fleet.report.sentences import car_sentences

    figures = car.figures
    return {
        **picked(figures, "car", "name", "drives"),
        "seconds": round(figures.seconds, 3),
        "found": car.found,
        "causes": [_judged(it) for it in figures.judged],
        "texts": [text._asdict() for text in car_sentences(car, found)],
        "faults": [
            {
                "code": it.fault.code,
                "stored": it.is_stored,
                "first": it.first.isoformat(),
                "last": it.last.isoformat(),
            }
            for it in car.faults
        ],
        "out_of_range": [
            {
                "measure": measure.key,
                "value": value,
                "reference": measure.channel(found.catalog).reference,
            }
            for measure, value in car.out_of_range.items()
        ],
        "stands_out": [
            {
                "measure": measure.key,
                **picked(it, "value", "others", "low", "high"),
                "cars": it.count,
            }
            for measure, it in car.stands_out.items()
        ],
        "changes": [
            {"measure": measure.key, **picked(it, "first", "last"), "drives": it.count}
            for measure, it in car.changes.items()
        ],
    }
