"""`mikas mem dump`, `restore`, `verify`, `diff`: the unit's memory and dump files."""

from __future__ import annotations

import errno
from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path

from mikas.cli.click_extensions import YES, argument, command, flag, option, output_option
from mikas.cli.commands.memory.cells import SPACE
from mikas.cli.context import CommandContext
from mikas.cli.failures import DONE, REFUSED
from mikas.cli.language import localized, tr
from mikas.cli.options.common import RELEARN
from mikas.cli.options.parameter_types import block_size, existing_file, hex_address
from mikas.cli.render.output import progress
from mikas.client.memory import dumps
from mikas.client.memory.restoring import DumpFile, Restore
from mikas.commands.base import Space, check_range
from mikas.errors import naming_file, system_error, usage_error
from mikas.files import absolute
from mikas.i18n import byte_count

BLOCK = option(
    "--block",
    type=block_size,
    metavar="N",
    en="bytes per request, at most (255)",
    ru="байт за запрос, не больше (255)",
)


@command(
    en="Reads a whole SPACE, or --from to --to, into FILE (plain binary) and writes its manifest "
    "FILE.json. --resume continues an interrupted dump.",
    ru="Считывает дамп SPACE, целиком или от --from до --to, в FILE (двоичный) и его описание в "
    "FILE.json. Прерванное чтение продолжает --resume.",
    examples=(
        "mikas mem dump code -o code.bin --verify",
        "mikas mem dump xram -o xram.bin --from 1000 --to 1FFF",
        "mikas mem dump code -o code.bin --resume",
    ),
)
@argument("space", "SPACE", type=SPACE)
@output_option(
    "FILE",
    en="the file to write; required",
    ru="файл для записи; обязательно",
)
@option(
    "--from",
    "first",
    type=hex_address,
    default="0",
    en="first address (0)",
    ru="первый адрес (0)",
)
@option(
    "--to",
    "last",
    type=hex_address,
    en="last address, inclusive",
    ru="последний адрес, включительно",
)
@BLOCK
@flag("--verify", en="read everything a second time", ru="прочитать всё второй раз")
@flag(
    "--resume",
    en="continue an interrupted dump",
    ru="продолжить прерванное чтение",
)
@RELEARN
def dump(
    context: CommandContext,
    space: str,
    out: Path,
    first: int,
    last: int | None,
    block: int | None,
    *,
    verify: bool,
    resume: bool,
) -> None:
    if last is not None and last < first:
        raise usage_error(
            f"--to {last:04X} is before --from {first:04X}; --to is the last address, inclusive",
            f"--to {last:04X} меньше, чем --from {first:04X}; --to — последний адрес, включительно",
        )
    end = Space(space).last if last is None else last
    check_range(space, first, end - first + 1)
    if not absolute(out).parent.is_dir():
        absent = dumps.file_error(out, "there is no such folder", "такой папки нет")
        raise absent.caused_by(system_error(errno.ENOENT), out)
    with context.ecu() as ecu:
        memory = ecu.memory[space]
        job = dumps.Dump(ecu, memory, out, first=first, last=end, resume=resume)
        manifest = job.manifest
        try:
            with progress(tr("reading", "чтение"), manifest.size, manifest.bytes_read) as done:
                job.advance(block=block, progress=done)
        except BaseException:
            if manifest.bytes_read:
                context.output.print_note(_stopped(job, out))
            raise
        if verify:
            with progress(tr("second pass", "второй проход"), manifest.size) as done:
                found = job.verify(block=block, progress=done)
            _show_differences(context, found, tr("first pass differs", "проходы расходятся"))
    place = f"{out}: {space} {first:04X}–{end:04X}"
    size = localized(byte_count(manifest.size))
    context.output.result(manifest.as_json(), f"{place}, {size}, sha256 {manifest.sha256}")


def _stopped(job: dumps.Dump, out: Path) -> str:
    done, size = job.manifest.bytes_read, job.manifest.size
    return tr(
        f"Stopped: {done} of {size} bytes are in {out}; --resume continues.",
        f"Прервано: в {out} прочитано байт: {done} из {size}; продолжить: --resume.",
    )


