"""Live data: a WebSocket for each client, at most 19 messages a second with all that is new.

A message is sent at once if the one before is old enough. The text that all clients share is made
once. Each client has a queue of half a second; a slow one loses whole messages, the oldest first,
and the next message counts them. Sampling never waits for a client. One that takes nothing at all
is dropped by `mikas.dashboard.connections`.
"""

from __future__ import annotations

import asyncio
import json
import logging
import secrets
from collections import deque
from collections.abc import Mapping, Sequence
from contextlib import suppress
from typing import Annotated, Any, Final

from fastapi import APIRouter, Query, WebSocket, WebSocketDisconnect
from pydantic import TypeAdapter

from mikas.cleaning import clean_json
from mikas.dashboard.api.dependencies import address_of, client_of
from mikas.dashboard.api.messages import FieldsMessage, PingMessage
from mikas.dashboard.api.state import OwnState, own_state, shared_state
from mikas.dashboard.dashboard import Dashboard
from mikas.dashboard.error_responses import json_response
from mikas.dashboard.errors import ApiRefusal
from mikas.dashboard.security.control import Client
from mikas.dashboard.session.history import json_columns, page_json
from mikas.dashboard.session.monitor import Batch, ConnectionMonitor

_log = logging.getLogger("mikas.dashboard")

PERIOD = 0.0525  # s between messages at least
SPACING = 0.05  # for each client, so that a backlog shrinks
STATE_EVERY = 0.5  # s, if only numbers in it change
QUEUE = 10
_MAX_MESSAGE = 4096
_MAX_CLIENTS = 32
_KEPT_HERE = 8  # of these, for this computer
_MAX_EACH = 8  # of one address in the network
_MAX_PER_SECOND = 30
_GOING_AWAY, _POLICY_VIOLATION, _INTERNAL_ERROR, _TRY_LATER = 1001, 1008, 1011, 1013

Fields = frozenset[str] | None
_REQUEST: Final = TypeAdapter[PingMessage | FieldsMessage](PingMessage | FieldsMessage)

router: Final = APIRouter(prefix="/api")


def dumps(value: object) -> str:
    """Return compact JSON."""
    return json.dumps(value, separators=(",", ":"), ensure_ascii=False, allow_nan=False)


class Listener:
    """One WebSocket: its columns (None: all), its queue, and the count of messages it lost.

    `page`: the same for the WebSockets that a page opens one after the other; empty: its only one.
    `address`: of a client in the network; None: on this computer.
    """

    def __init__(self, client: Client, page: str = "", address: str | None = None) -> None:
        self.client = client
        self.page: str = page or secrets.token_hex(8)
        self.address = address
        self.replaced = False
        self.fields: Fields = None
        self.waiting: deque[str] = deque()
        self.wake: asyncio.Event = asyncio.Event()
        self.dropped: int = 0
        self.pong: str | None = None
        self.state_sent: int = 0
        self._sequence = 0

    def offer(self, tail: str) -> None:
        """Queue a message; a full queue loses its oldest one."""
        if len(self.waiting) >= QUEUE:
            self.waiting.popleft()
            self.dropped += 1
        self.waiting.append(tail)
        self.wake.set()

    def next(self, now: float, own: str, shared: tuple[int, str]) -> str:
        """Return the next message, with the state if this client has not received it."""
        self._sequence += 1
        text = f'{{"seq":{self._sequence},"now":{now:.3f},"dropped":{self.dropped}'
        self.dropped = 0
        number, state = shared
        if number != self.state_sent:
            self.state_sent = number
            text += f',"state":{{{state},{own}}}'
        if self.pong is not None:
            text += f',"pong":{self.pong}'
            self.pong = None
        return f"{text}{self.waiting.popleft()}}}"


def handle_request(listener: Listener, text: str | None) -> bool:
    """Handle a message of the client; return False for an invalid one."""
    if text is None or len(text) > _MAX_MESSAGE:
        return False
    try:
        request = _REQUEST.validate_json(text, strict=True)
        if isinstance(request, PingMessage):
            listener.pong = dumps(clean_json(request.ping))
        else:
            listener.fields = None if request.fields is None else frozenset(request.fields)
    except ValueError:  # pydantic's, or of a number of no use
        return False
    return True


