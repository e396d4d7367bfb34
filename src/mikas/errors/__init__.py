"""The tree of all errors.

    MikasError
    ├── UsageError (ValueError)        wrong use; nothing was sent to the ECU
    │   ├── UnknownParameter           no such name or code; carries the nearest names
    │   ├── AddressOutOfRange          outside the memory space
    │   ├── ValueDoesNotFit            not representable in the parameter's raw bytes
    │   ├── BadPortUrl                 invalid port URL, or an invalid option in it
    │   ├── CatalogError               a catalog file is wrong: file, line, what was expected
    │   ├── CaptureError               a capture file can't be read, or can't be written
    │   ├── ExportError                an export can't be made
    │   ├── JournalError               the journal of changes can't be written
    │   └── MissingExtra               an optional library is not installed
    ├── NoConnection (ConnectionError) no port, no adapter or no ECU
    │   ├── PortNotFound               no such port, or no adapter at all
    │   │   └── NoPortGiven            no port named, and not exactly one adapter
    │   ├── PortBusy                   in use by another program
    │   ├── PortDenied                 no permission to open it
    │   ├── PortFailed                 not opened for another reason
    │   ├── LinkLost                   the adapter disconnected while in use
    │   │   └── RecordingOver          the recording played by `replay:` has ended
    │   ├── NoEcho                     nothing received, not even the echo (D1)
    │   ├── EchoOnly                   echo received, no response from the ECU (D1)
    │   └── NotAKLineAdapter           an ELM327 instead of a plain adapter
    ├── LineError                      the ECU is there, the exchange failed
    │   ├── NoResponse (TimeoutError)  silence, D14
    │   │   └── EngineStopped          no response to a stream by strokes (D15)
    │   ├── EchoDiffers                the echo differs from the bytes sent (D1)
    │   ├── DamagedResponse            checksum, cut or over-long frame (§2)
    │   ├── WrongLength                a valid frame of a length not requested (D13)
    │   ├── WrongAddress               a valid frame with another address (D13)
    │   ├── WrongContent               a valid frame with invalid content (§3)
    │   ├── LineNotQuiet               bytes keep coming (D2, D12)
    │   └── SyncLost                   resynchronisation failed (D13)
    ├── EcuRefused                     the ECU refused
    │   ├── WriteRefused               response 01 to a write (§3)
    │   ├── NotSupported               unknown command or parameter (D10)
    │   └── ReadBackDiffers            write accepted, another value read back
    └── NotConfirmed                   a change that was not approved

Each error carries the bytes sent and received and the time; its message ends with what to try:
`str(error)` in English, `error.text` in both languages. Advice that names a command or a screen is
added by the command line (`mikas.cli.advice`) or the dashboard (`mikas.dashboard.errors`). Each
error is also the matching builtin.
"""

from __future__ import annotations

from mikas.errors.base import AdviceTable as AdviceTable
from mikas.errors.base import MikasError as MikasError
from mikas.errors.base import hex_dump as hex_dump
from mikas.errors.base import reason_at as reason_at
from mikas.errors.base import reason_of as reason_of
from mikas.errors.usage import AddressOutOfRange as AddressOutOfRange
from mikas.errors.usage import BadPortUrl as BadPortUrl
from mikas.errors.usage import CaptureError as CaptureError
from mikas.errors.usage import CatalogError as CatalogError
from mikas.errors.usage import ExportError as ExportError
from mikas.errors.usage import JournalError as JournalError
from mikas.errors.usage import MissingExtra as MissingExtra
from mikas.errors.usage import UnknownParameter as UnknownParameter
from mikas.errors.usage import UsageError as UsageError
from mikas.errors.usage import ValueDoesNotFit as ValueDoesNotFit
from mikas.errors.usage import usage_error as usage_error
from mikas.i18n import Text


class NoConnection(MikasError, ConnectionError):
    """No port, no adapter or no ECU."""


class PortNotFound(NoConnection):
    """No such port, or no adapter at all."""

    what = Text("There is no port {url}", "Порта {url} нет")
    advice = Text(
        "Found: {found}. Is the adapter plugged in?", "Найдены: {found}. Адаптер подключён?"
    )


