"""Everything that can go wrong, as one tree.

    MikasError
    ├── UsageError (ValueError)        the user asked wrongly; the ECU was not touched
    │   ├── UnknownParameter           no such name or code; carries the nearest names
    │   ├── AddressOutOfRange          outside the memory space
    │   ├── ValueDoesNotFit            not representable in the parameter's raw bytes
    │   ├── BadPortUrl                 the port's URL or one of its options makes no sense
    │   ├── CatalogError               a catalog file is wrong: file, line, what was expected
    │   ├── CaptureError               a capture file can't be read, or can't be written
    │   ├── ExportError                an export can't be made
    │   ├── JournalError               the journal of changes can't be written
    │   └── MissingExtra               an optional library is not installed
    ├── NoConnection (ConnectionError) nobody to talk to
    │   ├── PortNotFound               no such port, or no adapter at all
    │   │   └── NoPortGiven            none was named, and not just one is plugged in
    │   ├── PortBusy                   another program has it
    │   ├── PortDenied                 the user may not open it
    │   ├── PortFailed                 the system gave another reason
    │   ├── LinkLost                   the adapter went away while in use
    │   ├── NoEcho                     nothing came back at all (D1)
    │   ├── EchoOnly                   the echo came back, the ECU is silent (D1)
    │   └── NotAKLineAdapter           an ELM327 answered instead of a wire
    ├── LineError                      the ECU is there, the exchange was spoilt
    │   ├── NoResponse (TimeoutError)  silence, D14
    │   ├── EchoDiffers                what came back is not what was sent (D1)
    │   ├── DamagedResponse            checksum, cut or over-long frame (§2)
    │   ├── WrongLength                a good frame, but not this request's (D13)
    │   ├── WrongAddress               a good frame that echoes another address (D13)
    │   ├── WrongContent               a good frame that makes no sense in itself (§3)
    │   ├── LineNotQuiet               bytes keep coming (D2, D12)
    │   └── OutOfStep                  resynchronisation failed (D13)
    ├── EcuRefused                     the ECU said no
    │   ├── WriteRefused               it answered 01 to a write (§3)
    │   ├── NotSupported               it does not know the command (D10)
    │   └── ReadBackDiffers            it accepted a write and holds something else
    └── NotConfirmed                   a change that nobody approved

Each error carries what was sent, what came back, and when, and its message ends with what to try:
`str(error)` is that in English, `error.text` in both languages. Each is also the matching builtin.
"""

from __future__ import annotations

import errno
from collections.abc import Sequence
from typing import ClassVar

from mikas.language import Language, Text


class MikasError(Exception):
    """The root. `request` and `received` are bytes as on the wire, `time` is the link's clock.

    `what` says what failed; `advice` gives the likely causes in order and what to try. Both may
    hold `str.format` fields, filled from the keyword arguments.
    """

    what: ClassVar[Text] = Text("Something failed", "Что-то не получилось")
    advice: ClassVar[Text] = Text("", "")

    def __init__(
        self,
        *,
        request: bytes | None = None,
        received: bytes | None = None,
        time: float | None = None,
        advice: Text | None = None,
        **fields: object,
    ) -> None:
        self.request = request
        self.received = received
        self.time = time
        self.fields = fields
        self.reason = self.what.filled(**fields)
        self.to_try = (advice or self.advice).filled(**fields)
        super().__init__(self.reason.en)

    def __str__(self) -> str:
        # Not fixed when raised: a higher layer may still add what was on the wire.
        return self.text.en

    @property
    def text(self) -> Text:
        """One short paragraph: what failed, what was sent and received (hex), what to try."""
        return Text(
            _paragraph(self.reason.en, self.to_try.en, *self._wire("en")),
            _paragraph(self.reason.ru, self.to_try.ru, *self._wire("ru")),
        )

    def _wire(self, language: Language) -> list[str]:
        sent, received, nothing, unit = _WIRE[language]
        parts = []
        if self.request is not None:
            parts.append(f"{sent} {in_hex(self.request, unit)}")
        if self.received is not None:
            came = f"{received} {in_hex(self.received, unit)}"
            parts.append(came if self.received else nothing)
        return parts


_WIRE: dict[Language, tuple[str, str, str, str]] = {
    "en": ("sent", "received", "received nothing", "bytes"),
    "ru": ("послано", "принято", "не принято ничего", "байт"),
}
_LONGEST = 48


def in_hex(data: bytes, unit: str = "bytes") -> str:
    """`01 FF 0D`, cut only when it would fill the screen."""
    if len(data) <= _LONGEST:
        return data.hex(" ").upper()
    return f"{data[:_LONGEST].hex(' ').upper()} … ({len(data)} {unit})"


def _paragraph(reason: str, advice: str, *wire: str) -> str:
    text = f"{reason} ({', '.join(wire)})." if wire else f"{reason}."
    return f"{text} {advice}".strip()


