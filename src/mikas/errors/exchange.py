"""The ECU is there, but the exchange failed, or the ECU refused (§2, §3, D10, D12–D14)."""

from __future__ import annotations

from typing import ClassVar

from mikas.errors.base import MikasError
from mikas.i18n import Text


class LineError(MikasError):
    """The ECU is connected, but the exchange failed, also when repeated."""

    advice: Text = Text(
        "Check ground and plug of the adapter, keep its cable away from the ignition leads.",
        "Проверьте массу и разъём адаптера, отведите кабель от высоковольтных проводов.",
    )


class NoResponse(LineError, TimeoutError):
    """Silence for longer than the limits of D14."""

    what: ClassVar[Text] = Text(
        "The ECU did not answer within {seconds:g} s", "Блок не ответил за {seconds:g} с"
    )
    advice: Text = Text(
        "Either this unit does not know the command, or the ignition went off, or the line is bad "
        "(check ground and plug of the adapter).",
        "Либо блок не знает этой команды, либо выключилось зажигание, либо плохая связь по линии "
        "(проверьте массу и разъём адаптера).",
    )


class DeadlinePassed(MikasError, TimeoutError):
    """The `timeout` of a call has passed. `seconds`: how long that was.

    No `LineError`: nothing is wrong with the line, and the next call may follow.
    """

    what: ClassVar[Text] = Text(
        "The call was given {seconds:g} s and was not done then",
        "На вызов было отведено {seconds:g} с, за это время он не закончился",
    )
    advice: Text = Text(
        "It ended between two requests. Give it a longer timeout, or less to do.",
        "Он прерван между двумя запросами. Увеличьте timeout или дайте меньше работы.",
    )


class EngineStopped(NoResponse):
    """No response to a stream by strokes: the unit reports zero speed (D15)."""

    what: ClassVar[Text] = Text(
        "No stroke for {seconds:g} s: the engine is not turning",
        "Тактов нет {seconds:g} с: двигатель не вращается",
    )
    advice: Text = Text(
        "A stream by strokes comes only while the engine turns: start it, or use another method.",
        "Поток по тактам идёт, только пока двигатель вращается: запустите его или возьмите другой "
        "способ.",
    )


class EchoDiffers(LineError):
    """The echo differs from the bytes sent: a second talker or a bad line (D1, D2)."""

    what: ClassVar[Text] = Text(
        "The echo differs from what was sent", "Эхо отличается от посланного"
    )
    advice: Text = Text(
        "Likely, in order: another tester or unit is sending on the same wire; a bad ground; a "
        "wrong baud rate or echo setting. Disconnect other devices and try again.",
        "Скорее всего, по порядку: на той же линии передаёт другой прибор или блок; плохая масса; "
        "неверная скорость или настройка эха. Отключите остальные приборы и повторите.",
    )


class WrongEchoSetting(EchoDiffers):
    """The line echoes and the setting says that it does not, or the other way round (D1)."""

    what: ClassVar[Text] = Text("{problem}", "{problem}")
    advice: Text = Text(
        "Set the echo to auto: then it is detected.", "Задайте эхо auto: тогда оно определится."
    )


class EchoTwice(EchoDiffers):
    """The request came back a second time instead of a response: no unit's version is `01` (D1)."""

    what: ClassVar[Text] = Text(
        "The request came back twice and no response followed",
        "Посланное вернулось дважды, а ответа нет",
    )
    advice: Text = Text(
        "Likely, in order: the ignition is off, and a program between this one and the adapter, or "
        "a second adapter on the wire, returns what it gets, as the adapter does (switch one echo "
        "off); this is not a Mikas 5.4 / 7.1.",
        "Скорее всего, по порядку: выключено зажигание, а программа перед адаптером или второй "
        "адаптер на линии возвращает посланное так же, как и сам адаптер (отключите одно эхо); это "
        "не Микас 5.4 / 7.1.",
    )


class AnswersLate(LineError):
    """Each response comes after the time-out (D14). `wanted`: a sufficient one, in seconds."""

    what: ClassVar[Text] = Text(
        "The ECU answers {seconds:.2g} s after a request, later than the time-out of {limit:g} s",
        "Блок отвечает через {seconds:.2g} с после запроса, позже предела ожидания {limit:g} с",
    )
    advice: Text = Text("Set a time-out of {wanted:g} s.", "Задайте предел ожидания {wanted:g} с.")


class DamagedResponse(LineError):
    """The response's frame is damaged: checksum, cut short, or too long (§2)."""

    what: ClassVar[Text] = Text("The response is damaged: {damage}", "Ответ повреждён: {damage}")


