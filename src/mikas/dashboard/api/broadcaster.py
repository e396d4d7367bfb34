"""One that listens to live data: what it wants, what waits for it, what it has lost."""

from __future__ import annotations

import asyncio
import json
from collections import deque

from mikas.dashboard.security.control import Client

QUEUE = 10
_LONGEST_MESSAGE = 4096
_MOST_FIELDS = 200

Fields = frozenset[str] | None


def dumps(value: object) -> str:
    """JSON, as short as it goes."""
    return json.dumps(value, separators=(",", ":"), ensure_ascii=False, allow_nan=False)


class Listener:
    """One WebSocket: what it wants, what waits for it, what it has lost."""

    def __init__(self, client: Client) -> None:
        self.client = client
        self.fields: Fields = None
        self.waiting: deque[str] = deque()
        self.wake = asyncio.Event()
        self.dropped = 0
        self.pong: str | None = None
        self.state_seen = 0
        self._sequence = 0

    def offer(self, tail: str) -> None:
        """One message more; the oldest goes if there is no room."""
        if len(self.waiting) >= QUEUE:
            self.waiting.popleft()
            self.dropped += 1
        self.waiting.append(tail)
        self.wake.set()

    def next(self, now: float, own: str, shared: tuple[int, str]) -> str:
        """The next message, with the state if this client has not seen it."""
        self._sequence += 1
        text = f'{{"seq":{self._sequence},"now":{now:.3f},"dropped":{self.dropped}'
        self.dropped = 0
        number, state = shared
        if number != self.state_seen:
            self.state_seen = number
            text += f',"state":{{{state},{own}}}'
        if self.pong is not None:
            text += f',"pong":{self.pong}'
            self.pong = None
        return f"{text}{self.waiting.popleft()}}}"


def handle_request(listener: Listener, text: str | None) -> bool:
    """Does what `text` asks for; False if it makes no sense."""
    if text is None or len(text) > _LONGEST_MESSAGE:
        return False
    try:
        body = json.loads(text)
    except (ValueError, RecursionError):
        return False
    match body:
        case {"ping": int() | float() | str() as ping, **rest} if not rest:
            try:
                listener.pong = dumps(ping)
            except ValueError:
                return False
        case {"fields": None, **rest} if not rest:
            listener.fields = None
        case {"fields": list() as fields, **rest} if not rest:
            if len(fields) > _MOST_FIELDS or not all(isinstance(it, str) for it in fields):
                return False
            listener.fields = frozenset(fields)
        case _:
            return False
    return True
