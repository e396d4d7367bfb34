"""The link over Web Serial or WebUSB: the adapters that the user has granted to the page (§1).

The ports and their bytes are JavaScript's (`web/src/site/worker/serial.ts`): it stamps each chunk
when it comes, so that one which is read later has its own time. Here a read suspends its stack
until a promise is kept. No promise of it is rejected: what went wrong is text.

A port's name is `webserial:0403:6001`, by USB vendor and product; `webserial:0403:6001:2` is the
second of that kind, `webserial:other` one that is not on USB. `webserial:` is the only one. A
browser shows neither an adapter's serial number nor its socket. So of two like adapters that were
both unplugged, the first one plugged in again gets the first name, whichever it is.

On a phone the scheme is `webusb`: the drivers of the chips are the page's own (`web/src/site/usb`),
so it sets an FTDI's latency timer, knows the rate that a chip makes, and says why it has no cable.
WebUSB also shows the serial number, by which an adapter is found again under any name.
"""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from functools import cache
from importlib import import_module
from typing import Any, Protocol

from mikas.browser.refusals import WEB_USB, refusal
from mikas.errors import NoPortGiven, PortNotFound
from mikas.i18n import Text
from mikas.link.base import (
    AT_ONCE,
    BAUD,
    CLOSED_HERE,
    LONGEST_REQUEST,
    PATIENCE,
    TAKES_NO_BYTES,
    UNPLUGGED,
    WEB_SERIAL,
    AwaitedAnswer,
    Chunk,
    Link,
    link_lost,
)
from mikas.link.chips import LATENCY, OF_DRIVERS, chip_of
from mikas.link.ports import Port, by_likelihood, listed, named
from mikas.link.urls import parse
from mikas.options import OptionParser, check_names

_OTHER = "other"
_CHOOSE = Text(
    "The page may use none of the adapters that are plugged in. Plug it in, press “Choose the "
    "cable…” on the Connection screen and pick it in the browser's list. Not in the list? Check "
    "its plug and cable; on Windows its driver may be missing.",
    "Странице не разрешён ни один из подключённых адаптеров. Подключите его, нажмите на экране "
    "«Связь» кнопку «Выбрать кабель…» и укажите его в списке браузера. Адаптера там нет? Проверьте "
    "разъём и кабель; в Windows может не быть драйвера, на телефоне может быть выключен OTG.",
)
_LATENCY = Text(
    "hands over received bytes after up to 16 ms (its latency timer), which slows single readings "
    "down; a browser can't lower it, on Windows you can: Device Manager, the port, Port Settings, "
    "Advanced",
    "отдаёт принятое с задержкой до 16 мс (latency timer), от этого медленнее одиночные чтения; "
    "браузер её уменьшить не может, в Windows можно вручную: Диспетчер устройств, порт, Параметры "
    "порта, Дополнительно",
)
_WHY_LOST = {
    "closed": CLOSED_HERE,
    "stalled": Text("its chip refuses transfers", "его микросхема отказывается передавать"),
    "stuck": TAKES_NO_BYTES,
    "unplugged": UNPLUGGED,
}


class Pending(Protocol):
    """What JavaScript will have done."""

    promise: Awaitable[Any]


class Granted(Protocol):
    """A port that JavaScript knows."""

    scheme: str
    vid: int | None
    pid: int | None
    serialNumber: str  # noqa: N815  (JavaScript's name)
    nth: int


class Opened(Protocol):
    """An open port, or why it is not open (`refused`, `message`)."""

    lost: str
    granularity: float
    takenAt: float  # noqa: N815  (JavaScript's name)

    def arrival(self, deadline: float, /) -> Pending | None: ...
    def gathering(self, time: float, /) -> Pending: ...
    def take(self) -> Any | None: ...  # noqa: ANN401  (a Uint8Array)
    def write(self, data: bytes, patience: float, /) -> Pending: ...
    def writeAfter(  # noqa: N802
        self, echo: bytes, length: int, data: bytes, patience: float, /
    ) -> None: ...
    def takeBack(self) -> float: ...  # noqa: N802
    def pullLow(self, low: bool, /) -> Pending: ...  # noqa: N802
    def close(self) -> None: ...


class Serial(Protocol):
    """`SerialHost` of serial.ts."""

    def now(self) -> float: ...
    def ports(self) -> Pending: ...
    def open(self, port: Granted, baud: int, dtr: bool, rts: bool, /) -> Pending: ...


Suspend = Callable[[Awaitable[Any]], Any]
"""Wait for a promise, and return what it was kept with."""


