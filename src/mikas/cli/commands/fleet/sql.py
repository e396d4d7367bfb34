"""`mikas fleet sql`: a question to a dataset, as a table, CSV or JSON."""

from __future__ import annotations

import csv
import io
import json
import math
import sys
from collections.abc import Iterable
from datetime import date, datetime
from decimal import Decimal
from itertools import chain, islice
from typing import TYPE_CHECKING, Any

from mikas.cleaning import spreadsheet_text
from mikas.cli.click_extensions import argument, command, flag
from mikas.cli.commands.fleet.refused import say_refused
from mikas.cli.completion.values import folders
from mikas.cli.context import CommandContext
from mikas.cli.language import decimal

if TYPE_CHECKING:
    from mikas.fleet.query.database import QueryRows

MOST = 1000
"""Rows of a table on a terminal."""


@command(
    en="Asks DATASET by SQL (DuckDB's): SELECT, DESCRIBE, SUMMARIZE or EXPLAIN. Its tables: "
    "drives, samples, statistics, faults, gaps, alarms, each with car and day. DATASET is only "
    "read, and SQL can reach no other file.",
    ru="Запрос к набору DATASET на SQL (DuckDB): SELECT, DESCRIBE, SUMMARIZE или EXPLAIN. "
    "Таблицы: drives, samples, statistics, faults, gaps, alarms; в каждой есть car и day. "
    "Набор только читается, к другим файлам из SQL доступа нет.",
    examples=(
        "mikas fleet sql dataset 'SELECT car, count(*) FROM drives GROUP BY car'",
        "mikas fleet sql dataset 'FROM samples WHERE TWAT > 100' --csv",
        "mikas fleet sql dataset 'DESCRIBE samples' --json",
    ),
)
@argument("dataset", "DATASET", shell_complete=folders)
@argument("sql", "SQL")
@flag(
    "--csv",
    "as_csv",
    en="print CSV with commas and decimal points",
    ru="вывести CSV (запятые, точка в числах)",
)
def sql(context: CommandContext, dataset: str, sql: str, *, as_csv: bool) -> None:
    from mikas.fleet.places import require_database

    require_database(asked=True)
    from mikas.fleet.query.database import opened
    from mikas.fleet.query.memory import bounded_memory

    with opened(dataset) as database, bounded_memory():
        try:
            answer = database.ask(sql)
        finally:  # the question may be what has found a file that can't be used
            say_refused(context, database.ledger.refused)
        if context.output.json:
            rows = ([_json(value) for value in row] for row in answer.rows)
            context.output.long_data({"columns": answer.columns}, "rows", rows)
        elif as_csv:
            for row in chain([answer.columns], answer.rows):
                context.output.line(_csv_line(_plain(_harmless(value)) for value in row))
        else:
            _print_table(context, answer)


def _print_table(context: CommandContext, answer: QueryRows) -> None:
    rows = answer.rows
    if sys.stdout.isatty():
        shown = list(islice(rows, MOST))
        numbers = [
            str(at)
            for at in range(min(10, len(answer.columns)))
            if any(isinstance(row[at], int | float | Decimal) for row in shown[:50])
        ]
        cells = [[_cell(value) for value in row] for row in shown]
        context.output.table(answer.columns, cells, right="".join(numbers))
        if next(rows, None) is not None:
            context.say(
                f"Only the first {MOST} rows are shown; LIMIT shows fewer, --csv prints all.",
                f"Показаны только первые {MOST} строк; LIMIT даст меньше, --csv — все.",
            )
        return
    context.output.table([spreadsheet_text(name) for name in answer.columns], [])
    for row in rows:
        context.output.table((), [[_cell(_harmless(value)) for value in row]])


def _harmless(value: object) -> object:
    return spreadsheet_text(value) if isinstance(value, str) else value


def _cell(value: object) -> str:
    match value:
        case float() if math.isfinite(value):
            return decimal(f"{value:.12g}")
        case Decimal():
            return decimal(str(value))
        case datetime():
            return value.isoformat(" ")
    return str(_plain(value))


def _plain(value: object) -> object:
    match value:
        case None:
            return ""
        case bool():
            return "true" if value else "false"
        case float() | Decimal():
            return value
        case list() | tuple() | dict():
            return json.dumps(_json(value), ensure_ascii=False)
    return str(_json(value))


def _csv_line(values: Iterable[object]) -> str:
    text = io.StringIO()
    csv.writer(text, lineterminator="").writerow(values)
    return text.getvalue()


def _json(value: object) -> Any:  # noqa: ANN401  (any JSON)
    match value:
        case None | bool() | int() | str():
            return value
        case bytes():
            return value.hex()
        case float():
            return value if math.isfinite(value) else None
        case Decimal():
            return float(value)
        case datetime() | date():
            return value.isoformat()
        case list() | tuple():
            return [_json(item) for item in value]
        case dict():
            return {str(key): _json(item) for key, item in value.items()}
    return str(value)
