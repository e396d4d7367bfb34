"""Changes in two steps: what each does is read and shown, and it is made once it is confirmed.

Of the unit: the client library's gate asks at the last moment (`WriteApproval`), journals, and
reads back. Of kept files: the second step deletes exactly what was shown; a file that is gone, in
use or changed is refused.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from functools import partial

from mikas.client import Ecu
from mikas.client.erasing import engine_runs, erasing
from mikas.client.gate import journal_hex
from mikas.client.memory.spaces import writing
from mikas.commands.base import check_range
from mikas.dashboard.errors import Busy, ConfirmationOutdated, NotFound, api_hex
from mikas.dashboard.library.folder import RecordingFile
from mikas.dashboard.library.service import RecordingService
from mikas.dashboard.security.control import (
    DumpShown,
    FaultShown,
    PendingChange,
    RecordingShown,
    WriteApproval,
)
from mikas.dashboard.session.connection import Connection
from mikas.dashboard.session.history import FaultHistory
from mikas.errors import UsageError
from mikas.files.locks import writer_of
from mikas.i18n import Text

_PROGRAM = Text(
    "This is the unit's program and data: a wrong byte can leave it unable to run the engine.",
    "Это программа и данные блока: с неверным байтом двигатель может больше не завестись.",
)
_WORKING = Text(
    "This is working memory: the engine may stumble or stall; switching the ignition off undoes "
    "the change.",
    "Это рабочая память: двигатель может дёрнуться или заглохнуть; выключение зажигания отменит "
    "изменение.",
)
_STARTED = Text(
    "The engine has been started since this was shown", "Двигатель запустили после показа"
)
_MEANING = Text(
    "The file is deleted permanently. Download it first if you may need it.",
    "Файл удаляется безвозвратно. Если он может понадобиться, сначала скачайте его.",
)
_MARKED = Text(
    f"This recording is a reference that others are compared with. {_MEANING.en}",
    f"Эта запись — образец, с которым сравнивают другие. {_MEANING.ru}",
)


@dataclass(slots=True)
class UnitChanges:
    """Prepares the changes of the unit on the connection."""

    _connection: Connection
    _fault_history: FaultHistory
    approval: WriteApproval = field(default_factory=WriteApproval, init=False)

    async def erase_faults(self) -> PendingChange:
        """Prepare erasing the stored faults; with the engine running it is dangerous.

        If the engine is started before the confirmation, that is outdated.
        """
        stored = await self._connection.ask(self._fault_history.read)
        rpm = await self._connection.ask(lambda ecu: ecu.engine_speed())
        codes = [fault.code for fault in stored.faults]

        def erase(ecu: Ecu) -> list[int]:
            if not rpm and ecu.engine_speed():
                raise ConfirmationOutdated(_STARTED)
            with self.approval.given(journal_hex(bytes(codes))):
                erased = ecu.erase_faults()
            self._fault_history.add(erased.after, ecu.tester.link.now(), erased=True)
            return [fault.code for fault in erased.after]

        return PendingChange(
            what=erasing(len(codes)),
            before=codes,
            after=[],
            lost=tuple(
                FaultShown(fault.text.en, fault.text.ru, fault.code) for fault in stored.faults
            ),
            make=lambda: self._connection.ask(erase),
            danger=bool(rpm),
            meaning=engine_runs(rpm) if rpm else None,
        )

    async def write_memory(self, space: str, address: int, data: bytes) -> PendingChange:
        """Prepare writing bytes. Raises for a range that the space does not have."""
        check_range(space, address, len(data))
        before = await self._connection.ask(
            lambda ecu: ecu.memory[space].read_block(address, len(data))
        )

        def write(ecu: Ecu) -> str | None:
            with self.approval.given(journal_hex(before)):
                return api_hex(ecu.memory[space].write_block(address, data).after)

        danger = space == "code"
        return PendingChange(
            what=writing(len(data), f"{space} {address:04X}"),
            before=api_hex(before),
            after=api_hex(data),
            make=lambda: self._connection.ask(write),
            danger=danger,
            meaning=_PROGRAM if danger else _WORKING,
            needs_unlock=True,
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
        shown, growing = RecordingShown(file.id, file.bytes), library.is_growing(file)
        if not growing and (held := writer_of(file.path)):  # `mikas log`, another dashboard
            raise Busy(problem=held)
        return Found(shown, file.stamp, growing, partial(remove, file))

    def remove(file: RecordingFile) -> None:
        library.folder.delete(file)
        if file.id in library.references.marked():
            with suppress(UsageError):  # a mark of a file that is gone does nothing
                library.references.mark(file.id, on=False)

    marked = identity in await asyncio.to_thread(library.references.marked)
    meaning = _MARKED if marked else _MEANING
    return await deletion(RECORDING, identity, find, blocking=True, meaning=meaning)