class UsageError(MikasError, ValueError):
    """The user asked for something that makes no sense; nothing was sent."""

    what = Text("{problem}", "{problem}")


class UnknownParameter(UsageError):
    """No parameter has this name or code. `suggestions`: the nearest names, best first."""

    what = Text("There is no parameter “{name}”", "Нет параметра «{name}»")
    advice = Text(
        "`mikas params` lists them all; a raw code is written 0x1A, or 0x3F:2 for two bytes.",
        "Все параметры показывает `mikas params`; код без имени пишется 0x1A, двухбайтовый 0x3F:2.",
    )

    def __init__(self, name: str, suggestions: Sequence[str] = ()) -> None:
        self.name = name
        self.suggestions = tuple(suggestions)
        nearest = ", ".join(self.suggestions)
        advice = Text(
            f"Did you mean {nearest}? {self.advice.en}",
            f"Может быть, {nearest}? {self.advice.ru}",
        )
        super().__init__(name=name, advice=advice if nearest else None)


class AddressOutOfRange(UsageError):
    """The address, or the last one of a range, lies outside the memory space."""

    what = Text(
        "{space} has addresses 0 to {last:#06x}; {address:#x} with {count} byte(s) is outside",
        "Адреса {space} — от 0 до {last:#06x}; байты с {address:#x} (всего {count}) — вне их",
    )
    advice = Text(
        "Nothing was sent. Correct the address or the count.",
        "Ничего не послано. Исправьте адрес или число байтов.",
    )


class ValueDoesNotFit(UsageError):
    """The value can't be represented in the raw bytes that the parameter or the cell has."""

    what = Text(
        "{value} does not fit {name}: {allowed}", "{value} не подходит для {name}: {allowed}"
    )
    advice = Text("Nothing was written.", "Ничего не записано.")


class BadPortUrl(UsageError):
    """The port's URL or one of its options makes no sense."""

    what = Text("“{url}” is not a port: {problem}", "«{url}» — не порт: {problem}")
    advice = Text(
        "Ports look like /dev/ttyUSB0, COM3, socket://host:port, rfc2217://host:port, sim: or "
        "replay:FILE.",
        "Порты пишутся так: /dev/ttyUSB0, COM3, socket://host:port, rfc2217://host:port, sim:, "
        "replay:FILE.",
    )


class CatalogError(UsageError):
    """A catalog file is wrong. `file`, `line` (1-based; 0: the file as a whole), `problem`."""

    what = Text("{place}: {problem}", "{place}: {problem}")
    advice = Text(
        "The file was not used; nothing else changed.",
        "Файл не использован; больше ничего не изменилось.",
    )

    def __init__(self, file: str, line: int, problem: Text) -> None:
        self.file, self.line, self.problem = file, line, problem
        super().__init__(place=f"{file}:{line}" if line else file, problem=problem)


class CaptureError(UsageError):
    """A capture can't be read or written. `offset`: where in the file, if known."""

    what = Text("{file}: {problem}", "{file}: {problem}")

    def __init__(self, file: str, problem: Text, offset: int | None = None) -> None:
        self.file, self.problem, self.offset = file, problem, offset
        super().__init__(file=file, problem=problem)


class ExportError(UsageError):
    """An export can't be made: its name, what is in its way, or the disk. Nothing was left
    behind.
    """

    what = Text("{file}: {problem}", "{file}: {problem}")
    advice = Text(
        "Nothing was written; the recording is untouched.",
        "Ничего не записано; сама запись не тронута.",
    )

    def __init__(self, file: str, problem: Text) -> None:
        self.file, self.problem = file, problem
        super().__init__(file=file, problem=problem)


class JournalError(UsageError):
    """The journal of changes can't be written, so no change is made."""

    what = Text(
        "The journal {file} can't be written: {problem}", "Журнал {file} не записывается: {problem}"
    )
    advice = Text(
        "A change that leaves no trace is not made. Free some space or correct the folder's "
        "rights.",
        "Изменения без записи в журнал не делаются. Освободите место или исправьте права папки.",
    )


class MissingExtra(UsageError, ImportError):
    """An optional library is not installed; names the extra that brings it."""

    what = Text(
        "{feature} needs a library that is not installed",
        "Для «{feature}» не установлена библиотека",
    )
    advice = Text(
        'Install it with: pip install "mikas[{extra}]".',
        'Установите: pip install "mikas[{extra}]".',
    )


class NoConnection(MikasError, ConnectionError):
    """Nobody to talk to."""