class Broadcaster:
    """Drains the connection monitor for all listeners, while there are any."""

    def __init__(self, dashboard: Dashboard) -> None:
        self._dashboard = dashboard
        self.listeners: set[Listener] = set()
        self._task: asyncio.Task[None] | None = None
        self._state = (0, "")
        self._stated = 0.0

    def replace(self, listener: Listener) -> None:
        """End the WebSocket that the same page had before, which may be lost without a trace."""
        for it in self.listeners:
            if (it.client.id, it.page) == (listener.client.id, listener.page):
                it.replaced = True
                it.wake.set()

    def has_room(self, address: str | None) -> bool:
        """Return whether one more WebSocket of that address may come in."""
        taken = [it.address for it in self.listeners if not it.replaced]
        others = [it for it in taken if it is not None]
        return len(taken) < _MAX_CLIENTS and (
            address is None
            or (len(others) < _MAX_CLIENTS - _KEPT_HERE and others.count(address) < _MAX_EACH)
        )

    def join(self, listener: Listener) -> None:
        """Add a listener."""
        self._new_state()
        self.listeners.add(listener)
        self._dashboard.control.socket_opened(listener.client, listener.page)
        self._dashboard.monitor.listened = True
        listener.offer("")
        if self._task is None:
            self._task = asyncio.create_task(self._run())

    def leave(self, listener: Listener) -> None:
        """Remove a listener; the task ends with the last one."""
        self.listeners.discard(listener)
        self._dashboard.control.socket_closed(listener.client, listener.page)
        if not self.listeners and self._task is not None:
            self._task.cancel()
            self._task = None
            self._dashboard.monitor.listened = False
            self._dashboard.monitor.drain()

    def message(self, listener: Listener) -> str:
        """Return the next message of `listener`, with its own part of the state."""
        own = own_state(self._dashboard, listener.client)
        return listener.next(own.now, own.model_dump_json()[1:-1], self._state)

    async def _run(self) -> None:
        loop, news, failed = asyncio.get_running_loop(), asyncio.Event(), False
        monitor = self._dashboard.monitor
        while True:
            await asyncio.sleep(PERIOD)
            try:
                news.clear()
                if monitor.wait(lambda: loop.call_soon_threadsafe(news.set)):
                    with suppress(TimeoutError):
                        # Not wait_for: before Python 3.12 it may swallow a cancellation.
                        async with asyncio.timeout(STATE_EVERY):
                            await news.wait()
                self.tick()
                failed = False
            except Exception as bug:  # any: the next messages are sent all the same
                if not failed:  # once, if it repeats
                    _log.error("a bug in the live data", exc_info=bug)
                failed = True

    def tick(self) -> None:
        """Offer each listener a message with the news."""
        dashboard = self._dashboard
        dashboard.refresh()
        later = dashboard.connection.later  # before the rows: when it changes, pages move them
        batch = dashboard.monitor.drain()
        events = [page_json(event.moved(later)) for event in batch.events]
        stated = bool(batch.events) or dashboard.clock() - self._stated >= STATE_EVERY
        if stated:
            self._new_state()
        wanted = {listener.fields for listener in self.listeners}
        tails = {fields: _tail(batch, events, fields, later) for fields in wanted}
        for listener in self.listeners:
            tail = tails[listener.fields]
            if tail or stated or listener.pong is not None:
                listener.offer(tail)

    def _new_state(self) -> None:
        self._stated = self._dashboard.clock()
        shared = shared_state(self._dashboard).model_dump(exclude=set(OwnState.model_fields))
        self._state = (self._state[0] + 1, dumps(shared)[1:-1])


def _tail(batch: Batch, events: Sequence[Mapping[str, Any]], fields: Fields, later: float) -> str:
    text = ""
    if batch.times:
        columns = batch.columns.items()
        shown = {name: each for name, each in columns if fields is None or name in fields}
        text += f',"data":{dumps(json_columns(batch.times, shown, later))}'
    if events:
        text += f',"events":{dumps(events)}'
    return f'{text},"later":{later}' if text else ""


@router.websocket("/live")
async def live(
    socket: WebSocket,
    client: str = "",
    name: str = "",
    page: Annotated[str, Query(max_length=64)] = "",
) -> None:
    """Send live data; docs/reference/api.md describes the messages."""
    broadcaster: Broadcaster = socket.app.state.broadcaster
    try:
        listener = Listener(client_of(socket, client, name), page, address_of(socket))
    except ApiRefusal as error:
        await socket.send_denial_response(json_response(error))
        return
    await socket.accept()
    broadcaster.replace(listener)
    if not broadcaster.has_room(listener.address):
        await socket.close(_TRY_LATER)
        return
    broadcaster.join(listener)
    sending = asyncio.create_task(_send(socket, listener, broadcaster))
    try:
        await _receive(socket, listener, socket.app.state.dashboard.monitor)
    finally:
        broadcaster.leave(listener)
        sending.cancel()
        with suppress(asyncio.CancelledError):
            await sending


async def _send(socket: WebSocket, listener: Listener, broadcaster: Broadcaster) -> None:
    try:
        while True:
            await listener.wake.wait()
            listener.wake.clear()
            if listener.replaced:
                await socket.close(_GOING_AWAY)
                return
            while listener.waiting:
                await socket.send_text(broadcaster.message(listener))
                await asyncio.sleep(SPACING)
    except (WebSocketDisconnect, RuntimeError):
        return  # disconnected; `_receive` ends, too
    except Exception as bug:  # any: else the page would wait for messages for ever
        _log.error("a bug in a message of live data", exc_info=bug)
        await socket.close(_INTERNAL_ERROR)


async def _receive(socket: WebSocket, listener: Listener, monitor: ConnectionMonitor) -> None:
    loop = asyncio.get_running_loop()
    times: deque[float] = deque(maxlen=_MAX_PER_SECOND)
    while True:
        message = await socket.receive()
        if message["type"] == "websocket.disconnect":
            return
        now = loop.time()
        flood = len(times) == _MAX_PER_SECOND and now - times[0] < 1
        times.append(now)
        if flood or not handle_request(listener, message.get("text")):
            await socket.close(_POLICY_VIOLATION)
            return
        monitor.wake()  # the client waits for a response
