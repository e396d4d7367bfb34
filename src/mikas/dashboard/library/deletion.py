"""Deleting a recording: a change in two steps, as every other that can't be undone."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, Any

from mikas.dashboard.errors import Busy, ConfirmationOutdated, NotFound
from mikas.dashboard.library.folder import Shelf, Shelved
from mikas.dashboard.security.confirmations import FOR_GOOD, Prepared
from mikas.errors import CaptureError, reason_of
from mikas.i18n import Text

if TYPE_CHECKING:
    from mikas.dashboard.dashboard import Hub

_IN_PROGRESS = Text(
    "this recording is being made; stop it first",
    "эта запись ещё идёт; сначала остановите её",
)
_GONE = Text("This recording is no longer there", "Этой записи уже нет")
_CHANGED = Text(
    "This recording is no longer as it was shown", "Эта запись уже не та, что была показана"
)


async def prepared_delete(hub: Hub, identity: str) -> Prepared:
    """What would be deleted. Raises `NotFound`, `Busy` for the recording in progress."""
    shelf = Shelf(hub.settings.recordings)
    it = await asyncio.to_thread(shelf.one, identity)
    _check_not_in_progress(hub, it)

    async def make() -> dict[str, Any]:
        await asyncio.to_thread(_delete, hub, shelf, it)
        return {"before": before, "after": None}

    before = {"id": it.id, "bytes": it.bytes}
    return Prepared(
        what=Text(f"delete the recording {it.id}", f"удалить запись {it.id}"),
        before=before,
        after=None,
        lost=({"id": it.id, "bytes": it.bytes},),
        meaning=FOR_GOOD,
        make=make,
    )


def is_in_progress(hub: Hub, it: Shelved) -> bool:
    """Whether it is being made just now."""
    status = hub.recording.recorder.status
    return status is not None and status.path.name == it.id and status.failure is None


def _check_not_in_progress(hub: Hub, it: Shelved) -> None:
    if is_in_progress(hub, it):
        raise Busy(problem=_IN_PROGRESS)


def _delete(hub: Hub, shelf: Shelf, shown: Shelved) -> None:
    try:
        found = shelf.one(shown.id)
    except NotFound:
        raise ConfirmationOutdated(_GONE) from None
    _check_not_in_progress(hub, found)
    if found.stamp != shown.stamp:
        raise ConfirmationOutdated(_CHANGED)
    try:
        found.path.unlink()
    except OSError as error:
        raise CaptureError(str(found.path), reason_of(error)) from error
