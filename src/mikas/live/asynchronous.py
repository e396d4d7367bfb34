"""`async_session`: a session for asyncio programs, driven by one worker thread.

async with mikas.async_session("sim:", channels=["FREQ"]) as session:
    async for sample in session:
        print(sample.values)
"""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from functools import wraps
from typing import TYPE_CHECKING, Final, ParamSpec, Self, TypeVar

from mikas.client import Ecu
from mikas.client.parameters.polling import Method
from mikas.errors import CaptureError, LinkClosed
from mikas.live.session import Session
from mikas.live.starting import session
from mikas.sampling.events import Event, Sampled

if TYPE_CHECKING:
    import pandas as pd

    from mikas.client.identity import UnitIdentity
    from mikas.live.progress import RunProgress
    from mikas.recording.recorder import RecordingStatus

P = ParamSpec("P")
E = TypeVar("E", bound=Event)
T = TypeVar("T")


class AsyncSession(AsyncIterator[Sampled]):
    """`session` is the `Session`; its listeners are called in the worker thread.

    A task that is cancelled while it waits loses no sample: the next one that waits gets it.
    """

    def __init__(self, sync: Session) -> None:
        self.session = sync
        """The `Session` that the worker thread iterates."""
        self._worker = ThreadPoolExecutor(1, thread_name_prefix="mikas-session")
        self._next: asyncio.Future[Event | None] | None = None
        self._turn = asyncio.Lock()  # of the task that waits for the next event
        self._closing: asyncio.Future[None] | None = None

    @property
    def unit(self) -> UnitIdentity | None:
        """As `Session.unit`."""
        return self.session.unit

    @property
    def method(self) -> str | None:
        """As `Session.method`."""
        return self.session.method

    @property
    def progress(self) -> RunProgress:
        """As `Session.progress`."""
        return self.session.progress

    @property
    def recording(self) -> RecordingStatus | None:
        """As `Session.recording`."""
        return self.session.recording

    async def __anext__(self) -> Sampled:
        """Return the next sample. Raises as `Session` does."""
        while True:
            event = await self._following()
            if event is None:
                raise StopAsyncIteration
            if isinstance(event, Sampled):
                return event

    async def events(self) -> AsyncIterator[Event]:
        """Iterate over all events, as `Session.events`."""
        while (event := await self._following()) is not None:
            yield event

    async def run(self, duration: float | None = None) -> int:
        """As `Session.run`: sample for the listeners and the recording."""
        return await self._worked(lambda: self.session.run(duration))

    async def to_pandas(self, duration: float | None = None) -> pd.DataFrame:
        """As `Session.to_pandas`."""
        return await self._worked(lambda: self.session.to_pandas(duration))

    def on(self, kind: type[E], listener: Callable[[E], object]) -> Callable[[], None]:
        """As `Session.on`; the listener is called in the worker thread.

        For an `asyncio.Queue`: `partial(loop.call_soon_threadsafe, queue.put_nowait)`.
        """
        return self.session.on(kind, listener)

    def mark(self, label: str = "") -> float | None:
        """As `Session.mark`."""
        return self.session.mark(label)

    def reconfigure(
        self, channels: Iterable[str], method: Method = "auto", rate: float | None = None
    ) -> None:
        """As `Session.reconfigure`."""
        self.session.reconfigure(channels, method, rate)

    def stop(self) -> None:
        """As `Session.stop`."""
        self.session.stop()

    async def call(self, job: Callable[[Ecu], T]) -> T:
        """Run `job(ecu)` between two cycles and return its result, while another task iterates.

        If the task that waits is cancelled, the job ends between two requests.
        """
        future, cancellation = self.session._cancellable(job)  # noqa: SLF001  (its twin)
        try:
            return await asyncio.wrap_future(future)
        except asyncio.CancelledError:
            cancellation.request()
            raise

    async def close(self) -> None:
        """As `Session.close`; a second call does nothing.

        If the task that waits is cancelled, the port is closed all the same.
        """
        if self._closing is not None:
            await asyncio.wait([self._closing])
            return
        self.session.stop()
        self._closing = self._begun(self.session.close)
        self._worker.shutdown(wait=False)
        await asyncio.shield(self._closing)

    async def _worked(self, work: Callable[[], T]) -> T:
        """Run `work` in the worker thread; a task that is cancelled stops the session."""
        try:
            return await self._begun(work)
        except asyncio.CancelledError:
            self.session.stop()
            raise

    async def _following(self) -> Event | None:
        async with self._turn:
            following = self._next = self._next or self._begun(self.session.following)
            try:
                event = await asyncio.shield(following)
            except Exception:  # of the line or of a listener; the next one that waits gets no copy
                self._next = None
                raise
            self._next = None  # not if it was cancelled: then it is for the next one that waits
            return event

    def _begun(self, work: Callable[[], T]) -> asyncio.Future[T]:
        if self._closing is not None:
            raise LinkClosed(url=self.session.acquisition.port.url)
        return asyncio.get_running_loop().run_in_executor(self._worker, work)

    async def __aenter__(self) -> Self:
        return self

    async def __aexit__(self, kind: object, *_: object) -> None:
        try:
            await self.close()
        except CaptureError:
            if kind is None:  # else what has ended the work matters more
                raise


def _asynchronous(function: Callable[P, Session]) -> Callable[P, AsyncSession]:
    @wraps(function)
    def call(*args: P.args, **kwargs: P.kwargs) -> AsyncSession:
        return AsyncSession(function(*args, **kwargs))

    return call


async_session: Final = _asynchronous(session)
"""As `session`, for `async with` and `async for`."""
