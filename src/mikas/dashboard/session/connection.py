"""A job's turn on the line, awaited by the event loop, which goes on meanwhile."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import TYPE_CHECKING, TypeVar

from mikas.dashboard.errors import Busy
from mikas.i18n import Text

if TYPE_CHECKING:
    from mikas.client import Ecu
    from mikas.dashboard.session.thread import Session

T = TypeVar("T")

_TAKES_LONG = Text("the line is taken; the request was taken back", "линия занята; запрос отозван")


async def turn(session: Session, job: Callable[[Ecu], T], seconds: float) -> T:
    """What `job(ecu)` returns, done between two cycles of `session`. Raises what it raises, and
    `Busy` if its turn did not come within `seconds`; then it does not come any more. A job that has
    begun is waited for: it may have changed something, and its end has to be told.
    """
    future = session.call(job)
    wrapped = asyncio.wrap_future(future)
    try:
        done, _ = await asyncio.wait({wrapped}, timeout=seconds)
        if not done:
            if future.cancel():
                raise Busy(problem=_TAKES_LONG)
            await asyncio.wait({wrapped})
    finally:
        if not wrapped.done():
            future.cancel()
    return wrapped.result()
