"""The connection to the broker, kept by a thread with an event loop of its own.

    connect ─► retained messages ─► "online" ─► whatever comes ─► "offline", disconnect
       ▲                                             │ lost
       └──────────── 1 s; if refused up to half a minute ◄─────┘

The last will is "offline" too: the broker sends it when the process is killed or the network fails.
"online" comes after the retained messages, so that no subscriber takes an old
state for the present one.

The library is blocking where it resolves names and opens sockets. That is done in daemon threads:
the end of the program waits for none of them.
"""

from __future__ import annotations

import asyncio
import logging
import random
import socket
import threading
from collections.abc import Callable, Coroutine, Iterable
from concurrent.futures import Future, ThreadPoolExecutor, wait
from contextlib import suppress
from dataclasses import KW_ONLY, dataclass
from math import inf
from typing import TYPE_CHECKING, Any, Final, ParamSpec, TypeVar

from mikas.errors import BrokerLost, BrokerNotTrusted, BrokerRefused, NoBroker, library
from mikas.publish.broker import Broker
from mikas.publish.failures import CLOSED, connecting_failed, connection_lost, left
from mikas.publish.outbox import Lost, Message, Outbox

if TYPE_CHECKING:
    from mikas.publish.client import BoundedClient

P = ParamSpec("P")
T = TypeVar("T")

# A network that is gone closes no connection, and the system of a broker that hangs acknowledges
# for it. So a silent broker is asked; where our system can, it gives up unacknowledged bytes.
KEEP_ALIVE: Final = 3  # s; after one and a half of them without a sign of life comes the last will
UNACKNOWLEDGED: Final = 1.5  # s
_ANSWER: Final = 3.0  # s for the broker's answer; a network that is back has another chance soon
_LOOK: Final = 0.25  # s between two looks at whether the broker says something
_ASKED: Final = 4  # looks without a word, after which it is asked
_SILENCE: Final = 10  # looks, after which it is lost; a process that did not run has not looked
_PAUSE: Final = 1.0  # s; so that it is back soon after the network
_REFUSED_PAUSE: Final = 30.0
_SHORT: Final = 10.0  # s; a connection that breaks off sooner was hardly one
_OFTEN: Final = 2
_SLICE: Final = 0.5  # s
_KEPT: Final = 1.0  # s for a message that the broker keeps, if it does
LONGEST_END: Final = 2.0  # s in which the last messages are sent

_logger = logging.getLogger("mikas.publish")
_logger.addHandler(logging.NullHandler())


@dataclass(frozen=True, slots=True)
class BrokerChange:
    """The connection came about (`error` None), or failed. `lost`: what had no room meanwhile."""

    error: NoBroker | None = None
    lost: Lost = Lost()  # noqa: RUF009  (immutable)

    @property
    def is_connected(self) -> bool:
        """Whether the broker has been reached."""
        return self.error is None


