"""Deletion of a kept file in two steps, as every change that can't be undone.

The second step deletes exactly what was shown: a file that is gone, in use or changed is refused.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

from mikas.dashboard.errors import Busy, ConfirmationOutdated, NotFound
from mikas.dashboard.library.folder import RecordingFile
from mikas.dashboard.library.service import RecordingService
from mikas.dashboard.security.confirmations import PendingChange
from mikas.i18n import Text

T = TypeVar("T")

_MEANING = Text(
    "The file is deleted permanently. Download it first if you may need it.",
    "Файл удаляется безвозвратно. Если он может понадобиться, сначала скачайте его.",
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
class Deletion(Generic[T]):
    """How one file is deleted. `find` raises `NotFound`; `stamp` changes when the file does.

    `shown`: the file as JSON. `find` and `remove` run in a thread if `blocking`; else in the event
    loop, which alone changes dumps.
    """

    texts: DeletionTexts
    name: str
    find: Callable[[], T]
    in_use: Callable[[T], bool]
    stamp: Callable[[T], object]
    shown: Callable[[T], dict[str, Any]]
    remove: Callable[[T], None]
    blocking: bool

    async def prepare(self) -> PendingChange:
        """Return the deletion, to be confirmed. Raises `NotFound`, `Busy` for a file in use."""
        found = await self._run(self._checked)
        shown, stamp = self.shown(found), self.stamp(found)

        def delete() -> None:
            try:
                now = self._checked()
            except NotFound:
                raise ConfirmationOutdated(self.texts.gone) from None
            if self.stamp(now) != stamp:
                raise ConfirmationOutdated(self.texts.changed)
            self.remove(now)

        async def make() -> dict[str, Any]:
            await self._run(delete)
            return {"before": shown, "after": None}

        return PendingChange(
            what=self.texts.what.filled(name=self.name),
            before=shown,
            after=None,
            lost=(shown,),
            meaning=_MEANING,
            make=make,
        )

    def _checked(self) -> T:
        found = self.find()
        if self.in_use(found):
            raise Busy(problem=self.texts.in_use)
        return found

    async def _run(self, work: Callable[[], T] | Callable[[], None]) -> Any:  # noqa: ANN401  (either)
        return await asyncio.to_thread(work) if self.blocking else work()


def recording_deletion(library: RecordingService, identity: str) -> Deletion[RecordingFile]:
    """Return the deletion of a recording."""
    return Deletion(
        RECORDING,
        identity,
        find=lambda: library.folder.one(identity),
        in_use=library.is_growing,
        stamp=lambda file: file.stamp,
        shown=lambda file: {"id": file.id, "bytes": file.bytes},
        remove=library.folder.delete,
        blocking=True,
    )
