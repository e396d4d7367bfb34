"""The page as a file: whole, or not there at all."""

from __future__ import annotations

import os
from contextlib import suppress
from pathlib import Path
from typing import Final

from mikas.errors import ExportError, reason_of
from mikas.i18n import Text

SUFFIXES: Final = (".html", ".htm")


def check(out: Path, *, overwrite: bool) -> None:
    """What would be a pity to find out only after measuring. Raises `ExportError`."""
    if out.suffix.lower() not in SUFFIXES:
        raise ExportError(
            str(out),
            Text(
                "a report is an .html file (a browser prints it to paper or PDF)",
                "отчёт — это файл .html (напечатать его или сохранить в PDF можно из браузера)",
            ),
        )
    if not overwrite and os.path.lexists(out):
        raise ExportError(
            str(out),
            Text(
                "the file is there already; give another name, or allow overwriting",
                "файл уже есть; укажите другое имя или разрешите перезапись",
            ),
        )
    if not out.absolute().parent.is_dir():
        raise ExportError(str(out), Text("there is no such folder", "такой папки нет"))


def write(out: Path, page: str, *, overwrite: bool) -> None:
    """Writes `page` beside its place and renames it. Raises `ExportError`."""
    check(out, overwrite=overwrite)
    part = out.with_name(f"{out.name}.part")
    try:
        try:
            with part.open("w", encoding="utf-8", newline="\n") as file:
                file.write(page)
                file.flush()
                os.fsync(file.fileno())
            part.replace(out)
        finally:
            with suppress(OSError):
                part.unlink(missing_ok=True)
    except OSError as error:
        problem = Text("can't be written: {why}", "не записать: {why}")
        raise ExportError(str(out), problem.filled(why=reason_of(error))) from error