@dataclass(eq=False)
class BrokerConnection:
    """Sends what `outbox` has. `online` and `offline`: the messages of begin and end.

    `on_kept` gets what the broker keeps of `kept_topic` before the first message is sent. Both
    functions are called in the connection's thread. Raises `MissingExtra` without aiomqtt.
    """

    broker: Broker
    outbox: Outbox
    _: KW_ONLY
    client_id: str
    online: Message
    offline: Message
    on_change: Callable[[BrokerChange], None] = lambda _: None
    kept_topic: str | None = None
    on_kept: Callable[[bytes], None] = lambda _: None

    def __post_init__(self) -> None:
        check_library()
        self.sent: int = 0
        """The number of messages that the broker surely has got."""
        self._written = 0  # these, and those that the network may have
        self.is_connected: bool = False
        self._first: Future[None] = Future()  # the first attempt
        self._loop: asyncio.AbstractEventLoop | None = None
        self._wakeup = asyncio.Event()
        self._stopping = asyncio.Event()
        self._patient = False
        self._bug: Exception | None = None
        self._short = 0  # connections in a row that the broker closed soon
        self._reported: set[object] = set()  # what was said since the broker was reached
        self._thread = threading.Thread(target=self._run, name="mqtt", daemon=True)

    def open(self, *, patient: bool = False) -> None:
        """Connect. Raises a `NoBroker` if the first attempt fails, unless `patient`.

        After that, and if `patient`, it is tried again without end.
        """
        self._patient = patient
        self._thread.start()
        while not (patient or self._first.done()):
            wait([self._first], timeout=_SLICE)  # without a time-out, Windows ignores Ctrl-C
        if not patient:
            self._first.result()

    def send(self, messages: Iterable[Message]) -> None:
        """Send messages as soon as possible; never waits. Raises what has ended the thread."""
        if self._bug is not None:
            raise self._bug
        self.outbox.put(messages)
        self._call(self._wakeup.set)

    def close(self) -> None:
        """Send the last messages and "offline", then disconnect; two seconds at most."""
        for event in (self._stopping, self._wakeup):
            self._call(event.set)
        if self._thread.ident is not None:
            self._thread.join(LONGEST_END + 1)

    def _call(self, function: Callable[[], object]) -> None:
        loop = self._loop
        if loop is not None:
            with suppress(RuntimeError):  # the loop has ended
                loop.call_soon_threadsafe(function)

    # In the thread

    def _run(self) -> None:
        # The library watches sockets, which Windows' usual loop can't.
        with asyncio.Runner(loop_factory=asyncio.SelectorEventLoop) as runner:
            self._loop = runner.get_loop()
            self._loop.set_default_executor(_DaemonThreads())
            self._loop.set_exception_handler(_log)
            try:
                runner.run(self._keep())
            except Exception as error:  # any: a bug, which the caller has to see
                self._bug = error
                if not self._first.done():
                    self._first.set_exception(error)

    async def _keep(self) -> None:
        """Connect, and connect again after each failure, until `close`."""
        loop, pause = asyncio.get_running_loop(), _PAUSE
        while not self._stopping.is_set():
            began = loop.time()
            error = await self._until_stopped(self._session())
            if error is None:
                continue
            if not (self._first.done() or self._patient):
                self._first.set_exception(error)
                return
            if isinstance(error, BrokerLost):
                is_short = error.fields["problem"] == CLOSED and loop.time() - began < _SHORT
                self._short = self._short + 1 if is_short else 0
                pause = pause if self._short else _PAUSE
            self._report(error)
            _logger.info("%s", error.reason.en)
            with suppress(TimeoutError):
                # Not all cars of a fleet at the same moment.
                await asyncio.wait_for(self._stopping.wait(), pause * random.uniform(0.5, 1))
            refused = isinstance(error, BrokerRefused | BrokerNotTrusted)
            refused |= isinstance(error, BrokerLost) and self._short >= _OFTEN
            pause = min(2 * pause, _REFUSED_PAUSE) if refused else _PAUSE

    def _report(self, error: NoBroker) -> None:
        """Report an error, unless its kind or problem was reported since the broker was reached."""
        about = {type(error), error.fields.get("problem", error.what)}
        if not about & self._reported:
            self.on_change(BrokerChange(error))
        self._reported |= about

    async def _until_stopped(
        self, session: Coroutine[Any, Any, NoBroker | None]
    ) -> NoBroker | None:
        """Return the end of `session`; after `close` it has two seconds, or none to connect."""
        running = asyncio.create_task(session)
        stopping = asyncio.create_task(self._stopping.wait())
        await asyncio.wait({running, stopping}, return_when=asyncio.FIRST_COMPLETED)
        stopping.cancel()
        if not running.done():
            left = LONGEST_END if self.is_connected else 0.0
            await asyncio.wait({running}, timeout=left)
            running.cancel()
        with suppress(asyncio.CancelledError):
            return await running
        return None

    async def _session(self) -> NoBroker | None:
        """Connect and send until the connection breaks off, or until `close`."""
        from aiomqtt import MqttError

        url, client, welcomed = self.broker.url, self._client(), asyncio.Event()
        try:
            await _first(self._work(client, welcomed), self._listen(client, welcomed))
        except (MqttError, OSError, UnicodeError) as error:
            if client.has_left:
                return left(url, reached=welcomed.is_set())
            if not welcomed.is_set():
                return connecting_failed(url, error).caused_by(error)
            cause = client.timed_out or error
            return connection_lost(url, cause, again=self._short >= _OFTEN).caused_by(cause)
        finally:
            client.let_go()
            self.is_connected = False
            self._written = self.sent
            self.outbox.disconnected()
        return None

    async def _work(self, client: BoundedClient, welcomed: asyncio.Event) -> None:
        async with client:
            welcomed.set()
            await self._read_kept(client)
            await _first(self._send(client), _watch(client))

    async def _listen(self, client: BoundedClient, welcomed: asyncio.Event) -> None:
        """Raise the error of a broker that does not answer, or that does not welcome this client.

        An answer shows that the broker has all that was sent before it was asked.
        """
        heard = looks = asked = 0
        while True:
            await asyncio.sleep(_LOOK)
            if not welcomed.is_set():
                if client.ended is not None:
                    raise client.ended
            elif client.heard > heard:
                heard, looks = client.heard, 0
                self.sent = max(self.sent, asked)
            else:
                looks += 1
                if looks == _ASKED:
                    asked = self._written
                    client.ask()
                elif looks == _SILENCE:
                    client.let_go()
                    raise TimeoutError

    def _client(self) -> BoundedClient:
        from aiomqtt import Will

        from mikas.publish.client import BoundedClient

        broker, last = self.broker, self.offline
        return BoundedClient(
            broker.host,
            broker.port,
            username=broker.user,
            password=broker.password,
            tls_context=broker.tls,
            identifier=self.client_id,
            clean_session=True,
            keepalive=KEEP_ALIVE,
            timeout=_ANSWER,
            socket_options=_socket_options(),
            will=Will(last.topic, last.payload, last.qos, last.retain),
            logger=_logger,
        )

    async def _read_kept(self, client: BoundedClient) -> None:
        """Read what the broker keeps of the topic, once; it comes right after the subscription."""
        if self.kept_topic is None:
            return
        topic = self.kept_topic
        await client.subscribe(topic, qos=1)
        with suppress(TimeoutError):
            async with asyncio.timeout(_KEPT):
                async for message in client.messages:
                    if message.topic.value == topic and isinstance(message.payload, bytes):
                        self.on_kept(message.payload)
                        break
        await client.unsubscribe(topic)
        self.kept_topic = None

    async def _send(self, client: BoundedClient) -> None:
        """Send what the outbox has, and "offline" after `close`."""
        loop, until = asyncio.get_running_loop(), inf
        self.outbox.connected()
        while True:
            if self._stopping.is_set():
                until = min(until, loop.time() + LONGEST_END / 2)
            self._wakeup.clear()
            message = self.outbox.next()
            if not self.is_connected and (message is None or not message.retain):
                await self._publish(client, self.online)
                self.is_connected = True
                self._reported.clear()
                if not self._first.done():
                    self._first.set_result(None)
                self.on_change(BrokerChange(lost=self.outbox.take_lost()))
            elif message is not None and loop.time() < until:
                await self._publish(client, message)
                self.outbox.sent(message)
                self._written += 1
                if message.qos:  # the broker has acknowledged it, and so all before it
                    self.sent = self._written
            elif until < inf:
                await self._publish(client, self.offline)
                self.sent = self._written
                return
            else:
                await self._wakeup.wait()

    async def _publish(self, client: BoundedClient, message: Message) -> None:
        await client.publish(message.topic, message.payload, message.qos, message.retain)