class PortNotFound(NoConnection):
    """No such port, or no adapter at all."""

    what = Text("There is no port {url}", "Порта {url} нет")
    advice = Text(
        "Found: {found}. Is the adapter plugged in? `mikas ports` lists what the system sees; "
        "`--port sim:` works with no adapter at all.",
        "Найдены: {found}. Воткнут ли адаптер? Что видит система, показывает `mikas ports`; "
        "без адаптера работает `--port sim:`.",
    )


class NoPortGiven(PortNotFound):
    """No port was named and not exactly one likely adapter is plugged in."""

    what = Text(
        "No port was named, and there is not exactly one likely adapter",
        "Порт не указан, а подходящий адаптер не один",
    )


class PortBusy(NoConnection):
    """Another program holds the port."""

    what = Text("Port {url} is in use by another program", "Порт {url} занят другой программой")
    advice = Text(
        "Close the other diagnostics program, terminal or ModemManager, then try again.",
        "Закройте другую программу диагностики, терминал или ModemManager и повторите.",
    )


class PortDenied(NoConnection):
    """The system does not let this user open the port."""

    what = Text("The system does not let you open {url}", "Система не даёт открыть {url}")
    advice = Text(
        "On Linux: sudo usermod -aG dialout $USER, then log out and in again.",
        "В Linux: sudo usermod -aG dialout $USER, затем выйти из системы и войти снова.",
    )


class PortFailed(NoConnection):
    """The port could not be opened for another reason, given in the system's own words."""

    what = Text("Port {url} could not be opened: {problem}", "Порт {url} не открылся: {problem}")
    advice = Text(
        "Unplug the adapter and plug it in again; for an address, check host and port.",
        "Выньте и снова вставьте адаптер; для сетевого адреса проверьте имя и порт.",
    )


class LinkLost(NoConnection):
    """The adapter went away while in use."""

    what = Text("The adapter on {url} is gone: {problem}", "Адаптер на {url} пропал: {problem}")
    advice = Text(
        "Check the USB plug and its cable, then run the command again.",
        "Проверьте разъём USB и кабель, затем повторите команду.",
    )


class NoEcho(NoConnection):
    """Nothing came back, not even the adapter's echo (D1)."""

    what = Text(
        "Nothing came back, not even the echo of what was sent",
        "Не пришло ничего, даже эха посланного",
    )
    advice = Text(
        "Likely, in order: the adapter has no 12 V (it is fed from the car's plug); K-Line or "
        "ground is not connected; this is another port (`mikas ports`). With an adapter that "
        "keeps the echo to itself: the ignition is off. Then try `mikas doctor`.",
        "Скорее всего, по порядку: на адаптере нет 12 В (он питается от разъёма машины); не "
        "подключены K-Line или масса; это другой порт (`mikas ports`). Если адаптер не даёт эха: "
        "выключено зажигание. Затем попробуйте `mikas doctor`.",
    )


class EchoOnly(NoConnection):
    """The echo came back, the ECU did not answer (D1)."""

    what = Text(
        "The adapter works (its echo came back), but the ECU does not answer",
        "Адаптер работает (эхо пришло), но блок не отвечает",
    )
    advice = Text(
        "Likely, in order: the ignition is off; the K-Line wire goes to another unit or pin; the "
        "unit has no supply; it is not a Mikas 5.4 / 7.1. Switch the ignition on and try again.",
        "Скорее всего, по порядку: выключено зажигание; провод K-Line идёт к другому блоку или "
        "выводу; нет питания блока; это не Микас 5.4 / 7.1. Включите зажигание и повторите.",
    )


class NotAKLineAdapter(NoConnection):
    """An ELM327, or another thing with a mind of its own, answered."""

    what = Text(
        "Behind this port is an ELM327 (or alike), not a plain K-Line adapter",
        "За этим портом ELM327 (или подобный), а не простой адаптер K-Line",
    )
    advice = Text(
        "An ELM327 interprets what it is sent and can't carry this protocol. Use a KKL adapter "
        "(a “VAG-COM 409” cable with FT232 or CH340).",
        "ELM327 сам толкует посылаемое и этот протокол передать не может. Нужен адаптер KKL "
        "(кабель «VAG-COM 409» на FT232 или CH340).",
    )


class LineError(MikasError):
    """The ECU was there, but this exchange was spoilt, and repeating it did not help."""

    advice = Text(
        "Check ground and plug of the adapter, keep its cable away from the ignition leads; "
        "`mikas doctor` looks at the line step by step.",
        "Проверьте массу и разъём адаптера, отведите кабель от высоковольтных проводов; "
        "`mikas doctor` проверит линию по шагам.",
    )


class NoResponse(LineError, TimeoutError):
    """Silence for longer than the limits of D14."""

    what = Text("The ECU did not answer within {seconds:g} s", "Блок не ответил за {seconds:g} с")
    advice = Text(
        "Either this unit does not know the command (`mikas info` shows what it knows), or the "
        "ignition went off, or the line is bad (`mikas doctor`). `--timeout` makes it wait longer.",
        "Либо блок не знает этой команды (что он знает, показывает `mikas info`), либо выключилось "
        "зажигание, либо плоха линия (`mikas doctor`). Ждать дольше: `--timeout`.",
    )


