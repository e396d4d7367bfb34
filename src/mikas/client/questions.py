"""Questions of the gate to a `confirm` that is a coroutine function: the event loop answers them.

The worker thread of an `AsyncEcu` waits for the answer; its event loop goes on.
"""

from __future__ import annotations

import asyncio
import inspect
from collections.abc import Awaitable, Callable
from concurrent.futures import Future, wait
from contextlib import suppress

from mikas.cancellation import check_cancelled
from mikas.client.gate import Change, Confirm
from mikas.errors import LinkClosed, NotConfirmed
from mikas.i18n import Text

_LOOK = 0.05  # s between two looks for a cancelled or late call, while a person reads the question
_CLOSED = Text(
    "The connection was closed before the answer.", "Связь закрыта раньше, чем пришёл ответ."
)
_CANCELLED = Text("The question was cancelled.", "Вопрос отменён.")


class Questions:
    """The questions of one `AsyncEcu`, answered in `loop`.

    `check`: raises if the call that asks is to end; to be set once the unit is known.
    """

    def __init__(self, loop: asyncio.AbstractEventLoop) -> None:
        self._loop = loop
        self._open: set[Future[object]] = set()
        self._ended = False
        self.check: Callable[[], None] = check_cancelled

    def asking(self, confirm: Confirm) -> Callable[[Change], bool]:
        """Return `confirm` for the worker thread, which waits for a coroutine's answer."""

        def ask(change: Change) -> bool:
            answer: object = confirm(change)
            if inspect.isawaitable(answer):
                answer = self._answer(change, answer)
            return answer  # type: ignore[return-value]  # the gate refuses anything but a bool

        return ask

    def end(self) -> None:
        """Answer the open questions with no; called in the loop."""
        self._ended = True
        for question in list(self._open):
            question.cancel()

    def _answer(self, change: Change, answer: Awaitable[object]) -> object:
        question: Future[object] = asyncio.run_coroutine_threadsafe(_awaited(answer), self._loop)
        self._open.add(question)
        try:
            if self._ended:  # perhaps before it was among the open ones
                question.cancel()
            while not wait([question], _LOOK).done:
                with suppress(LinkClosed):  # then `end` has answered it
                    self.check()
            if question.cancelled():
                how = _CLOSED if self._ended else _CANCELLED
                raise NotConfirmed(change=change.what, how=how)
            return question.result()
        finally:
            question.cancel()
            self._open.discard(question)


async def _awaited(answer: Awaitable[object]) -> object:
    return await answer
