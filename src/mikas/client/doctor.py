"""The check of the connection, step by step: port, echo, baud, latency, line, ECU (D1).

Each step passes, or says what to do; a step after which no ECU can answer ends the check. Steps are
yielded one by one, so that they can be shown as they run.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from statistics import median

from mikas import commands as c
from mikas.catalog import Catalog
from mikas.client.identity import try_commands
from mikas.errors import (
    EchoDiffers,
    EchoOnly,
    LineError,
    MikasError,
    NoConnection,
    NoEcho,
    NotAKLineAdapter,
)
from mikas.i18n import Text
from mikas.link import Link
from mikas.link.ports import described
from mikas.tester import Tester

STEPS = ("port", "echo", "baud", "latency", "line", "ecu", "commands")

_TRIES = 20
_MANY = 3  # failed exchanges of these; more of them is more than repetitions should have to cure
_LONG = 96  # parameters in the long request: 100 ms of echo, six times a 16 ms latency timer
_TIMES = 3
_LUMPS = 0.008  # s; no wire and no unit delays a response so long, but a USB latency timer does
_TOLERANCE = 0.2
_RPM = c.Datum(0x29, 1)


@dataclass(frozen=True, slots=True)
class Step:
    """One result. `ok` None: unknown, or could be better; the other steps do not depend on it.

    `detail` says what to do, unless all is well. `error`: the error whose text `detail` is.
    """

    name: str
    ok: bool | None
    detail: Text
    error: MikasError | None = None


def examine(
    open_port: Callable[[], Link], make_tester: Callable[[Link], Tester], catalog: Catalog
) -> Iterator[Step]:
    """Yield the steps in the order of `STEPS`, until no ECU can answer. Closes the port.

    Raises what `open_port` raises, except a `NoConnection`, which is a result.
    """
    try:
        link = open_port()
    except NoConnection as error:
        yield _failed("port", error)
        return
    with link:
        yield Step("port", True, described(link.description))
        yield from _on_the_line(make_tester(link), catalog)


def _on_the_line(tester: Tester, catalog: Catalog) -> Iterator[Step]:
    try:
        version_code = tester.connect()
    except EchoOnly as error:
        yield Step("echo", True, _ECHO)
        yield _failed("ecu", error)
        return
    except MikasError as error:
        of_echo = isinstance(error, NoEcho | EchoDiffers | NotAKLineAdapter)
        yield _failed("echo" if of_echo else "ecu", error)
        return
    yield Step("echo", True, _ECHO if tester.echoes else _NO_ECHO)
    name = "baud"
    try:
        pace = float(tester.link.baud)
        if tester.echoes:
            measured = _measured_baud(tester)
            yield _baud(measured, tester.link.baud)
            pace = min(pace, measured) if measured else pace
        name = "line"
        yield from _availability(tester, 10 / pace)
        yield Step("ecu", True, catalog.model(version_code).text)
        name = "commands"
        yield _commands(tester)
    except MikasError as error:
        yield _failed(name, error)


_ECHO = Text("the adapter returns what it sends", "адаптер возвращает посланное")
_NO_ECHO = Text(
    "the adapter keeps the echo to itself; two talking at once can't be noticed",
    "адаптер не возвращает эха: если говорят двое сразу, этого не видно",
)


def _failed(name: str, error: MikasError) -> Step:
    return Step(name, False, error.text, error)


def _measured_baud(tester: Tester) -> float | None:
    """Measure the baud rate: how much longer a long request's echo takes than a short one's.

    The quickest of several each: a busy computer can only add to them.
    """
    bodies = [c.ReadParameters((_RPM,) * count).body() for count in (1, _LONG)]
    try:
        short, long = (min(tester.time_echo(body) for _ in range(_TIMES)) for body in bodies)
    except LineError:  # the next step shows how bad the line is
        return None
    return 10 * (_LONG - 1) / max(long - short, 1e-6)


def _baud(measured: float | None, wanted: int) -> Step:
    """Whether that is as fast as it should be."""
    if measured is None:
        return Step(
            "baud",
            None,
            Text("not measured: the echo was damaged", "не измерена: эхо пришло испорченным"),
        )
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
                f"{told.en} instead of {wanted}. Likely, in order: the other end runs at another "
                "pace (its own baud setting); the computer is too busy; the adapter is slow. "
                "Correct that pace, or close other programs and try again.",
                f"{told.ru} вместо {wanted}. Скорее всего, по порядку: другой конец работает на "
                "другой скорости (она задаётся у него); компьютер слишком занят; адаптер медлит. "
                "Исправьте скорость или закройте другие программы и повторите.",
            ),
        )
    return Step("baud", True, told)


def _availability(tester: Tester, byte_time: float) -> Iterator[Step]:
    """Measure the adapter's delay and the line's errors by the same short exchanges."""
    delays, failed = [], []
    for _ in range(_TRIES):
        began = tester.link.now()
        try:
            _, reply = tester.exchange(c.Availability(), retries=0)
        except LineError as error:
            failed.append(error)
            if len(failed) > _MANY:
                break
            continue
        bytes_passed = len(reply.wire) + 3
        delays.append(reply.ended - began - bytes_passed * byte_time)
    if delays:
        yield _latency(max(0.0, median(delays)))
    yield _line(len(delays) + len(failed), failed)


def _latency(delay: float) -> Step:
    """The time of an answer beyond the wire's: the unit's turn-round, the adapter's delay."""
    milliseconds = f"{delay * 1000:.1f}"
    told = Text(f"{milliseconds} ms a request", f"{milliseconds.replace('.', ',')} мс на запрос")
    if delay < _LUMPS:
        return Step("latency", True, told)
    return Step(
        "latency",
        None,
        Text(
            f"{told.en}: the adapter hands bytes over in lumps. It works, but slower; an FT232's "
            "latency timer can be set to 1 ms (in Windows: Device Manager, the port, Port "
            "Settings, Advanced)",
            f"{told.ru}: адаптер отдаёт байты порциями. Работает, но медленнее; таймер задержки "
            "FT232 можно поставить на 1 мс (в Windows: Диспетчер устройств, порт, Параметры "
            "порта, Дополнительно)",
        ),
    )


def _line(tried: int, failed: list[LineError]) -> Step:
    """The number of failed exchanges, and the last error."""
    if not failed:
        return Step(
            "line",
            True,
            Text(f"{tried} exchanges, none failed", f"обменов {tried}, все чистые"),
        )
    last = failed[-1]
    return Step(
        "line",
        False if len(failed) > _MANY else None,
        Text(
            f"{len(failed)} of {tried} exchanges failed; the last: {last.text.en}",
            f"испорчено обменов: {len(failed)} из {tried}; последний: {last.text.ru}",
        ),
    )


def _commands(tester: Tester) -> Step:
    tried = [support for support in try_commands(tester) if support.known is not None]
    lacking = [support.command for support in tried if not support.known]
    known = len(tried) - len(lacking)
    if not lacking:
        return Step(
            "commands",
            True,
            Text(f"all {known} that were tried", f"работают все проверенные, {known}"),
        )
    lacks = [
        Text(f"{it.CODES[0]:02X} {it.TITLE.en}", f"{it.CODES[0]:02X} {it.TITLE.ru}")
        for it in lacking
    ]
    return Step(
        "commands",
        None,
        Text(
            f"{known} known; this unit does not know: {', '.join(it.en for it in lacks)}",
            f"известно {known}; блок не знает: {', '.join(it.ru for it in lacks)}",
        ),
    )
