"""The groups of commands: `mikas list`, `mem`, `fleet`, each with the list of its commands."""

from __future__ import annotations

from typing import Final

from mikas.cli.click_extensions import LocalizedGroup
from mikas.cli.commands import home

list: Final = LocalizedGroup(  # noqa: A001  (the command's name)
    "list",
    en="The list in the unit: `set` chooses its parameters, `read` reads all of them by one short "
    "request. The unit may forget it when its supply goes off.",
    ru="Список в самом блоке: `set` задаёт его параметры, `read` читает их все одним коротким "
    "запросом. При отключении питания блок может его забыть.",
    examples=("mikas list set FREQ TWAT INJ", "mikas list read"),
    homes={
        "set": home(
            "unit.parameter_list", "set the parameters of the list", "задать параметры списка"
        ),
        "read": home("unit.parameter_list", "read the list", "прочитать список"),
    },
)

mem: Final = LocalizedGroup(
    "mem",
    en="The unit's memory: RAM, XRAM, CODE and SFR. Not every unit allows reading; these commands "
    "have not been tried on all units.",
    ru="Память блока: RAM, XRAM, CODE и SFR. Читать её разрешает не каждый блок; на всех блоках "
    "эти команды не проверялись.",
    examples=("mikas mem read ram 40 16", "mikas mem dump code -o code.bin --verify"),
    homes={
        "read": home("memory.cells", "hex dump of some bytes", "показать байты"),
        "write": home(
            "memory.cells", "write bytes and read them back", "записать байты и проверить чтением"
        ),
        "dump": home("memory.files", "save a memory space to a file", "считать дамп в файл"),
        "restore": home(
            "memory.files",
            "write a dump back: only what differs",
            "записать дамп обратно: только отличия",
        ),
        "verify": home(
            "memory.files", "compare a file with the unit", "сравнить дамп с памятью блока"
        ),
        "diff": home(
            "memory.files",
            "compare two dumps (needs no port)",
            "сравнить два дампа (порт не нужен)",
        ),
        "goto": home("memory.cells", "jump to an address: dangerous", "переход по адресу: опасно"),
    },
)

fleet: Final = LocalizedGroup(
    "fleet",
    en="Any number of recordings as one dataset of Parquet files, which also pandas, polars, "
    "DuckDB and Spark read: add recordings, ask by SQL, compare the cars in a report.",
    ru="Любое число записей как один набор файлов Parquet, который читают и pandas, polars, "
    "DuckDB, Spark: добавить записи, спросить на SQL, сравнить машины в отчёте.",
    examples=(
        "mikas fleet add recordings --to dataset",
        "mikas fleet sql dataset 'SELECT car, count(*) FROM drives GROUP BY car'",
        "mikas fleet report dataset -o fleet.html",
    ),
    homes={
        "add": home("fleet.add", "add recordings to a dataset", "добавить записи в набор"),
        "sql": home("fleet.sql", "ask a dataset by SQL", "запрос к набору на SQL"),
        "report": home(
            "fleet.report", "a report on all cars of a dataset", "отчёт по всем машинам набора"
        ),
    },
)
