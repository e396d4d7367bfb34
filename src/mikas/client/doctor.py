"""The check of the connection, step by step: port, echo, baud, latency, line, ECU (D1).

Each step passes or gives advice. A step after which no ECU can answer ends the check. Steps are
yielded one by one, so that a user interface can show them as they run.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator
from dataclasses import dataclass, replace
from functools import partial
from statistics import median
from typing import Final

from mikas import commands as c
from mikas import errors
from mikas.client.ecu import Ecu
from mikas.client.support import Support
from mikas.errors import PortKind
from mikas.framing import encode
from mikas.i18n import Text
from mikas.link import Link
from mikas.link.chips import has_latency_timer, has_usual_rates
from mikas.link.holders import shared
from mikas.link.ports import described
from mikas.link.urls import parse
from mikas.tester import Tester
from mikas.tester.pauses import Pauses

STEPS = ("port", "echo", "baud", "latency", "line", "ecu", "commands")

_TRIES = 20
_MOST_FAILURES = 3  # of these tries on an acceptable line
_LONG = 96  # parameters in the long request: 100 ms of echo, six times a 16 ms latency timer
_REPETITIONS = 3
_LUMPS = 0.008  # s; a USB latency timer delays a response so long, a wire or a unit does not
_TOLERANCE = 0.2
_LATE = 0.05  # s that an echo may be late: three times a latency timer, less than the difference
_DAMAGED_ECHO = Text("not measured: the echo was damaged", "не измерена: эхо повреждено")
_LATE_ECHO: Final = {
    PortKind.CABLE: Text(
        "not measured: the echo came late. The computer is too busy: close other programs and try "
        "again.",
        "не измерена: эхо пришло поздно. Компьютер слишком занят: закройте другие программы и "
        "повторите.",
    ),
    PortKind.NETWORK: Text(
        "not measured: the echo came late. The bridge's Wi-Fi is weak, or this computer is busy.",
        "не измерена: эхо пришло поздно. Слабый Wi-Fi у моста, либо занят компьютер.",
    ),
}
_IN_LUMPS: Final = {
    PortKind.CABLE: Text(
        "the adapter hands bytes over in lumps. It works, but slower; an FT232's latency timer can "
        "be set to 1 ms (in Windows: Device Manager, the port, Port Settings, Advanced)",
        "адаптер отдаёт байты порциями. Работает, но медленнее; таймер задержки FT232 можно "
        "поставить на 1 мс (в Windows: Диспетчер устройств, порт, Параметры порта, Дополнительно)",
    ),
    PortKind.NETWORK: Text(
        "the bridge or the network hands bytes over late. It works, but slower; set the bridge's "
        "packing time to the shortest, and bring it nearer to the Wi-Fi",
        "мост или сеть отдаёт байты поздно. Работает, но медленнее; задайте на мосту самое "
        "короткое время сборки пакетов и поставьте его ближе к Wi-Fi",
    ),
}
_NO_TIMER = Text(
    "the adapter hands bytes over in lumps. It works, but slower; this chip has nothing to set, a "
    "cable with an FT232R is faster",
    "адаптер отдаёт байты порциями. Работает, но медленнее; у этой микросхемы настроить нечего, "
    "кабель на FT232R быстрее",
)
_QUIET = 0.1  # s without a byte, after which the line is taken for silent
_USUAL = frozenset((300, 600, 1200, 2400, 4800, 7200, 9600, 14400, 19200, 38400, 57600, 115200))
_RPM = c.Datum(0x29, 1)


@dataclass(frozen=True, slots=True)
class Step:
    """One result. `ok` None: unknown, or could be better; other steps do not depend on it.

    `detail` advises what to do if `ok` is not True. `error`: the error whose text is `detail`.
    """

    name: str
    ok: bool | None
    detail: Text
    error: errors.MikasError | None = None


def examine(
    open_port: Callable[[], Link],
    create_ecu: Callable[[Link], Ecu],
    *,
    others: Callable[[Link], Iterator[Step]] | None = None,
) -> Generator[Step, None, None]:
    """Yield the steps in the order of `STEPS`, until no ECU can answer. Closes the port.

    `create_ecu`: as `ConnectionOptions.create_ecu`; the unit's list (64) is the one thing changed.
    `others`: yields further steps where no Mikas answers on the line (`other_units`).
    Raises the errors of `open_port`, except `NoConnection`, which is a result.
    """
    try:
        link = open_port()
    except errors.NoConnection as error:
        yield _failed("port", error)
        return
    with link:
        yield _port(link)
        ecu, silent = create_ecu(link), False
        for step in _on_the_line(ecu):
            silent = _is_silent(step)
            yield step
        if silent and others is not None:
            try:
                yield from others(ecu.tester.link)
            except errors.NoConnection as error:
                yield _failed("port", error)


def _is_silent(step: Step) -> bool:
    """Whether the line works as far as it goes, and no Mikas was found on it."""
    is_wrong = isinstance(step.error, errors.NotAKLineAdapter | errors.LinkLost)
    on_line = isinstance(step.error, errors.LineError | errors.NoEcho | errors.EchoOnly)
    return step.name in ("echo", "ecu") and on_line and not is_wrong


def _on_the_line(ecu: Ecu) -> Iterator[Step]:
    tester = ecu.tester
    try:
        tester.connect()
    except errors.EchoOnly as error:
        yield Step("echo", True, _ECHO)
        yield from _baud_of_echo(tester.link)
        yield _failed("ecu", error)
        return
    except errors.MikasError as error:
        of_echo = isinstance(error, errors.NoEcho | errors.EchoDiffers | errors.NotAKLineAdapter)
        yield _failed("echo" if of_echo else "ecu", error)
        return
    yield Step("echo", True, _ECHO if tester.line.echo else _NO_ECHO)
    name = "baud"
    try:
        rate = float(tester.link.baud)
        if tester.line.echo:
            measured = _measured_baud(tester.time_echo, tester.link)
            yield _baud(measured, tester.link)
            rate = min(rate, measured) if isinstance(measured, float) else rate
        name = "line"
        if tester.pauses.seconds and tester.pauses.setting is None:
            ecu.limits()  # the unit that needs that pause may be another one than this
        answered = yield from _availability(tester, 10 / rate)
        if not answered:  # to try each command would take minutes, and show nothing
            return
        yield Step("ecu", True, ecu.model.text)
        name = "commands"
        yield _commands(list(ecu.supported()))
    except errors.MikasError as error:
        yield _failed(name, error)


def _port(link: Link) -> Step:
    """Return the port's step; a program of root may have it open too, and send its own bytes."""
    url = parse(link.url)
    other = shared(link.url, url.address) if url.scheme == "serial" else None
    if other is not None:
        return Step("port", None, other.text, other)
    return Step("port", True, described(link.description))


