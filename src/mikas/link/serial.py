"""The link over a serial port: an adapter on USB, or one behind a network (§1).

9600 8N1 unless the URL says otherwise, no flow control. Four rules:

- **Every wait ends.** Writing has a time-out, reading a deadline; `flush` is never called, because
  it does not return on a dead USB adapter or an unread pty.
- **Deadlines are exact.** Where the system can wait on the port, it waits for the time left.
  pyserial's `timeout` is set once before opening: each change of it reconfigures the port.
- **No wake-up for a byte that can't be the last.** At 960 bytes a second these would be most of a
  recording's CPU load; see `gather`.
- **A lost adapter is closed at once**, so that its old name is free when it is plugged in again.

This module imports pyserial, so it is imported when a serial link is opened.
"""

from __future__ import annotations

import os
import select
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from typing import TypeAlias

import serial

from mikas.errors import LineError, LinkLost, NoConnection, PortKind, met_on
from mikas.i18n import Text
from mikas.link.base import (
    AT_ONCE,
    BAUD,
    BITS_PER_BYTE,
    CLOSED_HERE,
    LATENCY_TIMER,
    LONGEST_REQUEST,
    NETWORK,
    PATIENCE,
    TAKES_NO_BYTES,
    Chunk,
    Link,
    link_lost,
)
from mikas.link.chips import has_latency_timer
from mikas.link.clocks import WallClock
from mikas.link.failures import (
    SYSTEM_ERRORS,
    also_of_system,
    is_unable,
    opening_failed,
    why_lost,
)
from mikas.link.network.other_end import at_the_end, in_handshake, with_words
from mikas.link.network.rfc2217 import LineSettings, Rfc2217Port
from mikas.link.network.tcp import RawTcpPort
from mikas.link.ports import find_ports, named
from mikas.link.urls import host_and_port, kind_of, parse
from mikas.options import OptionParser, check_names

TICK = 0.01  # s of one wait on a port without select
GLANCE = 0.001  # s between two polls of such a port when less than two ticks are left
LONGEST_WAIT = 1.0  # s; then a check whether another thread has closed the link
MOST_AT_ONCE = 4096  # bytes

# pyserial raises these in the middle of a call when another thread closes the port.
_CLOSED_MEANWHILE: tuple[type[Exception], ...] = (TypeError, AttributeError)
_ERRORS = SYSTEM_ERRORS + _CLOSED_MEANWHILE
_NOT_SET: tuple[type[Exception], ...] = (*_ERRORS, ValueError)


OpenPort: TypeAlias = serial.Serial | RawTcpPort


