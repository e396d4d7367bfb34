"""Why a port of the browser does not open, in words, and what to do.

`refused` is the name of JavaScript's error: the browser's own, or one of the drivers for WebUSB
(`web/src/site/usb`), which know more: who has the device, which rate the chip makes, whether it is
the chip that it says.
"""

from __future__ import annotations

from typing import Final

from mikas.errors import PortFailed
from mikas.i18n import Text
from mikas.link.base import BAUD
from mikas.link.ports import Port

WEB_USB: Final = "webusb"
"""The scheme of a port whose driver is the page's."""
_FTDI: Final = 0x0403

_HANGS = Text("the browser neither opens nor closes it", "браузер его не открывает и не закрывает")
_UNPLUG = Text(
    "The adapter or its driver hangs: unplug it and plug it in again. If that does not help, close "
    "all windows of the browser and open this page again.",
    "Завис адаптер или его драйвер: отключите адаптер и подключите снова. Если не поможет, "
    "закройте все окна браузера и откройте эту страницу снова.",
)
_WITHOUT_REASON = Text("the browser gives no reason", "браузер не сообщил причину")
_OPEN_HERE = Text("this page has it open already", "он уже открыт этой же страницей")
_RELOAD = Text("Reload the page, then connect again.", "Обновите страницу и подключитесь снова.")
_LIKELY = Text(
    "Likely, in order: another tab or window of this page, another diagnostics program, a terminal "
    "or ModemManager has it open: close that. On Linux without permission: "
    "sudo usermod -aG dialout $USER, then log out and in again. If nothing has it open, unplug the "
    "adapter and plug it in again.",
    "Скорее всего, по порядку: порт открыт в другой вкладке или в другом окне этой страницы, в "
    "программе диагностики, в терминале или у ModemManager — закройте их. В Linux без прав: "
    "sudo usermod -aG dialout $USER, затем выйти из системы и войти снова. Если порт никем не "
    "открыт, отключите адаптер и подключите снова.",
)
_NO_DEVICE = Text(
    "the phone does not let the browser open it", "телефон не даёт браузеру его открыть"
)
_ALLOW = Text(
    "Unplug the cable and plug it in again, and answer OK when the phone asks whether the browser "
    "may use it. If another app opens by itself, close that app, and do not choose “always”.",
    "Отключите кабель, подключите снова и ответьте «ОК», когда телефон спросит, можно ли браузеру "
    "им пользоваться. Если сама открывается другая программа, закройте её и не выбирайте «всегда».",
)
_NO_POWER = Text(
    "Plug the cable and the OTG plug in again, firmly. Not through a hub: many phones give it too "
    "little power. Some switch OTG off by themselves: switch it on in the settings. Close other "
    "diagnostics apps. A phone with little charge may give no power: charge it first.",
    "Вставьте кабель и переходник OTG заново, до упора. Не через хаб: многие телефоны дают ему "
    "мало тока. Некоторые сами выключают OTG: включите его в настройках. Закройте другие программы "
    "диагностики. Разряженный телефон может не питать кабель: сначала зарядите его.",
)
_GONE = Text(
    "the browser can't open it: it may be unplugged, without power, or in use by another app",
    "браузер не может его открыть: он отключился, остался без питания или занят другой программой",
)
_CLOSE_OTHERS = Text(
    "Close other diagnostics apps, then unplug the cable and plug it in again; if the phone offers "
    "another app for it, refuse.",
    "Закройте другие программы диагностики, затем отключите кабель и подключите снова; если "
    "телефон предложит открыть другую программу, откажитесь.",
)
_OTHER_CHIP = Text(
    "Take a cable with another chip: FT232R and CH340 are known here.",
    "Возьмите кабель с другой микросхемой: FT232R и CH340 здесь известны.",
)
_COPY = Text(
    "Unplug the cable and plug it in again. If that does not help, its chip is faulty or a bad "
    "copy: take another cable, best with an FT232R.",
    "Отключите кабель и подключите снова. Если не поможет, микросхема неисправна или это плохая "
    "копия: возьмите другой кабель, лучше с FT232R.",
)


def refusal(url: str, port: Port, baud: int, refused: str, message: str) -> PortFailed:
    """Return the error of a port that did not open: `refused`, `message` as JavaScript has them."""
    chip = port.description
    is_usb = port.url.startswith(f"{WEB_USB}:")
    match refused:
        case "NetworkError" | "SecurityError" | "NotFoundError" if is_usb:
            denied = refused == "SecurityError"
            problem, advice = (_NO_DEVICE, _ALLOW) if denied else (_GONE, _NO_POWER)
        case "NetworkError":
            problem, advice = _WITHOUT_REASON, _LIKELY
        case "InvalidStateError":
            problem, advice = _OPEN_HERE, _RELOAD
        case "TimeoutError":
            problem, advice = _HANGS, _UNPLUG
        case "ClaimError":
            problem, advice = _held(chip), _release(port)
        case "RateError":
            problem, advice = _other_rate(chip, baud, message), _other_cable(baud)
        case "NotSupportedError":
            problem, advice = _unknown(chip, message), _OTHER_CHIP
        case "ChipError":
            problem, advice = _refuses(chip, message), _COPY
        case _:
            return PortFailed(url=url, problem=Text(message, message))
    return PortFailed(url=url, problem=problem, advice=advice)


def _held(chip: str) -> Text:
    return Text(
        f"the cable's {chip} is in use: another app has it, or the phone's system by a driver of "
        "its own",
        f"{chip} кабеля занята: её держит другая программа или сама система телефона своим "
        "драйвером",
    )


def _release(port: Port) -> Text:
    """Return what to do where another has the device: Chrome takes only some from the system."""
    if port.vid == _FTDI:
        return _CLOSE_OTHERS
    return Text(
        f"{_CLOSE_OTHERS.en} Still in use? Then this phone's system has a driver for that chip, "
        "and the browser can't take it away. A cable with an FT232R will do: that chip the browser "
        "does take over.",
        f"{_CLOSE_OTHERS.ru} Всё равно занята? Значит, в системе этого телефона есть драйвер такой "
        "микросхемы, и браузер не может её забрать. Подойдёт кабель с FT232R: эту микросхему "
        "браузер забирает.",
    )


def _other_rate(chip: str, baud: int, made: str) -> Text:
    return Text(
        f"the cable's {chip} can't do {baud} bit/s: it would make {made} of it",
        f"{chip} кабеля не умеет {baud} бит/с: вместо этого она включит {made}",
    )


def _other_cable(baud: int) -> Text:
    return Text(
        f"For {baud} bit/s take a cable with an FT232R or CH340. A Mikas unit speaks at {BAUD}: "
        "without baud=… that is what is set.",
        f"Для {baud} бит/с возьмите кабель с FT232R или CH340. Блок Микас говорит на {BAUD}: без "
        "baud=… ставится эта скорость.",
    )


def _unknown(chip: str, message: str) -> Text:
    return Text(
        f"this kind of {chip} is not known here, or can't do that ({message})",
        f"такая {chip} здесь неизвестна или не умеет этого ({message})",
    )


def _refuses(chip: str, message: str) -> Text:
    return Text(
        f"the cable's {chip} does not do what such a chip does ({message})",
        f"{chip} кабеля ведёт себя не как такая микросхема ({message})",
    )