_ECHO = Text("the adapter returns what it sends", "адаптер возвращает посланное")
_NO_ECHO = Text(
    "the adapter keeps the echo, so collisions on the line can't be detected",
    "адаптер не возвращает эхо, поэтому коллизии на линии не обнаруживаются",
)


def _failed(name: str, error: errors.MikasError) -> Step:
    return Step(name, False, error.text, error)


def _baud_of_echo(link: Link) -> Iterator[Step]:
    """Measure the baud rate where no ECU answers: a wrong one may be why."""
    try:
        measured = _measured_baud(partial(_timed_echo, link), link)
    except errors.LinkLost:  # the next step says so
        return
    yield _baud(measured, link)


def _timed_echo(link: Link, body: bytes) -> float:
    """Return the seconds from the write of `body` to the end of its echo. Raises `EchoDiffers`."""
    while link.read(link.now() + _QUIET).data:
        pass
    wire, heard = encode(body), b""
    began = link.now()
    link.write(wire)  # which a busy computer may hold back
    deadline = link.now() + 4 * len(wire) * link.byte_time + 1
    while len(heard) < len(wire):
        chunk = link.read(deadline)
        heard += chunk.data
        if not chunk.data or not wire.startswith(heard[: len(wire)]):
            raise errors.EchoDiffers(request=wire, received=heard, time=link.now())
    return chunk.time - began


def _measured_baud(time_echo: Callable[[bytes], float], link: Link) -> float | Text:
    """Measure the baud rate by the difference of a long and a short request's echo times.

    The shortest of several times counts, for a busy computer only adds delays. A text says why
    there is no result.
    """
    bodies = [c.ReadParameters((_RPM,) * count).body() for count in (1, _LONG)]
    try:
        short, long = (min(time_echo(body) for _ in range(_REPETITIONS)) for body in bodies)
    except errors.LineError:  # the next step rates the line
        return _DAMAGED_ECHO
    rate = 10 * (_LONG - 1) / max(long - short, 1e-6)
    # If the short ones were late, the difference is too small: a slow wire would seem right.
    late = short - 10 * len(encode(bodies[0])) / rate
    if late >= max(_LATE, link.granularity):
        return _LATE_ECHO[link.kind]
    return rate


def _baud(measured: float | Text, link: Link) -> Step:
    """Rate the measured speed."""
    wanted = link.baud
    if isinstance(measured, Text):
        return Step("baud", None, measured)
    rate = Text(f"about {measured:.0f} bit/s", f"около {measured:.0f} бит/с")
    if measured > wanted * 2:
        text = Text(
            "the echo arrives faster than a wire carries it: the adapter generates it, or this is "
            "a network or a virtual port. The baud rate is checked by the ECU's answer.",
            "эхо приходит быстрее, чем по проводу: его формирует сам адаптер, или порт сетевой "
            "либо виртуальный. Скорость проверит ответ блока.",
        )
        return Step("baud", None, text)
    is_wrong = abs(measured - wanted) > wanted * _TOLERANCE
    if is_wrong and wanted not in _USUAL and has_usual_rates(link.chip):
        text = Text(
            f"{rate.en} instead of {wanted}: a CP2101, CP2102, CP2103 or CP2108 knows the usual "
            "baud rates only. Take a cable with another chip for this one, an FT232R or a CH340.",
            f"{rate.ru} вместо {wanted}: CP2101, CP2102, CP2103 и CP2108 знают только обычные "
            "скорости. Для этой возьмите кабель на другой микросхеме: FT232R или CH340.",
        )
        return Step("baud", False, text)
    if is_wrong:
        text = Text(
            f"{rate.en} instead of {wanted}. Likely, in order: the other end is set to another "
            "baud rate; the computer is too busy; the adapter is slow. Correct the baud rate, or "
            "close other programs and try again.",
            f"{rate.ru} вместо {wanted}. Скорее всего, по порядку: на другой стороне задана другая "
            "скорость; компьютер слишком занят; адаптер медленный. Исправьте скорость или закройте "
            "другие программы и повторите.",
        )
        return Step("baud", False, text)
    return Step("baud", True, rate)


