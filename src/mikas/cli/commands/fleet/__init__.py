"""`mikas fleet`: many recordings as one dataset. No command of it needs a port."""

from __future__ import annotations

from mikas.cli.click_extensions import LocalizedGroup
from mikas.cli.commands import FLEET_COMMANDS

fleet = LocalizedGroup(
    "fleet",
    homes=FLEET_COMMANDS,
    en="Any number of recordings as one dataset of Parquet files, which also pandas, polars, "
    "DuckDB and Spark read: add recordings, ask by SQL, compare the cars in a report.",
    ru="Любое число записей как один набор файлов Parquet, который читают и pandas, polars, "
    "DuckDB, Spark: добавить записи, спросить на SQL, сравнить машины в отчёте.",
    examples=(
        "mikas fleet add recordings --to dataset",
        "mikas fleet sql dataset 'SELECT car, count(*) FROM drives GROUP BY car'",
        "mikas fleet report dataset -o fleet.html",
    ),
)
