"""What the routes about recordings share: the folder, what was summed up, what is kept open.

One desk an application, made when it is first asked for. Heavy work (an export, a report) is done
in a thread, one piece at a time; a queue that grows too long is refused.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import Annotated, Final, TypeVar

from fastapi import Depends, Request

from mikas.dashboard.api.dependencies import TheHub
from mikas.dashboard.dashboard import Hub
from mikas.dashboard.errors import Busy
from mikas.dashboard.library.cache import Opened
from mikas.dashboard.library.deletion import is_in_progress
from mikas.dashboard.library.folder import Remembered, Shelf, Shelved
from mikas.i18n import Text
from mikas.recording.summary import summarise

T = TypeVar("T")

_LONGEST_QUEUE: Final = 8
_MANY: Final = Text(
    "several exports and reports are being made already", "уже готовятся другие таблицы и отчёты"
)


class Desk:
    """Belongs to one hub."""

    def __init__(self, hub: Hub) -> None:
        self.hub = hub
        self.catalog, self.interpretation = hub.catalog, hub.settings.connection.interpretation
        self.shelf = Shelf(hub.settings.recordings)
        self.opened = Opened(self.catalog, self.interpretation, hub.clock)
        self.summaries = Remembered(lambda path: summarise(path, self.catalog))
        self._busy = asyncio.Lock()
        self._waiting = 0

    def is_growing(self, it: Shelved) -> bool:
        """Whether it is being made just now."""
        return is_in_progress(self.hub, it)

    async def alone(self, work: Callable[[], T]) -> T:
        """What `work` returns, done in a thread, when those before it are done. Raises `Busy`."""
        if self._waiting >= _LONGEST_QUEUE:
            raise Busy(problem=_MANY)
        self._waiting += 1
        try:
            async with self._busy:
                doing = asyncio.ensure_future(asyncio.to_thread(work))
                try:
                    return await asyncio.shield(doing)
                finally:  # nobody may wait for it any more, but it takes its share until it ends
                    await asyncio.wait({doing})
        finally:
            self._waiting -= 1


def _desk(request: Request, hub: TheHub) -> Desk:
    state = request.app.state
    if not hasattr(state, "recordings_desk"):
        state.recordings_desk = Desk(hub)
    desk: Desk = state.recordings_desk
    return desk


TheDesk = Annotated[Desk, Depends(_desk)]
