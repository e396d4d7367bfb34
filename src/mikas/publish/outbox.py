"""MQTT messages, and those that the broker has not got yet: bounded, however long the outage.

`MessageKind` says what becomes of each. What had no room is counted (`Lost`). Any thread may call.
"""

from __future__ import annotations

import json
import threading
from collections import deque
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from enum import Enum
from functools import reduce
from itertools import chain
from typing import Any, Final

from mikas.cleaning import terminal_json

SCHEMA: Final = 1
MOST_EVENTS: Final = 1000
MOST_BYTES: Final = 16 << 20


class MessageKind(Enum):
    """What becomes of a message that the broker can't get at once."""

    RETAINED = "the latest of its topic is sent with each new connection; the broker keeps it"
    LIVE = "dropped: later it would pass for a present value; while waiting, the latest counts"
    EVENT = "the latest thousand are kept, and sent in order"
    SAMPLES = "the latest 16 MiB are kept, and sent in order behind all others"


@dataclass(frozen=True, slots=True)
class Message:
    """A `payload` for `topic`. `time`: its date.

    `rows`: samples in it, of which `since` is the first one's time and `time` the last one's.
    """

    topic: str
    payload: bytes
    kind: MessageKind
    qos: int = 1
    time: float | None = None
    rows: int = 0
    since: float | None = None

    @property
    def retain(self) -> bool:
        """Whether the broker gives it to later subscribers."""
        return self.kind is MessageKind.RETAINED


def json_payload(value: Mapping[str, Any]) -> bytes:
    """Return one JSON object with its schema. Raises `ValueError` for a number that is none."""
    return compact({"schema": SCHEMA, **value})


def compact(value: object) -> bytes:
    """Return `value` as JSON without blanks, with escapes for all that would steer a terminal."""
    text = json.dumps(value, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    return terminal_json(text).encode()


def rounded(time: float | None) -> float | None:
    """Return a time of the link's clock as in all JSON of mikas: to a microsecond."""
    return None if time is None else round(time, 6)


@dataclass(frozen=True, slots=True)
class Lost:
    """A number of samples and events, and their first and last time."""

    samples: int = 0
    events: int = 0
    since: float | None = None
    until: float | None = None

    def __bool__(self) -> bool:
        """Whether anything is lost."""
        return bool(self.samples or self.events)

    def plus(self, message: Message) -> Lost:
        """Return the sum with one more message."""
        begins = message.time if message.since is None else message.since
        return Lost(
            self.samples + message.rows,
            self.events + (message.kind is MessageKind.EVENT),
            _chosen(min, self.since, begins),
            _chosen(max, self.until, message.time),
        )


def _chosen(choose: Callable[..., float], *times: float | None) -> float | None:
    """Return one of the times that are known; None without any."""
    return choose((time for time in times if time is not None), default=None)


class Outbox:
    """Takes messages; gives them one by one to the connection, which confirms each."""

    def __init__(self, *, most_events: int = MOST_EVENTS, most_bytes: int = MOST_BYTES) -> None:
        self._lock = threading.Lock()
        self._most_bytes = most_bytes
        self._connected = False
        self._retained: dict[str, Message] = {}  # all, by topic
        self._pending: dict[str, Message] = {}  # of these, what this connection has not sent
        self._live: dict[str, Message] = {}
        self._events: deque[Message] = deque()
        self._samples: deque[Message] = deque()
        self._most_events = most_events
        self._bytes = 0  # of the samples
        self._lost = Lost()

    def put(self, messages: Iterable[Message]) -> None:
        """Take messages, in order."""
        with self._lock:
            for message in messages:
                self._put(message)

    def _put(self, message: Message) -> None:
        match message.kind:
            case MessageKind.RETAINED:
                self._retained[message.topic] = self._pending[message.topic] = message
            case MessageKind.LIVE if self._connected:
                self._live[message.topic] = message
            case MessageKind.EVENT:
                self._events.append(message)
                if len(self._events) > self._most_events:
                    self._lost = self._lost.plus(self._events.popleft())
            case MessageKind.SAMPLES:
                self._samples.append(message)
                self._bytes += len(message.payload)
                while self._bytes > self._most_bytes:
                    self._lost = self._lost.plus(self._take_samples())

    def _take_samples(self) -> Message:
        message = self._samples.popleft()
        self._bytes -= len(message.payload)
        return message

    def connected(self) -> None:
        """Begin a connection: all retained messages are due."""
        with self._lock:
            self._connected = True
            self._pending = dict(self._retained)

    def take_lost(self) -> Lost:
        """Return, and forget, what had no room: it is reported now."""
        with self._lock:
            lost, self._lost = self._lost, Lost()
            return lost

    def disconnected(self) -> None:
        """End a connection: values can't be sent in time now."""
        with self._lock:
            self._connected = False
            self._live.clear()

    def next(self) -> Message | None:
        """Return the next message, which stays here until `sent`; None: nothing is due."""
        with self._lock:
            due = self._pending.values(), self._live.values(), self._events, self._samples
            return next(chain(*due), None)

    def sent(self, message: Message) -> None:
        """Remove a message of `next`, unless a later one has taken its place meanwhile."""
        with self._lock:
            for messages in (self._pending, self._live):
                if messages.get(message.topic) is message:
                    del messages[message.topic]
            if self._events and self._events[0] is message:
                self._events.popleft()
            if self._samples and self._samples[0] is message:
                self._take_samples()

    @property
    def unsent(self) -> Lost:
        """The samples and events that are still here, and those that had no room meanwhile."""
        with self._lock:
            return reduce(Lost.plus, (*self._samples, *self._events), self._lost)
