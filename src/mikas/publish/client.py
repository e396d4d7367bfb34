"""The client library, with a bound on what a broker may send.

aiomqtt and paho take packets of up to 256 MiB into memory, keep messages without number, and after
a packet that they can't interpret ask the same socket again and again: the thread would take the
sampling thread's time. This client is sent little: acknowledgements, and one retained message of
the one topic that it subscribes to for a moment. A broker that sends more, or anything but MQTT, is
left at once, as one whose connection broke off.

This module imports the library, so it is imported when a connection is made.
"""

from __future__ import annotations

import re
import time
from collections.abc import Callable
from contextlib import suppress
from typing import Any, Final, cast

import aiomqtt
from paho.mqtt import client as paho
from paho.mqtt.enums import MQTTErrorCode

CONNECTING: Final = 2.5  # s of one attempt: what was sent into a network that is gone comes never
LARGEST: Final = 1 << 20  # bytes of a packet; Home Assistant's discovery of 29 channels has 17 kB
BURST: Final = 4 << 20  # bytes at once
RATE: Final = 8 << 10  # bytes a second for ever: answers to pings
ANSWER: Final = 1 << 10  # bytes for each published message: its acknowledgement
PIECE: Final = 64  # bytes, as which a piece counts at least: a small packet costs time, too
WAITING: Final = 16  # messages that were not read yet
_WELCOME: Final = 0x20  # the first byte of CONNACK
_LOST: Final = (MQTTErrorCode.MQTT_ERR_CONN_LOST, MQTTErrorCode.MQTT_ERR_PROTOCOL)
_WORDS: Final = re.compile(rb"[ -$'-\[\]-~]{4,40}")
"""How another program's answer begins. Some repeat what they got, with the password far inside; its
first byte, 0x10, ends the words in any spelling."""


class BrokerTooLoud(ConnectionError):
    """The broker sends more than a broker has to say to this client."""


class NoWelcome(ConnectionError):
    """The other end closes the connection, or says `words`, where a broker welcomes a client."""

    def __init__(self, words: str = "") -> None:
        super().__init__("no broker's welcome")
        self.words = words


class BoundedClient(aiomqtt.Client):
    """aiomqtt's client over a bounded one of paho; its options, without those of the queue."""

    def __init__(self, *args: Any, **options: Any) -> None:
        super().__init__(*args, max_queued_incoming_messages=WAITING, **options)
        self._client.__class__ = _BoundedPaho  # aiomqtt makes its own one
        self._paho = cast("_BoundedPaho", self._client)
        self._paho.connect_timeout = CONNECTING
        self._allowance = self._paho.allowance = Allowance()

    @property
    def has_left(self) -> bool:
        """Whether the broker was left because of what it sent."""
        return self._allowance.exceeded

    @property
    def heard(self) -> int:
        """How often the broker has said something."""
        return self._paho.heard

    @property
    def ended(self) -> NoWelcome | None:
        """The end of the connection, if the other end has ended it before its welcome."""
        return self._paho.ended

    def ask(self) -> None:
        """Ask the broker for a sign of life."""
        self._paho.ask()

    @property
    def timed_out(self) -> TimeoutError | None:
        """The system's error of a connection over which nothing came any more."""
        return self._paho.timed_out

    async def publish(self, *args: Any, **options: Any) -> None:
        """As aiomqtt's."""
        self._allowance.more(ANSWER)
        await super().publish(*args, **options)

    def let_go(self) -> None:
        """Close the socket, which the library leaves open after some errors.

        A thread may still be connecting: what it opens later does not reach the event loop, which
        may have ended.
        """
        self._paho.on_socket_open = None
        self._paho.close_socket()
        self._paho.on_socket_close = None


class Allowance:
    """The bytes that a broker may still send."""

    def __init__(self, now: Callable[[], float] = time.monotonic) -> None:
        self.exceeded: bool = False
        self._now = now
        self._left = float(BURST)
        self._time = now()

    def ask(self, size: int) -> None:
        """Raise `BrokerTooLoud` if a packet's next piece of `size` bytes is too large."""
        if size > LARGEST:
            self.exceed()

    def more(self, size: int) -> None:
        """Allow `size` bytes more, for an answer; they do not add up for ever."""
        self._left = min(self._left + size, 2 * BURST)

    def took(self, size: int) -> None:
        """Count a piece of `size` bytes; raise `BrokerTooLoud` if these are too many."""
        now = self._now()
        if self._left < BURST:
            self._left = min(self._left + (now - self._time) * RATE, BURST)
        self._left -= max(size, PIECE)
        self._time = now
        if self._left < 0:
            self.exceed()

    def exceed(self) -> None:
        """Raise `BrokerTooLoud`."""
        self.exceeded = True
        raise BrokerTooLoud("the broker sends more than it has to say")


class _BoundedPaho(paho.Client):
    allowance: Allowance
    timed_out: TimeoutError | None = None  # which the library takes for a closed connection
    ended: NoWelcome | None = None
    heard = 0

    # Nothing public of the library does these two.
    def ask(self) -> None:
        self._send_pingreq()

    def close_socket(self) -> None:
        self._sock_close()

    def _sock_recv(self, bufsize: int) -> bytes:
        """As paho's, which asks for all of a packet as soon as it knows its size."""
        self.allowance.ask(bufsize)
        if self._in_messages:  # QoS 2, which was not subscribed to, and is kept until released
            self.allowance.exceed()
        try:
            data = super()._sock_recv(bufsize)
        except TimeoutError as error:  # what was sent was not acknowledged
            self.timed_out = error
            raise
        self.allowance.took(len(data))
        if data and not self.heard and data[0] != _WELCOME:
            raise self._other_program(data)
        self.heard += bool(data)
        return data

    def _other_program(self, begin: bytes) -> NoWelcome:
        """Return the end of a connection to another kind of server, by what it sent first."""
        with suppress(OSError):
            begin += super()._sock_recv(2 * PIECE)
        words = _WORDS.match(begin)
        self.ended = NoWelcome(words[0].decode().strip() if words else "")
        return self.ended

    def loop_read(self, max_packets: int = 1) -> MQTTErrorCode:
        """As paho's. What it can't interpret it would find again at each call."""
        try:
            result = super().loop_read(max_packets)
        except Exception:
            self.allowance.exceeded = True
            self._sock_close()
            raise
        if result in _LOST and self.ended is None:
            self.ended = NoWelcome()
        return result
