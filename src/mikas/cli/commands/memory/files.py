"""`mikas mem dump`, `verify`, `diff`: the unit's memory and dump files."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import click

from mikas.cli.click_extensions import command, flag, option, output_option
from mikas.cli.commands.memory.cells import SPACE
from mikas.cli.context import CommandContext
from mikas.cli.language import localized, tr
from mikas.cli.options.common import RELEARN
from mikas.cli.options.parameter_types import block_size, existing_file, hex_address
from mikas.cli.render.progress import progress
from mikas.client.memory.dumps import (
    Difference,
    Dump,
    compare,
    differences,
    file_error,
    read_dump,
    read_manifest,
)
from mikas.commands.base import Space, check_range
from mikas.errors import naming_file, usage_error
from mikas.i18n import byte_count

BLOCK = option(
    "--block",
    type=block_size,
    metavar="N",
    en="bytes per request, at most (255)",
    ru="байт за запрос, не больше (255)",
)


@command(
    "dump",
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
@click.argument("space", metavar="SPACE", type=SPACE)
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
    metavar="ADDR",
    en="first address (0)",
    ru="первый адрес (0)",
)
@option(
    "--to",
    "last",
    type=hex_address,
    metavar="ADDR",
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
    if not out.absolute().parent.is_dir():
        raise file_error(out, "there is no such folder", "такой папки нет")
    with context.ecu() as ecu:
        memory = ecu.memory[space]
        job = Dump(ecu, memory, out, first=first, last=end, resume=resume)
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
            show_differences(context, found, tr("first pass differs", "проходы расходятся"))
    place = f"{out}: {space} {first:04X}–{end:04X}"
    size = localized(byte_count(manifest.size))
    context.output.result(manifest.as_json(), f"{place}, {size}, sha256 {manifest.sha256}")


def _stopped(job: Dump, out: Path) -> str:
    done, size = job.manifest.bytes_read, job.manifest.size
    return tr(
        f"Stopped: {done} of {size} bytes are in {out}; --resume continues.",
        f"Прервано: в {out} прочитано байт: {done} из {size}; продолжить: --resume.",
    )


def show_differences(context: CommandContext, found: Sequence[Difference], what: str) -> None:
    """Print the first differences on stderr, each after `what`, and their number."""
    for difference in found[:20]:
        context.output.print_note(f"{what}: {_line(difference)}")
    if len(found) > 20:
        context.say(f"… {len(found)} in all", f"… всего {len(found)}")


@command(
    "verify",
    en="Compares FILE with the unit's memory, starting at the address in FILE's manifest (else "
    "--from).",
    ru="Сравнивает дамп FILE с памятью блока, начиная с адреса из его описания (иначе --from).",
    examples=("mikas mem verify code code.bin", "mikas mem verify xram part.bin --from 1000"),
)
@click.argument("space", metavar="SPACE", type=SPACE)
@click.argument("file", metavar="FILE", type=existing_file)
@option("--from", "first", type=hex_address, metavar="ADDR", en="first address", ru="первый адрес")
@BLOCK
@RELEARN
def verify(
    context: CommandContext, space: str, file: Path, first: int | None, block: int | None
) -> None:
    data, manifest = _read(file), read_manifest(file)
    if not data:
        raise usage_error(f"{file}: the file is empty", f"{file}: файл пуст")
    if manifest and manifest.space != space:
        raise usage_error(
            f"{file} is a dump of {manifest.space}, not of {space}",
            f"{file} — дамп {manifest.space}, а не {space}",
        )
    start = first if first is not None else manifest.first if manifest else 0
    with context.ecu() as ecu, progress(tr("comparing", "сравнение"), len(data)) as done:
        found = list(compare(ecu.memory[space], data, start, block, done))
    _report(context, found, tr("unit", "блок"), file.name)


@command(
    "diff",
    en="Compares two dumps byte by byte at the addresses in their manifests (else from 0). Needs "
    "no port.",
    ru="Сравнивает два дампа побайтно по адресам из их описаний (иначе с 0). Порт не нужен.",
    examples=("mikas mem diff before.bin after.bin", "mikas mem diff a.bin b.bin --json"),
)
@click.argument("a", metavar="FILE", type=existing_file)
@click.argument("b", metavar="FILE", type=existing_file)
def diff(context: CommandContext, a: Path, b: Path) -> None:
    starts = [manifest.first if (manifest := read_manifest(file)) else 0 for file in (a, b)]
    found = list(differences(_read(a), starts[0], _read(b), starts[1]))
    _report(context, found, a.name, b.name)


def _read(file: Path) -> bytes:
    with naming_file(file):
        return read_dump(file, follow=True)


def _report(context: CommandContext, found: Sequence[Difference], a: str, b: str) -> None:
    if context.output.json:
        context.output.data({"differences": differences_json(found)})
    elif found:
        context.output.line(f"      {a} | {b}")
        for difference in found:
            context.output.line(_line(difference))
    else:
        context.output.line(tr("No differences.", "Различий нет."))


def differences_json(found: Sequence[Difference]) -> list[dict[str, object]]:
    """Return `[{"address","a","b"}]`."""
    return [{"address": d.address, "a": _hex(d.a), "b": _hex(d.b)} for d in found]


def _line(difference: Difference) -> str:
    return f"{difference.address:04X}  {_hex(difference.a) or '–'}  {_hex(difference.b) or '–'}"


def _hex(value: int | None) -> str | None:
    return None if value is None else f"{value:02X}"