def _show_differences(
    context: CommandContext, found: Sequence[dumps.Difference], what: str
) -> None:
    """Print the first differences on stderr, each after `what`, and their number."""
    for difference in found[:20]:
        context.output.print_note(f"{what}: {_line(difference)}")
    if len(found) > 20:
        context.say(f"… {len(found)} in all", f"… всего {len(found)}")


@command(
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
@argument("space", "SPACE", type=SPACE)
@argument("file", "FILE", type=existing_file)
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
        _write_back(context, job)
    last = dump.first + len(dump.data) - 1
    context.output.result(
        {
            "written": job.written,
            "same": job.same,
            "differences": _differences_json(job.differences),
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
        _show_differences(context, job.differences, what)
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


def _write_back(context: CommandContext, job: Restore) -> None:
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


@command(
    en="Compares FILE with the unit's memory, starting at the address in FILE's manifest (else "
    "--from).",
    ru="Сравнивает дамп FILE с памятью блока, начиная с адреса из его описания (иначе --from).",
    examples=("mikas mem verify code code.bin", "mikas mem verify xram part.bin --from 1000"),
)
@argument("space", "SPACE", type=SPACE)
@argument("file", "FILE", type=existing_file)
@option("--from", "first", type=hex_address, en="first address", ru="первый адрес")
@BLOCK
@RELEARN
def verify(
    context: CommandContext, space: str, file: Path, first: int | None, block: int | None
) -> None:
    data, manifest = _read(file), dumps.read_manifest(file)
    if not data:
        raise usage_error(f"{file}: the file is empty", f"{file}: файл пуст")
    if manifest and manifest.space != space:
        raise usage_error(
            f"{file} is a dump of {manifest.space}, not of {space}",
            f"{file} — дамп {manifest.space}, а не {space}",
        )
    start = first if first is not None else manifest.first if manifest else 0
    with context.ecu() as ecu, progress(tr("comparing", "сравнение"), len(data)) as done:
        found = list(dumps.compare(ecu.memory[space], data, start, block, done))
    _report(context, found, tr("unit", "блок"), file.name)


@command(
    en="Compares two dumps byte by byte at the addresses in their manifests (else from 0). Needs "
    "no port.",
    ru="Сравнивает два дампа побайтно по адресам из их описаний (иначе с 0). Порт не нужен.",
    examples=("mikas mem diff before.bin after.bin", "mikas mem diff a.bin b.bin --json"),
)
@argument("a", "FILE", type=existing_file)
@argument("b", "FILE", type=existing_file)
def diff(context: CommandContext, a: Path, b: Path) -> None:
    starts = [manifest.first if (manifest := dumps.read_manifest(file)) else 0 for file in (a, b)]
    found = list(dumps.differences(_read(a), starts[0], _read(b), starts[1]))
    _report(context, found, a.name, b.name)


def _read(file: Path) -> bytes:
    with naming_file(file):
        return dumps.read_dump(file, follow=True)


def _report(context: CommandContext, found: Sequence[dumps.Difference], a: str, b: str) -> None:
    if context.output.json:
        context.output.data({"differences": _differences_json(found)})
    elif found:
        context.output.line(f"      {a} | {b}")
        for difference in found:
            context.output.line(_line(difference))
    else:
        context.output.line(tr("No differences.", "Различий нет."))


def _differences_json(found: Sequence[dumps.Difference]) -> list[dict[str, object]]:
    """Return `[{"address","a","b"}]`."""
    return [{"address": d.address, "a": _hex(d.a), "b": _hex(d.b)} for d in found]


def _line(difference: dumps.Difference) -> str:
    return f"{difference.address:04X}  {_hex(difference.a) or '–'}  {_hex(difference.b) or '–'}"


def _hex(value: int | None) -> str | None:
    return None if value is None else f"{value:02X}"