class SerialLink(Link):
    """A link over the open `port`, which it owns.

    The system can wait on the `fileno` of a port with `timeout` 0. Any other port has `timeout`
    `TICK` and is polled: deadlines are kept to about 1 ms. `granularity`: as `Link.granularity`;
    through a network `gather` would only lose time, so it does not sleep.
    """

    def __init__(
        self,
        url: str,
        port: OpenPort,
        *,
        baud: int = BAUD,
        about: str = "",
        can_break: bool = True,
        granularity: float = LATENCY_TIMER,
    ) -> None:
        self.url = url
        self.kind: PortKind = kind_of(url)
        self.baud = baud
        self._about = about
        self._chip: str | None = "" if about else None  # None: not looked up
        self._can_break = can_break  # turns false once the system has refused
        self.granularity = granularity
        self.port = port
        self._receive = _receive(port)
        self._clock = WallClock()
        self._gone: Text | None = None
        self._closing = threading.Lock()  # held by the thread that closes the port, for good

    @property
    def description(self) -> str:
        """`FT232R USB UART (FTDI), low latency`, or the port's name if nothing else is known."""
        self._look_up()
        is_lowered = self.granularity <= AT_ONCE and has_latency_timer(self.chip)
        return f"{self._about}, low latency" if is_lowered else self._about

    @property
    def chip(self) -> str:
        self._look_up()
        return self._chip or ""

    def _look_up(self) -> None:
        """Look the adapter up on first use: listing the ports takes time."""
        if self._chip is None:
            path = parse(self.url).address
            port = named(path, find_ports())
            self._about = path if port is None else port.description
            self._chip = "" if port is None else port.chip

    def now(self) -> float:
        return self._clock.now()

    def write(self, data: bytes) -> None:
        self._must_be_open(data)
        try:
            accepted = self.port.write(data)
        except _ERRORS as error:
            raise self._failed(error, data) from error
        if accepted is not None and accepted != len(data):
            raise self._lose(TAKES_NO_BYTES, data)

    def read(self, deadline: float) -> Chunk:
        while True:
            self._must_be_open()
            left = deadline - self._clock.now()
            try:
                data = self._receive(min(max(left, 0.0), LONGEST_WAIT))
            except _ERRORS as error:
                raise self._failed(error) from error
            now = self._clock.now()
            if data or now >= deadline:
                return Chunk(data, now)

    def gather(self, until: float) -> None:
        if self.granularity < NETWORK and self._gone is None:
            time.sleep(min(max(until - self._clock.now(), 0.0), LONGEST_WAIT))

    def send_break(self, seconds: float) -> None:
        """As `Link.send_break`; the system first sends its buffered bytes."""
        self._must_be_open()
        self._pull_low(True)
        try:
            time.sleep(seconds)
        finally:
            self._pull_low(False)

    def set_baud(self, baud: int) -> bool:
        """As `Link.set_baud`; not through plain TCP, where the other end has the port."""
        self._must_be_open()
        if isinstance(self.port, RawTcpPort) and not self.port.can_break:
            return False
        before = self.baud
        try:
            self.port.baudrate = self.baud = baud
        except _NOT_SET as error:
            self.baud = before
            if self._gone is not None or not is_unable(error):
                raise self._failed(error) from error
            return False
        return True

    def close(self) -> None:
        if self._gone is None:
            self._gone = CLOSED_HERE
            self._close_port()

    def give_up(self) -> None:
        """As `close`; over a network the next connection replaces this one."""
        if self._gone is None:
            self._gone = CLOSED_HERE
            self._close_port(given_up=True)

    def _pull_low(self, low: bool) -> None:
        if not self._can_break:
            return
        try:
            self.port.break_condition = low
        except _ERRORS as error:
            if self._gone is not None or not is_unable(error):
                raise self._failed(error) from error
            self._can_break = False

    def _must_be_open(self, request: bytes | None = None) -> None:
        if self._gone is not None:
            raise self._lost(self._gone, request)

    def _failed(self, error: Exception, request: bytes | None = None) -> LinkLost:
        """Return the error to raise after the port's `error`, which is raised if it is a bug."""
        if isinstance(error, _CLOSED_MEANWHILE) and self._gone is None:
            raise error
        return also_of_system(self._lose(why_lost(error, self.kind), request), error)

    def _lose(self, why: Text, request: bytes | None = None) -> LinkLost:
        """Close the lost adapter; return the error to raise."""
        self._gone = self._gone or why  # if another thread closed it, that is the reason
        self._close_port(given_up=True)
        return self._lost(self._gone, request)

    def _lost(self, why: Text, request: bytes | None) -> LinkLost:
        port = self.port
        if isinstance(port, RawTcpPort) and port.ended_there:
            lost = at_the_end(self.url, port.number, port.first, port.last, telnet=port.telnet)
        else:
            lost = met_on(self.kind, link_lost(self.url, why))
        lost.request, lost.time = request, self.now()
        return lost

    def explained(self, error: NoConnection | LineError) -> NoConnection | LineError:
        """As `Link.explained`."""
        port = self.port
        if isinstance(error, LinkLost) or not isinstance(port, RawTcpPort):
            return error
        other: NoConnection | LineError | None
        if port.ended_there:
            other = at_the_end(self.url, port.number, port.first, port.last, telnet=port.telnet)
        else:
            other = in_handshake(self.url, port.number, port.first, telnet=port.telnet)
        other = other or with_words(self.url, port.first, error)
        if other is error:
            return error
        other.request, other.received, other.time = error.request, error.received, error.time
        return other

    def _close_port(self, *, given_up: bool = False) -> None:
        """Close the port, once: a second thread might close a descriptor that is in use again."""
        if self._closing.acquire(blocking=False):
            with suppress(*SYSTEM_ERRORS):  # the adapter may be gone already
                if given_up and isinstance(self.port, RawTcpPort):
                    self.port.give_up()
                else:
                    self.port.close()