def _socket_options() -> list[tuple[int, int, int]]:
    name: int | None = getattr(socket, "TCP_USER_TIMEOUT", None)  # Linux
    return [] if name is None else [(socket.IPPROTO_TCP, name, round(UNACKNOWLEDGED * 1000))]


async def _first(*work: Coroutine[Any, Any, None]) -> None:
    """Do all until one is done, or raise its error."""
    tasks = [asyncio.create_task(each) for each in work]
    try:
        await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
        for task in tasks:
            if task.done():
                task.result()
    finally:
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)


async def _watch(client: BoundedClient) -> None:
    """Wait until the connection breaks off, and raise its error."""
    async for _ in client.messages:
        pass


def _log(_: object, context: dict[str, Any]) -> None:
    """Log what asyncio would print: errors that the library leaves where it has given up."""
    _logger.debug("%s", context["message"], exc_info=context.get("exception"))


def check_library() -> None:
    """Raise `MissingExtra` without the client library."""
    library("aiomqtt", feature="MQTT", extra="mqtt")


class _DaemonThreads(ThreadPoolExecutor):
    """Runs each call in a daemon thread of its own: the exit of the program waits for none."""

    def submit(self, fn: Callable[P, T], /, *args: P.args, **kwargs: P.kwargs) -> Future[T]:
        future: Future[T] = Future()
        future.set_running_or_notify_cancel()  # so that it takes a result though it is given up

        def call(result: Future[T]) -> None:
            try:
                result.set_result(fn(*args, **kwargs))
            except BaseException as error:  # any: it belongs to the caller
                result.set_exception(error)
                del result  # or the error's traceback would keep it, and it the error

        threading.Thread(target=call, args=(future,), daemon=True).start()
        return future
