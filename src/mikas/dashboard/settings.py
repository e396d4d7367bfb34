"""What the server is started with: how the unit is asked, and where things are kept."""

from __future__ import annotations

import errno
import os
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from mikas.client import gate
from mikas.client.connecting import ConnectionOptions
from mikas.errors import UsageError, reason_of
from mikas.i18n import Language, Text
from mikas.link import Link, Port, find_ports, open_link

_ELSEWHERE = Text(
    "Start it again with --record and a folder that can be written to.",
    "Запустите заново с ключом --record и папкой, в которую можно писать.",
)


def _state_folder() -> Path:
    return gate.default_journal().parent


def default_recordings() -> Path:
    """Where a person looks for files of their own."""
    from platformdirs import user_documents_path

    return user_documents_path() / "mikas"


def ensure_folder(folder: Path) -> Path:
    """`folder`, there to be written to. Raises `UsageError`."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        why = reason_of(error)
        raise UsageError(
            problem=Text(
                f"The folder {folder} can't be made: {why.en}",
                f"Папку {folder} не создать: {why.ru}",
            ),
            advice=_ELSEWHERE,
        ) from error
    return folder


def check_folder(folder: Path) -> None:
    """Raises `UsageError` if nothing can be kept in `folder`; makes nothing."""
    there = folder
    while not os.path.lexists(there) and there != there.parent:
        there = there.parent
    if there.is_dir() and os.access(there, os.W_OK | os.X_OK):
        return
    code = errno.EACCES if there.is_dir() else errno.ENOTDIR
    why = reason_of(OSError(code, os.strerror(code)))
    raise UsageError(
        problem=Text(
            f"Nothing can be kept in the folder {folder} ({there}: {why.en})",
            f"В папке {folder} ничего не сохранить ({there}: {why.ru})",
        ),
        advice=_ELSEWHERE,
    )


@dataclass(frozen=True, slots=True)
class Settings:
    """`recordings`: the folder of recordings, with `dumps` in it. `state`: presets, learnt limits,
    the journal. `find`, `open_port`, `link_clock`: the system's ports, and the clock of the links;
    tests bring their own.
    """

    recordings: Path
    state: Path = field(default_factory=_state_folder)
    connection: ConnectionOptions = field(default_factory=ConnectionOptions)
    find: Callable[[], list[Port]] = find_ports
    open_port: Callable[[str], Link] = open_link
    link_clock: Callable[[], float] | None = None
    language: Language | None = None
    """What the page speaks until somebody chooses there; None: as the browser does."""

    @property
    def journal(self) -> Path:
        """The file of changes."""
        return self.state / "journal.jsonl"

    @property
    def units(self) -> Path:
        """What was learnt of each unit."""
        return self.state / "units"

    @property
    def presets(self) -> Path:
        """The user's own presets."""
        return self.state / "presets.json"

    @property
    def dumps(self) -> Path:
        """Where dumps are kept."""
        return self.recordings / "dumps"
