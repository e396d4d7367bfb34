"""`mikas fleet add`: recordings into a dataset, in processes or on a Dask cluster."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

from mikas.cli.click_extensions import argument, command, flag, option
from mikas.cli.completion.values import RECORDING, files, folders, words
from mikas.cli.context import CommandContext
from mikas.cli.failures import DONE, USAGE
from mikas.cli.language import decimal, localized, tr
from mikas.cli.options.parameter_types import whole
from mikas.cli.render.output import progress
from mikas.cli.render.terminal import cell_text
from mikas.json_values import picked

if TYPE_CHECKING:
    from mikas.fleet.adding import Added

MOST_WORKERS = 61  # that a pool may have on Windows


@command(
    en="Adds all recordings (.pcapng) in each FOLDER and below it, or a single file, to DATASET. "
    "What is there already is skipped; a recording that has grown, or another version of the "
    "catalog, replaces what was there. A file that can't be read is reported and passed over. "
    "After Ctrl-C or a power cut the same command continues. FOLDER and DATASET may be URLs "
    "(s3://bucket/path).",
    ru="Добавляет в набор DATASET все записи (.pcapng) из каждой папки FOLDER и из вложенных в "
    "неё, или один файл. Что уже есть, пропускается; выросшая запись и новая версия каталога "
    "заменяют прежнее. Файл, который не читается, называется и пропускается. После Ctrl-C или "
    "отключения питания та же команда продолжит работу. FOLDER и DATASET могут быть адресами "
    "(s3://корзина/путь).",
    examples=(
        "mikas fleet add recordings --to dataset",
        "mikas fleet add /media/usb --to dataset --car A123BC52",
        "mikas fleet add s3://a/in --to s3://a/set --executor dask://10.0.0.1:8786",
    ),
)
@argument("folders", "FOLDER...", nargs=-1, required=True, shell_complete=files(*RECORDING))
@option(
    "--to",
    "dataset",
    required=True,
    metavar="DATASET",
    shell_complete=folders,
    en="folder or URL of the dataset; made if it is not there; required",
    ru="папка или адрес набора; создаётся, если его нет; обязательно",
)
@option(
    "--executor",
    default="processes",
    metavar="processes|dask://HOST[:PORT]",
    shell_complete=words("processes", "dask://"),
    en="who does the work: processes of this computer, or a Dask cluster (processes)",
    ru="кто выполняет работу: процессы этого компьютера или кластер Dask (processes)",
)
@option(
    "--workers",
    type=whole(1, MOST_WORKERS),
    metavar="N",
    en="number of processes; as many as processors, if not given",
    ru="число процессов; если не задано, по числу процессоров",
)
@option(
    "--car",
    default="",
    metavar="TEXT",
    en="the car of all these recordings; otherwise each says itself which car it is of",
    ru="машина всех этих записей; иначе её называет каждая запись",
)
@flag(
    "--check",
    en="read all tables of DATASET first: those that another program has changed are made again "
    "(their size is compared always)",
    ru="сначала прочитать все таблицы набора: изменённые другой программой создаются заново "
    "(размер сверяется всегда)",
)
def add(
    context: CommandContext,
    folders: tuple[str, ...],
    dataset: str,
    executor: str,
    workers: int | None,
    car: str,
    *,
    check: bool,
) -> int:
    from mikas.cleaning import clean_line
    from mikas.fleet.places import require_database

    require_database()
    from mikas.fleet.adding import add as run
    from mikas.fleet.adding import plan
    from mikas.fleet.executors import runner_of
    from mikas.fleet.interpreting import InterpretingSettings

    options = context.options
    settings = InterpretingSettings(
        options.catalog, options.interpretation, clean_line(car, 100).strip()
    )
    runner = runner_of(executor, workers or min(os.cpu_count() or 1, MOST_WORKERS))
    try:
        planned = plan(folders, dataset, settings, check=check)
        count = len(planned.files)
        if not count + planned.skipped:
            context.say("There are no recordings (.pcapng).", "Записей (.pcapng) там нет.")
        with progress(tr("recordings", "записи"), count, speed=False) as advance:
            added = run(planned, dataset, settings, runner, lambda _: advance(1))
    except KeyboardInterrupt:
        context.say(
            "Interrupted: what was finished is in the dataset, the same command continues.",
            "Прервано: всё законченное уже в наборе, та же команда продолжит работу.",
        )
        raise
    finally:
        runner.close()
    _tell(context, added, dataset)
    return USAGE if added.bad else DONE


def _tell(context: CommandContext, added: Added, dataset: str) -> None:
    from mikas.fleet.places import shown

    if context.output.json:
        context.output.data(
            {
                **picked(added, "added", "skipped"),
                "bad": [picked(it, "file", "reason") for it in added.bad],
                "replaced": added.replaced,
                "damaged": [{"file": file, "places": count} for file, count in added.damaged],
                "remade": added.remade,
                "seconds": round(added.seconds, 3),
                "dataset": shown(dataset),
            }
        )
        return
    for file, count in added.damaged:
        context.say(
            f"{file}: damaged places: {count}; the readable rest was added.",
            f"{file}: повреждённых мест: {count}; всё остальное добавлено.",
        )
    for file in added.remade:
        context.say(
            f"{file}: its tables in the dataset were gone or changed; they were made again.",
            f"{file}: её таблиц в наборе не было, или они были изменены; созданы заново.",
        )
    for bad in added.bad:
        context.output.print_note(cell_text(f"{bad.file}: {localized(bad.reason)}"))
    hours = decimal(f"{added.seconds / 3600:.1f}")
    replaced = added.replaced
    known, ru_known = (
        (f" (anew: {replaced})", f" (из них заново: {replaced})") if replaced else ("", "")
    )
    context.say(
        f"{shown(dataset)}: recordings added: {added.added}{known}, {hours} h; there already: "
        f"{added.skipped}; not read: {len(added.bad)}.",
        f"{shown(dataset)}: добавлено записей: {added.added}{ru_known}, {hours} ч; уже были: "
        f"{added.skipped}; не прочитано: {len(added.bad)}.",
    )