def _availability(tester: Tester, byte_time: float) -> Generator[Step, None, bool]:
    """Measure the adapter's delay and the line's errors by the same short exchanges.

    Return whether any exchange succeeded.
    """
    delays, failed = [], []
    for _ in range(_TRIES):
        began = tester.link.now()
        try:
            _, reply = tester.exchange(c.Availability(), retries=0)
        except errors.LineError as error:
            failed.append(error)
            if len(failed) > _MOST_FAILURES:
                break
            continue
        bytes_passed = len(reply.wire) + 3
        delays.append(reply.ended - began - bytes_passed * byte_time)
    if delays:
        yield _latency(max(0.0, median(delays) - tester.line.pause), tester.link)
    yield _with_pause(_line(len(delays) + len(failed), failed), tester.pauses)
    return bool(delays)


def _latency(delay: float, link: Link) -> Step:
    """Rate the time of an answer beyond the wire's: the unit's reaction, the adapter's delay."""
    milliseconds = f"{delay * 1000:.1f}"
    time = Text(f"{milliseconds} ms a request", f"{milliseconds.replace('.', ',')} мс на запрос")
    if delay < _LUMPS:
        return Step("latency", True, time)
    has_no_timer = link.chip != "" and not has_latency_timer(link.chip)
    why = _NO_TIMER if has_no_timer else _IN_LUMPS[link.kind]
    text = Text(f"{time.en}: {why.en}", f"{time.ru}: {why.ru}")
    return Step("latency", None, text)


def _line(tried: int, failed: list[errors.LineError]) -> Step:
    """Rate the number of failed exchanges; show the last error."""
    if not failed:
        text = Text(f"{tried} exchanges, none failed", f"обменов {tried}, все без ошибок")
        return Step("line", True, text)
    last = failed[-1].text
    text = Text(
        f"{len(failed)} of {tried} exchanges failed; the last: {last.en}",
        f"обменов с ошибкой: {len(failed)} из {tried}; последний: {last.ru}",
    )
    return Step("line", False if len(failed) > _MOST_FAILURES else None, text)


def _with_pause(line: Step, pauses: Pauses) -> Step:
    """Add the pause that is kept before a request, if any."""
    if not pauses.seconds:
        return line
    milliseconds = f"{pauses.seconds * 1000:g}"
    pause = Text(f"{milliseconds} ms", f"{milliseconds.replace('.', ',')} мс")
    kept = Text(
        f"a pause of {pause.en} is kept before each request, as set",
        f"перед каждым запросом выдерживается заданная пауза, {pause.ru}",
    )
    if pauses.setting is None:
        kept = Text(
            f"this unit ignores a request that follows its response too soon, so a pause of "
            f"{pause.en} is kept before each",
            f"этот блок не слышит запрос сразу после своего ответа, поэтому перед каждым "
            f"выдерживается пауза {pause.ru}",
        )
    text = Text(f"{line.detail.en}; {kept.en}", f"{line.detail.ru}; {kept.ru}")
    return replace(line, detail=text)


def _commands(supported: list[Support]) -> Step:
    tried = [support for support in supported if support.known is not None]
    lacking = [support for support in tried if not support.known]
    known = len(tried) - len(lacking)
    untried = _untried(supported)
    if not lacking:
        text = Text(
            f"all {known} that were tried{untried.en}",
            f"работают все проверенные, {known}{untried.ru}",
        )
        return Step("commands", True, text)
    en = ", ".join(f"{support.code:02X} {support.title.en}" for support in lacking)
    ru = ", ".join(f"{support.code:02X} {support.title.ru}" for support in lacking)
    text = Text(
        f"{known} known; this unit does not know: {en}{untried.en}",
        f"известно {known}; блок не знает: {ru}{untried.ru}",
    )
    return Step("commands", None, text)


def _untried(supported: list[Support]) -> Text:
    """Return the commands without a result, by their reasons; empty if there are none."""
    codes: dict[Text, list[str]] = {}
    for support in supported:
        if support.reason is not None:
            codes.setdefault(support.reason, []).append(f"{support.code:02X}")
    en = "".join(f"; not tried: {' '.join(each)} ({why.en})" for why, each in codes.items())
    ru = "".join(f"; не проверены: {' '.join(each)} ({why.ru})" for why, each in codes.items())
    return Text(en, ru)
