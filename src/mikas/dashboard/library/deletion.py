"""Deletion of a kept file in two steps, as every change that can't be undone.

The second step deletes exactly what was shown: a file that is gone, in use or changed is refused.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from functools import partial

from mikas.dashboard.errors import Busy, ConfirmationOutdated, NotFound
from mikas.dashboard.library.folder import RecordingFile
from mikas.dashboard.library.service import RecordingService
from mikas.dashboard.security.confirmations import DumpShown, PendingChange, RecordingShown
from mikas.errors import UsageError
from mikas.i18n import Text

_MEANING = Text(
    "The file is deleted permanently. Download it first if you may need it.",
    "Файл удаляется безвозвратно. Если он может понадобиться, сначала скачайте его.",
)
_MARKED = Text(
    f"This recording is a reference that others are compared with. {_MEANING.en}",
    f"Эта запись — образец, с которым сравнивают другие. {_MEANING.ru}",
)


@dataclass(frozen=True, slots=True)
class DeletionTexts:
    """The sentences for one kind of file. `what` has a place for the `{name}`."""

    what: Text
    in_use: Text
    gone: Text
    changed: Text


RECORDING = DeletionTexts(
    what=Text("delete the recording {name}", "удалить запись {name}"),
    in_use=Text(
        "this recording is in progress; stop it first", "эта запись ещё идёт; сначала остановите её"
    ),
    gone=Text("This recording no longer exists", "Этой записи больше нет"),
    changed=Text(
        "This recording has changed since it was shown", "Эта запись изменилась после показа"
    ),
)
DUMP = DeletionTexts(
    what=Text("delete the dump {name}", "удалить дамп {name}"),
    in_use=Text(
        "this dump is being read; pause it first", "этот дамп читается; сначала остановите чтение"
    ),
    gone=Text("This dump no longer exists", "Этого дампа больше нет"),
    changed=Text("This dump has changed since it was shown", "Этот дамп изменился после показа"),
)


@dataclass(frozen=True, slots=True)
class Found:
    """A file as it was found. `stamp` changes when the file does."""

    shown: RecordingShown | DumpShown
    stamp: object
    in_use: bool
    remove: Callable[[], None]


async def deletion(
    texts: DeletionTexts,
    name: str,
    find: Callable[[], Found],
    *,
    blocking: bool,
    meaning: Text = _MEANING,
) -> PendingChange:
    """Return the deletion, to be confirmed. Raises `NotFound`, `Busy` for a file in use.

    `find` raises `NotFound`. It and `remove` run in a thread if `blocking`; else in the event loop,
    which alone changes dumps.
    """

    def checked() -> Found:
        found = find()
        if found.in_use:
            raise Busy(problem=texts.in_use)
        return found

    def delete() -> None:
        try:
            now = checked()
        except NotFound:
            raise ConfirmationOutdated(texts.gone) from None
        if now.stamp != found.stamp:
            raise ConfirmationOutdated(texts.changed)
        now.remove()

    async def make() -> None:
        await asyncio.to_thread(delete) if blocking else delete()

    found = await asyncio.to_thread(checked) if blocking else checked()
    return PendingChange(
        what=texts.what.filled(name=name),
        before=found.shown,
        after=None,
        lost=(found.shown,),
        meaning=meaning,
        make=make,
    )


async def recording_deletion(library: RecordingService, identity: str) -> PendingChange:
    """Return the deletion of a recording."""

    def find() -> Found:
        file = library.folder.one(identity)
        shown = RecordingShown(file.id, file.bytes)
        return Found(shown, file.stamp, library.is_growing(file), partial(remove, file))

    def remove(file: RecordingFile) -> None:
        library.folder.delete(file)
        if file.id in library.references.marked():
            with suppress(UsageError):  # a mark of a file that is gone does nothing
                library.references.mark(file.id, on=False)

    marked = identity in await asyncio.to_thread(library.references.marked)
    meaning = _MARKED if marked else _MEANING
    return await deletion(RECORDING, identity, find, blocking=True, meaning=meaning)
