"""What is wrong with the connection, step by step: port, echo, baud, latency, ECU, commands (D1).

Each step either holds, or says what to do; the first that fails ends the examination, for the ones
after it rest on it. Steps come one by one, so that they can be shown as they run.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from statistics import median

from mikas import commands as c
from mikas.catalog import Catalog
from mikas.client.identity import try_commands
from mikas.errors import EchoDiffers, EchoOnly, LineError, MikasError, NoEcho
from mikas.language import Text
from mikas.link import Link
from mikas.tester import Tester

STEPS = ("port", "echo", "baud", "latency", "ecu", "commands")

_TRIES = 5
_LONG = 96  # parameters in the long request: 100 ms of echo, six times a 16 ms latency timer
_LUMPS = 0.008  # s of delay that no wire and no unit has, but a USB latency timer does
_TOLERANCE = 0.2
_RPM = c.Datum(0x29, 1)


@dataclass(frozen=True, slots=True)
class Step:
    """One finding. `ok` None: could not be told, and it does not matter for the rest."""

    name: str
    ok: bool | None
    detail: Text


def examine(
    open_port: Callable[[], Link], make_tester: Callable[[Link], Tester], catalog: Catalog
) -> Iterator[Step]:
    """The steps in the order of `STEPS`, until one fails. Closes the port at the end."""
    try:
        link = open_port()
    except MikasError as error:
        yield Step("port", False, error.text)
        return
    with link:
        yield Step("port", True, Text(link.description, link.description))
        yield from _on_the_line(make_tester(link), catalog)


def _on_the_line(tester: Tester, catalog: Catalog) -> Iterator[Step]:
    try:
        version_code = tester.connect()
    except EchoOnly as error:
        yield Step("echo", True, _ECHO)
        yield Step("ecu", False, error.text)
        return
    except MikasError as error:
        of_echo = isinstance(error, NoEcho | EchoDiffers)
        yield Step("echo" if of_echo else "ecu", False, error.text)
        return
    yield Step("echo", True, _ECHO if tester.echoes else _NO_ECHO)
    try:
        if tester.echoes:
            yield _baud(tester)
        yield _latency(tester)
        yield Step("ecu", True, catalog.model(version_code).text)
        yield _commands(tester)
    except MikasError as error:
        yield Step("ecu", False, error.text)


_ECHO = Text("the adapter returns what it sends", "адаптер возвращает посланное")
_NO_ECHO = Text(
    "the adapter keeps the echo to itself; collisions can't be seen",
    "адаптер не возвращает эха; столкновения не видны",
)


def _baud(tester: Tester) -> Step:
    """The wire's pace, from how much longer a long request's echo takes than a short one's."""
    short, long = (c.ReadParameters((_RPM,) * count) for count in (1, _LONG))
    try:
        times = [tester.time_echo(command.body()) for command in (short, long)]
    except LineError as error:
        return Step("baud", None, error.reason)
    measured = 10 * (_LONG - 1) / max(times[1] - times[0], 1e-6)
    wanted = tester.link.baud
    told = Text(f"about {measured:.0f} bit/s", f"около {measured:.0f} бит/с")
    if measured > wanted * 2:
        return Step(
            "baud",
            None,
            Text(
                "the echo comes faster than a wire carries it: the adapter makes it itself, or "
                "this is a network or a virtual port. The ECU's answer tells the rest.",
                "эхо приходит быстрее, чем идёт по проводу: его делает сам адаптер, или порт "
                "сетевой либо виртуальный. Остальное скажет ответ блока.",
            ),
        )
    if abs(measured - wanted) > wanted * _TOLERANCE:
        return Step(
            "baud",
            False,
            Text(
                f"{told.en} instead of {wanted}: the computer is too busy, or the adapter is slow",
                f"{told.ru} вместо {wanted}: занят компьютер или медлит адаптер",
            ),
        )
    return Step("baud", True, told)


def _latency(tester: Tester) -> Step:
    """What an answer takes beyond the wire's time: the unit's turn-round and the adapter's
    delay.
    """
    delays = []
    for _ in range(_TRIES):
        began = tester.link.now()
        _, reply = tester.exchange(c.Availability())
        bytes_passed = len(reply.wire) + 3
        delays.append(reply.ended - began - bytes_passed * tester.link.byte_time)
    delay = max(0.0, median(delays))
    told = Text(f"{delay * 1000:.1f} ms a request", f"{delay * 1000:.1f} мс на запрос")
    if delay < _LUMPS:
        return Step("latency", True, told)
    return Step(
        "latency",
        None,
        Text(
            f"{told.en}: the adapter hands bytes over in lumps. It works, but slower; an FT232's "
            "latency timer can be set to 1 ms",
            f"{told.ru}: адаптер отдаёт байты порциями. Работает, но медленнее; таймер FT232 можно "
            "поставить на 1 мс",
        ),
    )


def _commands(tester: Tester) -> Step:
    tried = [support for support in try_commands(tester) if support.known is not None]
    lacks = ", ".join(support.name for support in tried if not support.known)
    known = sum(bool(support.known) for support in tried)
    if not lacks:
        return Step(
            "commands",
            True,
            Text(f"all {known} that were tried", f"все {known}, что пробовались"),
        )
    return Step(
        "commands",
        None,
        Text(f"{known} known; unknown: {lacks}", f"известно {known}; неизвестны: {lacks}"),
    )