Receive = Callable[[float], bytes]
"""Takes the seconds to wait; returns bytes as soon as they arrive, or none, perhaps early."""


def _receive(port: OpenPort) -> Receive:
    if isinstance(port, RawTcpPort) or port.timeout == 0:
        return _by_select(port)
    return _by_asking(port)


def _by_select(port: OpenPort) -> Receive:
    number = port.fileno()

    def receive(seconds: float) -> bytes:
        ready, _, _ = select.select([number], [], [], seconds)
        return port.read(MOST_AT_ONCE) if ready else b""

    return receive


def _by_asking(port: serial.Serial) -> Receive:
    def receive(seconds: float) -> bytes:
        first = b""
        if not port.in_waiting:
            if seconds > 2 * TICK:  # two: Windows may stretch a tick by half
                first = port.read(1)
            else:
                time.sleep(min(seconds, GLANCE))
        waiting = port.in_waiting
        return first + port.read(waiting) if waiting else first

    return receive


def open_serial(url: str, options: dict[str, str]) -> SerialLink:
    """Open a port of this computer exclusively: `/dev/ttyUSB0?baud=9600&dtr=1&rts=0`.

    DTR and RTS are set before opening, as far as the system allows: DTR powers some adapters, RTS
    drives the L line of some and is off.
    """
    check_names(options, ("baud", "dtr", "rts"))
    given = OptionParser(options)
    port = serial.Serial(timeout=0 if os.name == "posix" else TICK, exclusive=True)
    port.port = parse(url).address
    port.baudrate = baud = _baud(given)
    port.dtr = given.switch("dtr", default=True)
    port.rts = given.switch("rts", default=False)
    port.write_timeout = _patience(baud)
    try:
        port.open()
    except SYSTEM_ERRORS as error:
        raise opening_failed(url, error) from error
    granularity = AT_ONCE if _ask_low_latency(port) else LATENCY_TIMER
    return SerialLink(url, port, baud=baud, granularity=granularity)


def open_socket(url: str, options: dict[str, str]) -> SerialLink:
    """Open a port served as plain TCP: `socket://host:port`. `baud`: the K-Line's."""
    check_names(options, ("baud",))
    baud = _baud(OptionParser(options))
    return _connect(url, RawTcpPort(patience=_patience(baud)), baud, "TCP")


def open_rfc2217(url: str, options: dict[str, str]) -> SerialLink:
    """Open a port of a terminal server: `rfc2217://host:port`, options as for `open_serial`."""
    check_names(options, ("baud", "dtr", "rts"))
    given = OptionParser(options)
    baud = _baud(given)
    settings = LineSettings(
        baud=baud,
        dtr=given.switch("dtr", default=True),
        rts=given.switch("rts", default=False),
        named=bool(options),
    )
    port = Rfc2217Port(settings, patience=_patience(baud))
    return _connect(url, port, baud, "RFC 2217")


def _connect(url: str, port: RawTcpPort, baud: int, about: str) -> SerialLink:
    host, number = host_and_port(url)
    try:
        port.open((host, number))
    except SYSTEM_ERRORS as error:
        if port.ended_there:
            raise at_the_end(url, number, port.first, port.last, telnet=port.telnet) from error
        raise opening_failed(url, error, port.first) from error
    place = f"[{host}]:{number}" if ":" in host else f"{host}:{number}"
    return SerialLink(
        url,
        port,
        baud=baud,
        about=f"{about} {place}",
        can_break=port.can_break,
        granularity=NETWORK,
    )


def _baud(given: OptionParser) -> int:
    return given.integer("baud", BAUD, lowest=50, highest=4_000_000)


def _patience(baud: int) -> float:
    return PATIENCE + LONGEST_REQUEST * BITS_PER_BYTE / baud


def _ask_low_latency(port: serial.Serial) -> bool:
    """Ask for bytes at once (FTDI: 1 ms instead of 16 ms). Linux only, and not every driver."""
    ask = getattr(port, "set_low_latency_mode", None)
    if ask is None:
        return False
    with suppress(NotImplementedError, *SYSTEM_ERRORS):
        ask(True)
        return True
    return False
