"""What lies between this computer and the K-Line, and the words of errors that follow from it.

The texts of the error classes are for a cable on this computer. Over a network other causes are
likelier, and of a plug on USB there is none: `_OVER_NETWORK` has the advice.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from enum import Enum
from typing import Final, TypeVar

from mikas.errors import connection, exchange
from mikas.errors.base import AdviceTable, MikasError
from mikas.i18n import Text

E = TypeVar("E", bound=MikasError)


class PortKind(Enum):
    """What lies between this computer and the K-Line."""

    CABLE = "cable"
    """An adapter on this computer; a virtual or a replayed unit stands for one."""

    NETWORK = "network"
    """An adapter behind a bridge on Wi-Fi, or behind a program of another computer."""


_OVER_NETWORK: Final = AdviceTable(
    {
        connection.PortBusy: Text(
            "Likely, in order: another program or phone is connected to the bridge, which serves "
            "one at a time; an earlier connection broke off and still counts there. Close the "
            "other one, or restart the bridge, then try again.",
            "Скорее всего, по порядку: к мосту подключена другая программа или телефон, а он "
            "обслуживает одного; прежнее соединение оборвалось, но там ещё числится. Закройте "
            "другое или перезапустите мост и повторите.",
        ),
        connection.PortFailed: Text(
            "Check, in order: the host and the port number; that the bridge has power and this "
            "computer is in its Wi-Fi; that the program which shares the adapter is running.",
            "Проверьте по порядку: имя и порт; включён ли мост и в его ли сети Wi-Fi этот "
            "компьютер; запущена ли программа, которая раздаёт адаптер.",
        ),
        connection.LinkLost: Text(
            "Check, in order: that the bridge has power and is in reach of the Wi-Fi; that no "
            "other program or phone has taken its connection.",
            "Проверьте по порядку: включён ли мост и достаёт ли до него Wi-Fi; не заняла ли его "
            "соединение другая программа или телефон.",
        ),
        connection.ConnectionSilent: Text(
            "Check, in order: that the bridge has power and is in reach of "
            "the Wi-Fi; that no other program or phone has taken its connection; whether it "
            "carries nothing any more (restart it); the 12 V of the adapter behind it. With an "
            "adapter that returns no echo: the ignition is off.",
            "Проверьте по порядку: включён ли мост и достаёт ли до него "
            "Wi-Fi; не заняла ли его соединение другая программа или телефон; не завис ли он "
            "(перезапустите); есть ли 12 В на адаптере за ним. Если адаптер не возвращает эхо: "
            "выключено зажигание.",
        ),
        connection.LineFlooded: Text(
            "That is not the car. Likely, in order: this is another address; the bridge, or the "
            "program that shares the adapter, is out of order (restart it); the line is faster "
            "than {baud} baud (then name its rate in the port: ?baud=…).",
            "Это не машина. Скорее всего, по порядку: это другой адрес; неисправны мост или "
            "программа, которая раздаёт адаптер (перезапустите); линия быстрее {baud} бод (тогда "
            "укажите скорость в имени порта: ?baud=…).",
        ),
        connection.NoEcho: Text(
            "Likely, in order: the bridge has lost its Wi-Fi or its supply, or carries nothing any "
            "more (restart it); its serial port is not wired to the adapter, or not set to 9600 "
            "baud, 8N1; the adapter behind it has no 12 V; K-Line or ground is not connected; the "
            "network is slow. With an adapter that returns no echo: the ignition is off.",
            "Скорее всего, по порядку: мост потерял Wi-Fi или питание либо ничего не передаёт "
            "(перезапустите его); его последовательный порт не соединён с адаптером или настроен "
            "не на 9600 бод, 8N1; на адаптере за ним нет 12 В; не подключены K-Line или масса; "
            "медленная сеть. Если адаптер не возвращает эхо: выключено зажигание.",
        ),
        connection.EchoOnly: Text(
            "Likely, in order: the ignition is off; the bridge's serial port is not set to 9600 "
            "baud, 8N1 (the echo comes back at any rate); the K-Line wire goes to another unit or "
            "pin; the unit has no supply; it is not a Mikas 5.4 / 7.1. Switch the ignition on and "
            "try again.",
            "Скорее всего, по порядку: выключено зажигание; последовательный порт моста настроен "
            "не на 9600 бод, 8N1 (эхо приходит при любой скорости); провод K-Line идёт к другому "
            "блоку или выводу; нет питания блока; это не Микас 5.4 / 7.1. Включите зажигание и "
            "повторите.",
        ),
        connection.NotAKLineAdapter: Text(
            "An ELM327 interprets the bytes it gets and can't carry this protocol, over Wi-Fi "
            "neither. Use a plain bridge (ser2net, an ESP8266 in transparent mode) with a K-Line "
            "adapter behind it, or a KKL cable on this computer.",
            "ELM327 сам обрабатывает посланные байты и этот протокол передать не может, по Wi-Fi "
            "тоже. Нужен простой мост (ser2net, ESP8266 в прозрачном режиме) с адаптером K-Line за "
            "ним или кабель KKL на этом компьютере.",
        ),
        exchange.LineError: Text(
            "Likely, in order: the bridge's Wi-Fi is weak; the bridge holds bytes back to pack "
            "them (set its packing time to the shortest); its serial port is not set to 9600 baud, "
            "8N1; ground or plug of the adapter behind it.",
            "Скорее всего, по порядку: слабый Wi-Fi у моста; мост задерживает байты, собирая их в "
            "пакеты (задайте самое короткое время сборки); его последовательный порт настроен не "
            "на 9600 бод, 8N1; масса или разъём адаптера за ним.",
        ),
        exchange.NoResponse: Text(
            "Likely, in order: this unit does not know the command; the bridge's Wi-Fi is weak or "
            "gone; the ignition went off; the line behind the bridge is bad (ground and plug of "
            "the adapter).",
            "Скорее всего, по порядку: блок не знает этой команды; слабый или пропавший Wi-Fi у "
            "моста; выключилось зажигание; плохая линия за мостом (масса и разъём адаптера).",
        ),
        exchange.EchoDiffers: Text(
            "Likely, in order: another program or phone is connected to the same bridge; the "
            "bridge changes bytes (set it to raw or transparent, not to telnet, without conversion "
            "of line ends); its serial port is not set to 9600 baud, 8N1; another tester or unit "
            "is sending on the same wire; a bad ground.",
            "Скорее всего, по порядку: к тому же мосту подключена другая программа или телефон; "
            "мост изменяет байты (нужен режим raw или transparent, не telnet, без замены концов "
            "строк); его последовательный порт настроен не на 9600 бод, 8N1; на той же линии "
            "передаёт другой прибор или блок; плохая масса.",
        ),
        exchange.EchoTwice: Text(
            "Likely, in order: the bridge or a program before it returns what it gets, as the "
            "adapter does (switch one echo off), and the ignition is off; this is not a Mikas 5.4 "
            "/ 7.1.",
            "Скорее всего, по порядку: мост или программа перед ним возвращает посланное так же, "
            "как и адаптер (отключите одно эхо), и выключено зажигание; это не Микас 5.4 / 7.1.",
        ),
        exchange.LineNotQuiet: Text(
            "Likely, in order: another program or phone sends through the same bridge; another "
            "tester is on the wire; the unit does not end a stream: switch the ignition off for "
            "ten seconds and on again.",
            "Скорее всего, по порядку: через тот же мост передаёт другая программа или телефон; на "
            "линии другой прибор; блок не прекращает поток: выключите зажигание на десять секунд "
            "и включите снова.",
        ),
    }
)

_LOST: Final = Text(
    "The connection to {url} is lost: {problem}", "Связь с {url} потеряна: {problem}"
)


def met_on(kind: PortKind, error: E) -> E:
    """Give `error` the words for this kind of port; advice that was given for this case stays."""
    if kind is PortKind.NETWORK:
        error.is_over_network = True
        advice = _OVER_NETWORK.entry(type(error))
        # What a lower layer has chosen by the other end's words is better.
        is_untouched = error.advice == type(error).advice.filled(**error.fields)
        if advice is not None and error.has_class_advice and is_untouched:
            error.use_class_advice(advice)
        if error.kind is connection.LinkLost:
            error.reason = _LOST.filled(**error.fields)
    return error


@contextmanager
def errors_met_on(kind: PortKind) -> Iterator[None]:
    """Give the errors that are raised inside the words for this kind of port."""
    try:
        yield
    except MikasError as error:
        met_on(kind, error)
        raise