class NoPortGiven(PortNotFound):
    """No port was named and not exactly one likely adapter is plugged in. `example`: a port."""

    what = Text(
        "No port was named, and there is not exactly one likely adapter",
        "Порт не указан, а подходящих адаптеров нет или больше одного",
    )
    advice = Text(
        "Found: {found}. Plug the adapter in, or name its port.",
        "Найдены: {found}. Подключите адаптер или укажите его порт.",
    )

    def __init__(self, *, example: str = "/dev/ttyUSB0", **given: object) -> None:
        super().__init__(example=example, **given)  # type: ignore[arg-type]  # as MikasError's


class PortBusy(NoConnection):
    """Another program has the port open."""

    what = Text("Port {url} is in use by another program", "Порт {url} занят другой программой")
    advice = Text(
        "Likely: another window of mikas or its dashboard, another diagnostics program, a terminal "
        "or ModemManager. Close it, then try again.",
        "Скорее всего, это другое окно mikas или его панель, другая программа диагностики, "
        "терминал или ModemManager. Закройте и повторите.",
    )


class PortDenied(NoConnection):
    """The user has no permission to open the port."""

    what = Text("No permission to open {url}", "Нет прав на открытие {url}")
    advice = Text(
        "On Linux: sudo usermod -aG dialout $USER, then log out and in again.",
        "В Linux: sudo usermod -aG dialout $USER, затем выйти из системы и войти снова.",
    )


class PortFailed(NoConnection):
    """The port could not be opened for another reason, given in the system's own words."""

    what = Text("Port {url} could not be opened: {problem}", "Порт {url} не открылся: {problem}")
    advice = Text(
        "Unplug the adapter and plug it in again; for an address, check host and port.",
        "Отключите и снова подключите адаптер; для сетевого адреса проверьте имя и порт.",
    )


class LinkLost(NoConnection):
    """The adapter disconnected while in use."""

    what = Text("The adapter on {url} is gone: {problem}", "Адаптер на {url} пропал: {problem}")
    advice = Text("Check the USB plug and its cable.", "Проверьте разъём USB и кабель.")


class RecordingOver(LinkLost):
    """The recording played through `replay:` has ended; waiting is useless."""

    what = Text("The recording {file} is over", "Запись {file} закончилась")
    advice = Text(
        "Connect again to play it from the beginning.",
        "Чтобы воспроизвести её сначала, соединитесь снова.",
    )