class EchoDiffers(LineError):
    """What came back is not what was sent: a second talker or a bad line (D1, D2)."""

    what = Text("The echo differs from what was sent", "Эхо отличается от посланного")
    advice = Text(
        "Likely, in order: another tester or unit talks on the same wire; a bad ground; a wrong "
        "baud rate or `--echo` setting. Disconnect other devices, then try `mikas doctor`.",
        "Скорее всего, по порядку: на том же проводе говорит другой прибор или блок; плохая масса; "
        "неверная скорость или `--echo`. Отключите остальные приборы, затем `mikas doctor`.",
    )


class DamagedResponse(LineError):
    """The response's frame is damaged: checksum, cut short, or too long (§2)."""

    what = Text("The response came damaged: {damage}", "Ответ пришёл с повреждением: {damage}")


class WrongLength(LineError):
    """A sound frame of a length that does not fit the request (D13)."""

    what = Text(
        "The response has {length} byte(s), this request's has {expected}",
        "В ответе байтов: {length}; на этот запрос должно быть: {expected}",
    )


class WrongAddress(LineError):
    """A sound frame that repeats another address than the request's (D13)."""

    what = Text(
        "The response speaks of address {got}, the request of {asked}",
        "В ответе адрес {got}, а в запросе {asked}",
    )


class WrongContent(LineError):
    """A sound frame of the right length whose content breaks the response's own rules (§3)."""

    what = Text("The response makes no sense: {problem}", "Ответ не имеет смысла: {problem}")


class LineNotQuiet(LineError):
    """Bytes keep coming although nothing was asked (D2, D12)."""

    what = Text(
        "The line does not become quiet: something keeps sending",
        "Линия не смолкает: кто-то продолжает передавать",
    )
    advice = Text(
        "Another tester on the wire, or a stream that the unit does not end: switch the ignition "
        "off for ten seconds and on again.",
        "На проводе другой прибор, либо блок не прекращает поток: выключите зажигание на десять "
        "секунд и включите снова.",
    )


class OutOfStep(LineError):
    """After a failed exchange the ECU could not be brought back in step (D13)."""

    what = Text(
        "The ECU could not be brought back in step after a spoilt exchange",
        "После сбоя обмена не удалось снова согласоваться с блоком",
    )


class EcuRefused(MikasError):
    """The ECU understood, or did not know the request, and said no."""


class WriteRefused(EcuRefused):
    """The ECU answered 01 to a write (§3)."""

    what = Text("The ECU refused the write", "Блок отверг запись")
    advice = Text(
        "This unit does not let this cell or parameter be written; nothing was changed.",
        "Этот блок не даёт записать эту ячейку или параметр; ничего не изменено.",
    )


class NotSupported(EcuRefused):
    """The ECU does not know the command or the parameter: silence, or 01 where it can't be data
    (D10).
    """

    what = Text("This ECU does not know {command}", "Этот блок не знает {command}")
    advice = Text(
        "Not every unit has every command; `mikas info` shows what this one has.",
        "Не каждый блок знает все команды; что знает этот, показывает `mikas info`.",
    )


class ReadBackDiffers(EcuRefused):
    """The write was accepted, but the cell then held something else."""

    what = Text(
        "{name} was written with {wanted} but then held {got}",
        "В {name} записано {wanted}, а читается {got}",
    )
    advice = Text(
        "The cell may be read-only or driven by the program; read it again before relying on it.",
        "Ячейка может быть только для чтения или её меняет программа; прочтите её ещё раз.",
    )


class NotConfirmed(MikasError):
    """A change that nobody approved; nothing was sent."""

    what = Text(
        "Not confirmed, nothing was changed: {change}",
        "Не подтверждено, ничего не изменено: {change}",
    )
    advice = Text("{how}", "{how}")


_IN_RUSSIAN = {
    errno.ENOENT: "нет такого файла или папки",
    errno.EACCES: "система не разрешает",
    errno.EPERM: "система не разрешает",
    errno.EROFS: "запись туда невозможна",
    errno.EISDIR: "это папка",
    errno.ENOTDIR: "часть пути — не папка",
    errno.EEXIST: "уже существует",
    errno.ENOSPC: "диск заполнен",
    errno.EADDRINUSE: "этот адрес уже занят",
    errno.EADDRNOTAVAIL: "у этой машины нет такого адреса",
}


def reason_of(error: OSError) -> Text:
    """Why the system refused, in its own words; in Russian where they are known."""
    words = error.strerror or str(error)
    return Text(words, _IN_RUSSIAN.get(error.errno or 0, words))