class WrongLength(LineError):
    """A valid frame of a length that does not fit the request (D13)."""

    what: ClassVar[Text] = Text(
        "Bytes in the response: {length}; there should be {expected} for this request",
        "В ответе байтов: {length}; на этот запрос должно быть: {expected}",
    )


class WrongAddress(LineError):
    """A valid frame that repeats another address than the request's (D13)."""

    what: ClassVar[Text] = Text(
        "The response has address {got}, the request {asked}",
        "В ответе адрес {got}, а в запросе {asked}",
    )


class WrongContent(LineError):
    """A valid frame of the right length with invalid content (§3)."""

    what: ClassVar[Text] = Text("Invalid response: {problem}", "Недопустимый ответ: {problem}")


class LineNotQuiet(LineError):
    """Bytes keep coming without a request (D2, D12)."""

    what: ClassVar[Text] = Text(
        "The line does not become idle: something keeps sending",
        "Линия не освобождается: передача не прекращается",
    )
    advice: Text = Text(
        "Another tester on the wire, or a stream that the unit does not end: switch the ignition "
        "off for ten seconds and on again.",
        "На линии другой прибор, либо блок не прекращает поток: выключите зажигание на десять "
        "секунд и включите снова.",
    )


class SyncLost(LineError):
    """After a failed exchange the ECU could not be resynchronised (D13)."""

    what: ClassVar[Text] = Text(
        "Synchronisation with the ECU could not be restored after a failed exchange",
        "После сбоя обмена не удалось восстановить синхронизацию с блоком",
    )


class ReadingSuspended(LineError):
    """The program did not run for a while; what came meanwhile has no time and is dropped."""

    _MOVED = 1.0  # s that it takes to move the plug to another car, at least

    what: ClassVar[Text] = Text(
        "The program did not run for {seconds:.1f} s; what came meanwhile is left out, its time is "
        "unknown",
        "Программа не работала {seconds:.1f} с; принятое тем временем отброшено: неизвестно, когда "
        "оно пришло",
    )
    advice: Text = Text(
        "It was suspended (Ctrl-Z, a debugger), or the computer slept or was overloaded. Give a "
        "command that was cut off again.",
        "Её приостановили (Ctrl-Z, отладчик), либо компьютер спал или был перегружен. Прерванную "
        "команду повторите.",
    )

    @property
    def is_short(self) -> bool:
        """Whether the same unit must still be there, as when a computer is only busy.

        Such an exchange is repeated as after a damaged response.
        """
        seconds = self.fields["seconds"]
        return isinstance(seconds, int | float) and seconds < self._MOVED


class EcuRefused(MikasError):
    """The ECU refused the request, or does not know it."""


class WriteRefused(EcuRefused):
    """The ECU answered 01 to a write (§3)."""

    what: ClassVar[Text] = Text("The ECU refused the write", "Блок отверг запись")
    advice: Text = Text(
        "This unit does not allow this cell or parameter to be written; nothing was changed.",
        "Этот блок не разрешает запись этой ячейки или параметра; ничего не изменено.",
    )


class NotSupported(EcuRefused):
    """Unknown command or parameter: silence, or 01 where that can't be data (D10)."""

    what: ClassVar[Text] = Text("This ECU does not know {command}", "Этот блок не знает {command}")
    advice: Text = Text("Not every unit has every command.", "Не каждый блок знает все команды.")


class ListLost(NotSupported):
    """The unit refused to give its list (63), which was set before (§3)."""

    what: ClassVar[Text] = Text("The unit has no list now", "Сейчас в блоке нет списка")
    advice: Text = Text(
        "A unit may forget its list when its supply goes off: set the list again.",
        "При отключении питания блок может забыть список: задайте его заново.",
    )


class ReadBackDiffers(EcuRefused):
    """The write was accepted, but another value was read back."""

    what: ClassVar[Text] = Text(
        "{name}: {wanted} was written, {got} was read back",
        "{name}: записано {wanted}, прочитано {got}",
    )
    advice: Text = Text(
        "The cell may be read-only, or the unit's program changes it; read it again before you "
        "rely on it.",
        "Возможно, ячейка доступна только для чтения или её меняет программа блока; прочтите её "
        "ещё раз.",
    )


class NotConfirmed(MikasError):
    """A change that was not approved; nothing was sent."""

    what: ClassVar[Text] = Text(
        "Not confirmed, nothing was changed: {change}",
        "Не подтверждено, ничего не изменено: {change}",
    )
    advice: Text = Text("{how}", "{how}")