class NoEcho(NoConnection):
    """Nothing came back, not even the adapter's echo (D1)."""

    what = Text(
        "Nothing came back, not even the echo of what was sent",
        "Не принято ничего, даже эха посланного",
    )
    advice = Text(
        "Likely, in order: the adapter has no 12 V (it is fed from the car's diagnostic socket); "
        "K-Line or ground is not connected; this is another port. With an adapter that returns no "
        "echo: the ignition is off.",
        "Скорее всего, по порядку: на адаптере нет 12 В (он питается от диагностической колодки); "
        "не подключены K-Line или масса; это другой порт. Если адаптер не возвращает эхо: "
        "выключено зажигание.",
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
    """An ELM327, or another adapter with a command interpreter, answered."""

    what = Text(
        "The adapter on this port is an ELM327 (or similar), not a plain K-Line adapter",
        "На этом порту ELM327 (или подобный), а не простой адаптер K-Line",
    )
    advice = Text(
        "An ELM327 interprets the bytes it gets and can't carry this protocol. Use a KKL adapter "
        "(a “VAG-COM 409” cable with FT232 or CH340).",
        "ELM327 сам обрабатывает посланные байты и этот протокол передать не может. Нужен адаптер "
        "KKL (кабель «VAG-COM 409» на FT232 или CH340).",
    )


class LineError(MikasError):
    """The ECU is connected, but the exchange failed, also when repeated."""

    advice = Text(
        "Check ground and plug of the adapter, keep its cable away from the ignition leads.",
        "Проверьте массу и разъём адаптера, отведите кабель от высоковольтных проводов.",
    )


class NoResponse(LineError, TimeoutError):
    """Silence for longer than the limits of D14."""

    what = Text("The ECU did not answer within {seconds:g} s", "Блок не ответил за {seconds:g} с")
    advice = Text(
        "Either this unit does not know the command, or the ignition went off, or the line is bad "
        "(check ground and plug of the adapter).",
        "Либо блок не знает этой команды, либо выключилось зажигание, либо плохая связь по линии "
        "(проверьте массу и разъём адаптера).",
    )


class EngineStopped(NoResponse):
    """No response to a stream by strokes: the unit reports zero speed (D15)."""

    what = Text(
        "No stroke for {seconds:g} s: the engine is not turning",
        "Тактов нет {seconds:g} с: двигатель не вращается",
    )
    advice = Text(
        "A stream by strokes comes only while the engine turns: start it, or use another method.",
        "Поток по тактам идёт, только пока двигатель вращается: запустите его или возьмите другой "
        "способ.",
    )


class EchoDiffers(LineError):
    """The echo differs from the bytes sent: a second talker or a bad line (D1, D2)."""

    what = Text("The echo differs from what was sent", "Эхо отличается от посланного")
    advice = Text(
        "Likely, in order: another tester or unit is sending on the same wire; a bad ground; a "
        "wrong baud rate or echo setting. Disconnect other devices and try again.",
        "Скорее всего, по порядку: на той же линии передаёт другой прибор или блок; плохая масса; "
        "неверная скорость или настройка эха. Отключите остальные приборы и повторите.",
    )


class DamagedResponse(LineError):
    """The response's frame is damaged: checksum, cut short, or too long (§2)."""

    what = Text("The response is damaged: {damage}", "Ответ повреждён: {damage}")


class WrongLength(LineError):
    """A valid frame of a length that does not fit the request (D13)."""

    what = Text(
        "Bytes in the response: {length}; there should be {expected} for this request",
        "В ответе байтов: {length}; на этот запрос должно быть: {expected}",
    )


class WrongAddress(LineError):
    """A valid frame that repeats another address than the request's (D13)."""

    what = Text(
        "The response has address {got}, the request {asked}",
        "В ответе адрес {got}, а в запросе {asked}",
    )


class WrongContent(LineError):
    """A valid frame of the right length with invalid content (§3)."""

    what = Text("Invalid response: {problem}", "Недопустимый ответ: {problem}")


class LineNotQuiet(LineError):
    """Bytes keep coming without a request (D2, D12)."""

    what = Text(
        "The line does not become idle: something keeps sending",
        "Линия не освобождается: передача не прекращается",
    )
    advice = Text(
        "Another tester on the wire, or a stream that the unit does not end: switch the ignition "
        "off for ten seconds and on again.",
        "На линии другой прибор, либо блок не прекращает поток: выключите зажигание на десять "
        "секунд и включите снова.",
    )


class SyncLost(LineError):
    """After a failed exchange the ECU could not be resynchronised (D13)."""

    what = Text(
        "Synchronisation with the ECU could not be restored after a failed exchange",
        "После сбоя обмена не удалось восстановить синхронизацию с блоком",
    )


class EcuRefused(MikasError):
    """The ECU refused the request, or does not know it."""


class WriteRefused(EcuRefused):
    """The ECU answered 01 to a write (§3)."""

    what = Text("The ECU refused the write", "Блок отверг запись")
    advice = Text(
        "This unit does not allow this cell or parameter to be written; nothing was changed.",
        "Этот блок не разрешает запись этой ячейки или параметра; ничего не изменено.",
    )


class NotSupported(EcuRefused):
    """Unknown command or parameter: silence, or 01 where that can't be data (D10)."""

    what = Text("This ECU does not know {command}", "Этот блок не знает {command}")
    advice = Text("Not every unit has every command.", "Не каждый блок знает все команды.")


class ReadBackDiffers(EcuRefused):
    """The write was accepted, but another value was read back."""

    what = Text(
        "{name}: {wanted} was written, {got} was read back",
        "{name}: записано {wanted}, прочитано {got}",
    )
    advice = Text(
        "The cell may be read-only, or the unit's program changes it; read it again before you "
        "rely on it.",
        "Возможно, ячейка доступна только для чтения или её меняет программа блока; прочтите её "
        "ещё раз.",
    )


class NotConfirmed(MikasError):
    """A change that was not approved; nothing was sent."""

    what = Text(
        "Not confirmed, nothing was changed: {change}",
        "Не подтверждено, ничего не изменено: {change}",
    )
    advice = Text("{how}", "{how}")
