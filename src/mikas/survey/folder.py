"""The folder of a survey under way, `FILE.zip.part`: what was measured so far, and the captures.

It is saved after each step, and now and then within a long one, all or nothing. So a program that
is killed, or a computer without power, costs some seconds of work: the same command goes on.
"""

from __future__ import annotations

import errno
import os
import shutil
from pathlib import Path
from typing import Any, Final

from mikas.errors import UsageError, naming_file, system_error, usage_error
from mikas.files import ABSENT, beside, read_json
from mikas.saving import save_json
from mikas.survey.steps.step import Measured

_STATE: Final = "state.json"
_WHOLE: Final = "whole.zip"
_MOST_BYTES: Final = 1 << 24
SCHEMA: Final = 1


class SurveyFolder:
    """The folder beside the ZIP `out`."""

    def __init__(self, out: Path) -> None:
        self.out = out
        self.path: Path = beside(out, ".part")

    def load(self) -> Measured | None:
        """Return what was measured so far; None: no survey is under way.

        Raises `UsageError` for a folder that can't be used.
        """
        file = self.path / _STATE
        try:
            with naming_file(file):
                state: Any = read_json(file, _MOST_BYTES)
        except UsageError as error:
            if isinstance(error, ABSENT):
                return None
            raise
        except ValueError as error:
            raise self.damaged() from error
        if not isinstance(state, dict) or state.get("schema") != SCHEMA:
            raise self.damaged()
        measured = state.get("measured")
        if not isinstance(measured, dict):
            raise self.damaged()
        return measured

    def damaged(self) -> UsageError:
        """Return the error for a folder with other content than a survey's."""
        return usage_error(
            f"{self.path}: this is no survey under way, or a damaged one. Remove the folder, or "
            "name another file",
            f"{self.path}: это не начатое обследование, или оно повреждено. Удалите папку или "
            "назовите другой файл",
        )

    def save(self, measured: Measured) -> None:
        """Keep what was measured so far. Raises `UsageError` if it can't be written."""
        save_json(self.path / _STATE, {"schema": SCHEMA, "measured": measured})

    def finish(self, data: bytes, *, overwrite: bool = False) -> None:
        """Write the ZIP whole, and remove the folder: the ZIP has all of it.

        Raises `UsageError`; the folder then stays.
        """
        check_free(self.out, overwrite=overwrite)
        whole = self.path / _WHOLE
        with naming_file(self.out):
            with whole.open("wb") as file:
                file.write(data)
                file.flush()
                os.fsync(file.fileno())
            whole.replace(self.out)
        shutil.rmtree(self.path, ignore_errors=True)

    def forget(self) -> None:
        """Remove what was measured so far. Raises `UsageError` if it can't be removed."""
        with naming_file(self.path):
            if self.path.exists():
                shutil.rmtree(self.path)


def check_free(out: Path, *, overwrite: bool) -> None:
    """Raise `UsageError` for a ZIP that exists, or in no folder."""
    if os.path.lexists(out) and not overwrite:
        there = usage_error(
            f"{out}: it exists already; choose another name, or --overwrite",
            f"{out}: такой файл уже есть; выберите другое имя или добавьте --overwrite",
        )
        raise there.caused_by(system_error(errno.EEXIST), out)
