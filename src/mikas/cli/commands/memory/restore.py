"""`mikas mem restore`: a dump written back to the unit."""

from __future__ import annotations

from contextlib import ExitStack
from pathlib import Path

import click

from mikas.cli.click_extensions import YES, command, flag, option
from mikas.cli.commands.memory.cells import SPACE
from mikas.cli.commands.memory.files import BLOCK, differences_json, show_differences
from mikas.cli.context import CommandContext
from mikas.cli.failures import DONE, REFUSED
from mikas.cli.language import tr
from mikas.cli.options.common import RELEARN
from mikas.cli.options.parameter_types import existing_file, hex_address
from mikas.cli.render.progress import progress
from mikas.client.memory.restoring import DumpFile, Restore


@command(
    "restore",
    en="Writes the dump FILE back to SPACE. Compares first, shows how many bytes differ and "
    "where, and asks; then writes only those, reads each back and adds it to the journal. "
    "Without a terminal and --yes it only compares. FILE must fit its manifest FILE.json and "
    "the unit. Restoring CODE can make the unit unusable.",
    ru="Записывает дамп FILE обратно в SPACE. Сначала сравнивает, показывает, сколько байтов "
    "отличается и где, и спрашивает подтверждение; затем пишет только их, проверяет каждый "
    "чтением, ведёт журнал. Без терминала и --yes только сравнивает. FILE должен подходить к "
    "описанию FILE.json и к блоку. После записи в CODE блок может перестать работать.",
    examples=(
        "mikas mem restore xram xram.bin",
        "mikas mem restore xram xram.bin --resume --yes",
        "mikas mem restore ram part.bin --ignore-manifest --from 40",
    ),
)
@click.argument("space", metavar="SPACE", type=SPACE)
@click.argument("file", metavar="FILE", type=existing_file)
@flag(
    "--resume",
    en="go on after an interruption",
    ru="продолжить прерванную запись",
)
@flag(
    "--ignore-manifest",
    en="restore FILE to any unit, whatever its manifest says; requires --from",
    ru="записать FILE в любой блок, что бы ни говорило описание; нужен --from",
)
@option(
    "--from",
    "first",
    type=hex_address,
    metavar="ADDR",
    en="first address, with --ignore-manifest",
    ru="первый адрес, вместе с --ignore-manifest",
)
@BLOCK
@YES
@RELEARN
def restore(
    context: CommandContext,
    space: str,
    file: Path,
    first: int | None,
    block: int | None,
    *,
    resume: bool,
    ignore_manifest: bool,
    yes: bool,
) -> int:
    dump = DumpFile.read(file, space, first=first, ignore_manifest=ignore_manifest)
    with context.ecu(context.confirm(yes=yes)) as ecu:
        job = Restore(ecu, ecu.memory[space], dump, resume=resume)
        _remark(context, dump)
        with progress(tr("comparing", "сравнение"), len(dump.data)) as done:
            job.compare(block=block, progress=done)
        _write(context, job)
    last = dump.first + len(dump.data) - 1
    context.output.result(
        {
            "written": job.written,
            "same": job.same,
            "differences": differences_json(job.differences),
        },
        tr(
            f"{space} {dump.first:04X}–{last:04X}: bytes written and read back: {job.written}; "
            f"the same before: {job.same}",
            f"{space} {dump.first:04X}–{last:04X}: записано и проверено байтов: {job.written}; "
            f"совпадало: {job.same}",
        ),
    )
    if not job.differences:
        return DONE
    if not context.output.json:
        what = tr("not taken (unit | file)", "не записалось (блок | файл)")
        show_differences(context, job.differences, what)
    return REFUSED


def _remark(context: CommandContext, dump: DumpFile) -> None:
    """Say the odd facts of the dump; the question shows the rest."""
    if dump.changed:
        context.say(
            f"{dump.path} has been changed since it was read (its checksum is not the manifest's).",
            f"{dump.path} изменён после считывания (контрольная сумма не та, что в описании).",
        )
    if dump.manifest and dump.manifest.verified is False:
        context.say(
            f"The two passes of {dump.path} differed: parts of it may be wrong.",
            f"Два прохода {dump.path} расходились: часть его может быть неверной.",
        )


def _write(context: CommandContext, job: Restore) -> None:
    with ExitStack() as bar:
        done = None  # the bar begins after the question
        try:
            for count in job.write():
                if done is None:
                    what = tr("writing", "запись")
                    done = bar.enter_context(progress(what, job.different))
                done(count)
        except BaseException:
            bar.close()
            if job.is_interrupted:
                context.say(
                    f"Stopped: {job.written} of {job.different} different bytes were written and "
                    "read back. --resume compares again and goes on; the journal has the bytes "
                    "before.",
                    f"Прервано: записано и проверено байтов {job.written} из {job.different}. "
                    "--resume сравнит заново и продолжит; прежние байты есть в журнале.",
                )
            raise
