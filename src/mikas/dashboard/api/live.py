"""Live data: a WebSocket a client, one message for all that came since the last, 19 a second at
most: one goes out as soon as something comes, if the last is long enough ago.

The text of what all clients share is made once. Each has a queue of half a second; one that is too
slow loses whole messages, the oldest first, and is told how many. Nothing here reaches back to the
sampling: it never waits for anybody who looks.
"""

from __future__ import annotations

import asyncio
import logging
from collections import deque
from collections.abc import Mapping, Sequence
from contextlib import suppress
from typing import Any

from fastapi import APIRouter, WebSocket, WebSocketDisconnect

from mikas.dashboard.api.broadcaster import Fields, Listener, dumps, handle_request
from mikas.dashboard.api.dependencies import client_of
from mikas.dashboard.api.state import OWN, holder_of, state_of
from mikas.dashboard.dashboard import Dashboard
from mikas.dashboard.error_responses import json_response
from mikas.dashboard.errors import ApiRefusal
from mikas.dashboard.session.event_log import page_json
from mikas.dashboard.session.monitor import Row

_log = logging.getLogger("mikas.dashboard")

PERIOD = 0.0525  # s between messages at least
SPACING = 0.05  # for each client, so that a backlog shrinks
STATE_EVERY = 0.5  # s, if only numbers in it move
_MOST_CLIENTS = 32
_MOST_A_SECOND = 30
_PATIENCE = 30.0  # s that one message may take
_POLICY_VIOLATION, _TRY_LATER = 1008, 1013


router = APIRouter()


class Broadcaster:
    """Drains the connection monitor for all listeners, as long as there is one."""

    def __init__(self, dashboard: Dashboard) -> None:
        self._dashboard = dashboard
        self._listeners: set[Listener] = set()
        self._task: asyncio.Task[None] | None = None
        self._state = (0, "")
        self._stated = 0.0

    @property
    def full(self) -> bool:
        """Whether there is no place for another."""
        return len(self._listeners) >= _MOST_CLIENTS

    def join(self, listener: Listener) -> None:
        """From now on it gets what comes."""
        self._new_state()
        self._listeners.add(listener)
        self._dashboard.control.socket_opened(listener.client)
        self._dashboard.monitor.listened = True
        listener.offer("")
        if self._task is None:
            self._task = asyncio.create_task(self._run())

    def leave(self, listener: Listener) -> None:
        """No more; with the last one the work ends."""
        self._listeners.discard(listener)
        self._dashboard.control.socket_closed(listener.client)
        if not self._listeners and self._task is not None:
            self._task.cancel()
            self._task = None
            self._dashboard.monitor.listened = False
            self._dashboard.monitor.drain()

    def message(self, listener: Listener) -> str:
        """What waits for `listener`, with what is its own of the state."""
        client = listener.client
        holder = holder_of(self._dashboard, client)
        own = dumps(
            {
                "controller": holder.model_dump() if holder else None,
                "rights": "control" if client.may_control else "view",
                "viewers": self._dashboard.control.viewers,
                "now": self._dashboard.connection.now(),
            }
        )
        return listener.next(self._dashboard.connection.now(), own[1:-1], self._state)

    def poke(self) -> None:
        """Somebody waits for an answer."""
        self._dashboard.monitor.wake()

    async def _run(self) -> None:
        loop, something = asyncio.get_running_loop(), asyncio.Event()
        monitor, good = self._dashboard.monitor, True
        while True:
            await asyncio.sleep(PERIOD)
            something.clear()
            if monitor.wait(lambda: loop.call_soon_threadsafe(something.set)):
                with suppress(TimeoutError):
                    # Not wait_for: before Python 3.12 it may swallow a cancellation.
                    async with asyncio.timeout(STATE_EVERY):
                        await something.wait()
            before = good
            try:
                self._tick()
                good = True
            except Exception as bug:  # whatever it is: what comes next is told to all
                good = False
                if before:  # not each time, if it is there to stay
                    _log.error("a bug in the live data", exc_info=bug)

    def _tick(self) -> None:
        dashboard = self._dashboard
        dashboard.refresh()
        batch = dashboard.monitor.drain()
        events = [page_json(event) for event in batch.events]
        stated = False
        if batch.events or dashboard.clock() - self._stated >= STATE_EVERY:
            stated = self._new_state()
        tails: dict[Fields, str] = {}
        for listener in self._listeners:
            tail = tails.get(listener.fields)
            if tail is None:
                tail = _tail(batch.names, batch.rows, events, listener.fields)
                tails[listener.fields] = tail
            if tail or stated or listener.pong is not None:
                listener.offer(tail)

    def _new_state(self) -> bool:
        self._stated = self._dashboard.clock()
        shared = state_of(self._dashboard).model_dump(exclude=set(OWN))
        self._state = (self._state[0] + 1, dumps(shared)[1:-1])
        return True


def _tail(
    names: Sequence[str], rows: Sequence[Row], events: Sequence[Mapping[str, Any]], fields: Fields
) -> str:
    text = ""
    if rows:
        shown = [name for name in names if fields is None or name in fields]
        data = {
            "names": shown,
            "times": [round(time, 6) for time, _ in rows],
            "values": [[_plain(values.get(name)) for _, values in rows] for name in shown],
        }
        text += f',"data":{dumps(data)}'
    if events:
        text += f',"events":{dumps(events)}'
    return text


def _plain(value: float | None) -> float | int | None:
    return int(value) if value is not None and value.is_integer() else value


@router.websocket("/live")
async def live(socket: WebSocket, client: str = "", name: str = "") -> None:
    """Live data; docs/api.md has the messages."""
    broadcaster: Broadcaster = socket.app.state.broadcaster
    try:
        may_control = socket.scope["state"]["rights"] == "control"
        listener = Listener(client_of(client, name, may_control=may_control))
    except ApiRefusal as error:
        await socket.send_denial_response(json_response(error))
        return
    await socket.accept()
    if broadcaster.full:
        await socket.close(_TRY_LATER)
        return
    broadcaster.join(listener)
    sending = asyncio.create_task(_send(socket, listener, broadcaster))
    try:
        await _receive(socket, listener, broadcaster)
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
            while listener.waiting:
                text = broadcaster.message(listener)
                async with asyncio.timeout(_PATIENCE):
                    await socket.send_text(text)
                await asyncio.sleep(SPACING)
    except TimeoutError:
        await socket.close(_TRY_LATER)
    except (WebSocketDisconnect, RuntimeError):
        return  # it is gone; whoever receives finds out too


async def _receive(socket: WebSocket, listener: Listener, broadcaster: Broadcaster) -> None:
    loop = asyncio.get_running_loop()
    came: deque[float] = deque(maxlen=_MOST_A_SECOND)
    while True:
        message = await socket.receive()
        if message["type"] == "websocket.disconnect":
            return
        now = loop.time()
        flood = len(came) == _MOST_A_SECOND and now - came[0] < 1
        came.append(now)
        if flood or not handle_request(listener, message.get("text")):
            await socket.close(_POLICY_VIOLATION)
            return
        broadcaster.poke()
