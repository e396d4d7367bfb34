"""The ECU is there, but the exchange was spoilt (§2, D12–D14)."""

from __future__ import annotations

from mikas.errors.base import MikasError
from mikas.i18n import Text


class LineError(MikasError):
    """The ECU was there, but this exchange was spoilt, and repeating it did not help."""

    advice = Text(
        "Check ground and plug of the adapter, keep its cable away from the ignition leads; "
        "`mikas doctor` looks at the line step by step.",
        "Проверьте массу и разъём адаптера, отведите кабель от высоковольтных проводов; "
        "`mikas doctor` проверит линию по шагам.",
    )
    advice_on_screen = Text(
        "Check ground and plug of the adapter, keep its cable away from the ignition leads.",
        "Проверьте массу и разъём адаптера, отведите кабель от высоковольтных проводов.",
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
    advice_on_screen = Text(
        "Either this unit does not know the command (the Passport screen shows what it knows), or "
        "the ignition went off, or the line is bad (check ground and plug of the adapter).",
        "Либо блок не знает этой команды (что он знает, показывает экран «Паспорт»), либо "
        "выключилось зажигание, либо плоха линия (проверьте массу и разъём адаптера).",
    )


class EngineStopped(NoResponse):
    """A stream by strokes is silent, and the unit says that there are none (D15)."""

    what = Text(
        "No stroke for {seconds:g} s: the engine stands",
        "Тактов нет {seconds:g} с: двигатель не вращается",
    )
    advice = Text(
        "A stream by strokes comes only while the engine turns: start it, or take another method.",
        "Поток по тактам идёт, только пока двигатель вращается: запустите его или возьмите другой "
        "способ.",
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
    advice_on_screen = Text(
        "Likely, in order: another tester or unit talks on the same wire; a bad ground; a wrong "
        "baud rate. Disconnect other devices and try again.",
        "Скорее всего, по порядку: на том же проводе говорит другой прибор или блок; плохая масса; "
        "неверная скорость. Отключите остальные приборы и повторите.",
    )


class DamagedResponse(LineError):
    """The response's frame is damaged: checksum, cut short, or too long (§2)."""

    what = Text("The response came damaged: {damage}", "Ответ пришёл с повреждением: {damage}")


class WrongLength(LineError):
    """A sound frame of a length that does not fit the request (D13)."""

    what = Text(
        "Bytes in the response: {length}; there should be {expected} for this request",
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


class SyncLost(LineError):
    """After a failed exchange the ECU could not be brought back in step (D13)."""

    what = Text(
        "The ECU could not be brought back in step after a spoilt exchange",
        "После сбоя обмена не удалось снова согласоваться с блоком",
    )