class WebSerialLink(Link):
    """A link over the open `port`, which it owns."""

    def __init__(
        self,
        url: str,
        port: Opened,
        *,
        baud: int,
        about: str,
        chip: str = "",
        granularity: float = WEB_SERIAL,
    ) -> None:
        serial, self._suspend = _host()
        self.url = url
        self.baud = baud
        self.granularity = granularity
        self._chip = chip
        self._port = port
        self._clock = serial.now
        self._about = about
        self._sent_until = 0.0
        self._after = 0.0  # s that the data of `write_after` take on the wire

    @property
    def description(self) -> str:
        return self._about

    @property
    def chip(self) -> str:
        return self._chip

    def now(self) -> float:
        return self._clock()

    def write(self, data: bytes) -> None:
        self._must_be_open(data)
        if not data:
            return
        patience = PATIENCE + LONGEST_REQUEST * self.byte_time
        self._suspend(self._port.write(data, patience).promise)
        self._must_be_open(data)
        self._sent_until = max(self._sent_until, self.now()) + len(data) * self.byte_time

    def write_after(self, answer: AwaitedAnswer, data: bytes) -> bool:
        self._after = len(data) * self.byte_time
        patience = PATIENCE + LONGEST_REQUEST * self.byte_time
        self._port.writeAfter(answer.echo, answer.length, data, patience)
        return True

    def take_back(self) -> float | None:
        written = self._port.takeBack()
        if not written:
            return None
        self._sent_until = max(self._sent_until, written) + self._after
        return written

    def read(self, deadline: float) -> Chunk:
        arrival = self._port.arrival(deadline)
        if arrival is not None:
            self._suspend(arrival.promise)
        data = self._port.take()
        if data is None:
            self._must_be_open()
            return Chunk(b"", self.now())
        return Chunk(data.to_bytes(), self._port.takenAt)

    def gather(self, until: float) -> None:
        self._suspend(self._port.gathering(until).promise)

    def send_break(self, seconds: float) -> None:
        """As `Link.send_break`, after what was written: the browser does not wait for that."""
        self._must_be_open()
        self.gather(self._sent_until)
        self._pull_low(True)
        try:
            self.gather(self.now() + seconds)
        finally:
            self._pull_low(False)

    def close(self) -> None:
        self._port.close()

    def _pull_low(self, low: bool) -> None:
        if self._can_break:
            did = self._suspend(self._port.pullLow(low).promise)
            self._must_be_open()
            self._can_break = bool(did)

    def _must_be_open(self, request: bytes | None = None) -> None:
        if why := self._port.lost:
            problem = _WHY_LOST.get(why, Text(why, why))
            raise link_lost(self.url, problem, request=request, time=self.now())


def open_web_serial(url: str, options: dict[str, str]) -> Link:
    """Open a granted port: `webserial:0403:6001?baud=9600&dtr=1&rts=0`, options as `open_serial`.

    Raises `PortNotFound`, `NoPortGiven`, `PortFailed`.
    """
    check_names(options, ("baud", "dtr", "rts"))
    given = OptionParser(options)
    baud = given.integer("baud", BAUD, lowest=50, highest=4_000_000)
    lines = given.switch("dtr", default=True), given.switch("rts", default=False)
    granted = _granted()
    port = _chosen(url, sorted(granted, key=by_likelihood))
    serial, suspend = _host()
    opened = suspend(serial.open(granted[port], baud, *lines).promise)
    if hasattr(opened, "refused"):
        raise refusal(url, port, baud, opened.refused, opened.message)
    # A driver of this page says how late its chip is; a browser's own does not.
    late = opened.granularity + AT_ONCE if opened.granularity else WEB_SERIAL
    return WebSerialLink(
        url, opened, baud=baud, about=port.description, chip=port.chip, granularity=late
    )


def find_web_ports() -> list[Port]:
    """Return the granted ports that are plugged in, the most likely adapter first."""
    return sorted(_granted(), key=by_likelihood)


def _granted() -> dict[Port, Granted]:
    serial, suspend = _host()
    return {_port(it): it for it in suspend(serial.ports().promise)}


@cache
def _host() -> tuple[Serial, Suspend]:
    from mikas.browser.suspension import suspend

    return import_module("mikas_host").serial, suspend


def _port(it: Granted) -> Port:
    is_usb = it.vid is not None and it.pid is not None
    kind = f"{it.vid:04x}:{it.pid:04x}" if is_usb else _OTHER
    chip, quirks = chip_of(it.vid, it.pid)
    if it.scheme == WEB_USB:
        quirks = tuple(quirk for quirk in quirks if quirk not in OF_DRIVERS)
    return Port(
        url=f"{it.scheme}:{kind}" + (f":{it.nth}" if it.nth > 1 else ""),
        description=chip or (f"USB {kind}" if is_usb else "serial port"),
        chip=chip,
        quirks=tuple(_LATENCY if quirk is LATENCY else quirk for quirk in quirks),
        likely=bool(chip),
        vid=it.vid,
        pid=it.pid,
        serial_number=it.serialNumber or None,
    )


def _chosen(url: str, ports: list[Port]) -> Port:
    """Return the port that `url` means."""
    if not ports:
        raise PortNotFound(url=url, found=listed(ports), advice=_CHOOSE)
    parsed = parse(url)
    if not parsed.address:
        if len(ports) > 1:
            raise NoPortGiven(found=listed(ports), example=ports[0].url)
        return ports[0]
    port = named(parsed.name, ports)
    if port is None:
        raise PortNotFound(url=url, found=listed(ports))
    return port
