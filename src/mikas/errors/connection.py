"""No connection: no port, no echo, no ECU (D1), no MQTT broker."""

from __future__ import annotations

import errno
from collections.abc import Mapping
from types import MappingProxyType
from typing import ClassVar

from mikas.errors.base import MikasError
from mikas.i18n import Text


class NoConnection(MikasError, ConnectionError):
    """No port, no adapter or no ECU. `url`: the port's, also where no text has it."""

    more_fields: ClassVar[frozenset[str]] = frozenset({"url"})


class PortNotFound(NoConnection, FileNotFoundError):
    """No such port, or no adapter at all."""

    what: ClassVar[Text] = Text("There is no port {url}", "Порта {url} нет")
    advice: Text = Text(
        "Found: {found}. Is the adapter plugged in?", "Найдены: {found}. Адаптер подключён?"
    )


class NoPortGiven(PortNotFound):
    """No port was named and not exactly one likely adapter is plugged in. `example`: a port."""

    what: ClassVar[Text] = Text(
        "No port was named, and there is not exactly one likely adapter",
        "Порт не указан, а подходящих адаптеров нет или больше одного",
    )
    advice: Text = Text(
        "Found: {found}. Plug the adapter in, or name its port.",
        "Найдены: {found}. Подключите адаптер или укажите его порт.",
    )
    defaults: ClassVar[Mapping[str, object]] = MappingProxyType({"example": "/dev/ttyUSB0"})


class AnotherAdapter(PortNotFound):
    """The adapter is away, and its port's name or its kind is another adapter's."""

    what: ClassVar[Text] = Text("The adapter is gone: {problem}", "Адаптера нет: {problem}")
    advice: Text = Text(
        "Plug the right one in again, into the same USB socket if you can: it is found under any "
        "name. To use another one, connect anew.",
        "Подключите прежний адаптер, лучше в то же гнездо USB: он найдётся под любым именем. Чтобы "
        "работать с другим, соединитесь заново.",
    )


class AdapterTaken(PortNotFound):
    """The adapter is plugged in, and a program has taken it from its driver. `chip`, `holder`."""

    what: ClassVar[Text] = Text(
        "The adapter ({chip}) is plugged in but has no port: it is in use by {holder}",
        "Адаптер ({chip}) подключён, но порта у него нет: он занят {holder}",
    )
    advice: Text = Text(
        "A virtual machine, or a program that reads USB itself? Release it there, unplug the "
        "adapter and plug it in again.",
        "Виртуальная машина или программа, которая сама читает USB? Освободите адаптер там, "
        "отключите его и подключите снова.",
    )


class TakenByBrltty(AdapterTaken):
    """brltty has taken the adapter, as braille displays have the same chips. `chip`."""

    what: ClassVar[Text] = Text(
        "The adapter ({chip}) is plugged in but has no port: brltty, the program for braille "
        "displays, has taken it",
        "Адаптер ({chip}) подключён, но порта у него нет: его забрала программа brltty (для "
        "дисплеев Брайля)",
    )
    advice: Text = Text(
        "The udev rules of mikas keep brltty off these chips; without a braille display, you can "
        "uninstall brltty instead. Then unplug the adapter and plug it in again.",
        "Правила udev от mikas запрещают brltty эти микросхемы; без дисплея Брайля можно и удалить "
        "brltty. Затем отключите адаптер и подключите снова.",
    )


class AdapterWithoutDriver(PortNotFound):
    """The adapter is plugged in, and no driver serves it. `chip`."""

    what: ClassVar[Text] = Text(
        "The adapter ({chip}) is plugged in but has no port: no driver serves it",
        "Адаптер ({chip}) подключён, но порта у него нет: его не обслуживает ни один драйвер",
    )
    advice: Text = Text(
        "Unplug it and plug it in again. If it stays so, this system lacks the driver of the chip.",
        "Отключите его и подключите снова. Если не поможет, в системе нет драйвера микросхемы.",
    )


class PortBusy(NoConnection):
    """Another program has the port open. `holder`: the program, if known."""

    number: ClassVar[int | None] = errno.EBUSY

    what: ClassVar[Text] = Text("Port {url} is in use by {holder}", "Порт {url} занят {holder}")
    advice: Text = Text(
        "Likely: another window of mikas or its dashboard, another diagnostics program, a terminal "
        "or ModemManager. Close it, then try again.",
        "Скорее всего, это другое окно mikas или его панель, другая программа диагностики, "
        "терминал или ModemManager. Закройте и повторите.",
    )
    defaults: ClassVar[Mapping[str, object]] = MappingProxyType(
        {"holder": Text("another program", "другой программой")}
    )


class PortProbed(PortBusy):
    """ModemManager has the port open, and looks for a modem there."""

    advice: Text = Text(
        "It looks for a modem in each new port, with bytes of its own on the line. Try again in "
        "half a minute; the udev rules of mikas keep it off for good.",
        "Он ищет модем в каждом новом порту и шлёт при этом свои байты в линию. Повторите через "
        "полминуты; правила udev от mikas запрещают ему адаптеры насовсем.",
    )


class PortDenied(NoConnection, PermissionError):
    """The user has no permission to open the port."""

    what: ClassVar[Text] = Text("No permission to open {url}", "Нет прав на открытие {url}")
    advice: Text = Text(
        "On Linux: sudo usermod -aG dialout $USER, then log out and in again.",
        "В Linux: sudo usermod -aG dialout $USER, затем выйти из системы и войти снова.",
    )


class PortFailed(NoConnection):
    """The port could not be opened for another reason, given in the system's own words."""

    what: ClassVar[Text] = Text(
        "Port {url} could not be opened: {problem}", "Порт {url} не открылся: {problem}"
    )
    advice: Text = Text(
        "Unplug the adapter and plug it in again.", "Отключите адаптер и подключите снова."
    )


class LinkLost(NoConnection):
    """The adapter disconnected while in use: `LinkLost(url="mine:", problem="closed")`."""

    what: ClassVar[Text] = Text(
        "The adapter on {url} is gone: {problem}", "Адаптер на {url} пропал: {problem}"
    )
    advice: Text = Text("Check the USB plug and its cable.", "Проверьте разъём USB и кабель.")


class LinkClosed(LinkLost):
    """This program has closed the connection, and used it afterwards."""

    what: ClassVar[Text] = Text("The connection to {url} is closed", "Соединение с {url} закрыто")
    advice: Text = Text("Connect again.", "Соединитесь снова.")


class ConnectionSilent(LinkLost, TimeoutError):
    """Not one byte came through a network for `seconds`, although something was sent."""

    what: ClassVar[Text] = Text(
        "Nothing has come from {url} for {seconds} s, not even an echo: the connection counts as "
        "dead",
        "От {url} за {seconds} с не пришло ничего, даже эха: связь считается потерянной",
    )
    advice: Text = Text(
        "Check the network, and the other end of the connection.",
        "Проверьте сеть и другой конец соединения.",
    )


class PortTaken(PortBusy, LinkLost):
    """The other end of a network port says that another client has it. `holder`: its words."""


class OtherService(LinkLost):
    """Another service answers at the network port `url`. `service`; `said`: its words, if any."""

    what: ClassVar[Text] = Text(
        "At {url} there is no serial port, but {service}{said}",
        "По адресу {url} не последовательный порт, а {service}{said}",
    )
    advice: Text = Text("Check the host and the port number.", "Проверьте адрес и номер порта.")


class LineFlooded(LinkLost):
    """More bytes arrived than a line of that baud rate carries. `rate`, `most`: bytes a second."""

    what: ClassVar[Text] = Text(
        "The adapter on {url} sends {rate} bytes a second: a line of {baud} baud carries {most} at "
        "most",
        "Адаптер на {url} шлёт {rate} байт в секунду: линия на {baud} бод пропускает не больше "
        "{most}",
    )
    advice: Text = Text(
        "That is not the car. Likely, in order: this is another port or another address; the "
        "program that shares the adapter, or the adapter itself, is out of order (restart it, or "
        "unplug it and plug it in again); the line is faster than {baud} baud (then name its rate "
        "in the port: ?baud=…).",
        "Это не машина. Скорее всего, по порядку: это другой порт или другой адрес; неисправна "
        "программа, которая раздаёт адаптер, или сам адаптер (перезапустите её, отключите и снова "
        "подключите его); линия быстрее {baud} бод (тогда укажите скорость в имени порта: "
        "?baud=…).",
    )


class RecordingOver(LinkLost):
    """The recording played through `replay:` has ended; waiting is useless."""

    what: ClassVar[Text] = Text("The recording {file} is over", "Запись {file} закончилась")
    advice: Text = Text(
        "Connect again to play it from the beginning.",
        "Чтобы воспроизвести её сначала, соединитесь снова.",
    )


class NoEcho(NoConnection, TimeoutError):
    """Nothing came back, not even the adapter's echo (D1)."""

    what: ClassVar[Text] = Text(
        "Nothing came back, not even the echo of what was sent",
        "Не принято ничего, даже эха посланного",
    )
    advice: Text = Text(
        "Likely, in order: the adapter has no 12 V (it is fed from the car's diagnostic socket); "
        "K-Line or ground is not connected; this is another port. With an adapter that returns no "
        "echo: the ignition is off.",
        "Скорее всего, по порядку: на адаптере нет 12 В (он питается от диагностической колодки); "
        "не подключены K-Line или масса; это другой порт. Если адаптер не возвращает эхо: "
        "выключено зажигание.",
    )


class EchoOnly(NoConnection, TimeoutError):
    """The echo came back, the ECU did not answer (D1)."""

    what: ClassVar[Text] = Text(
        "The adapter works (its echo came back), but the ECU does not answer",
        "Адаптер работает (эхо пришло), но блок не отвечает",
    )
    advice: Text = Text(
        "Likely, in order: the ignition is off; the K-Line wire goes to another unit or pin; the "
        "unit has no supply; it is not a Mikas 5.4 / 7.1. Switch the ignition on and try again.",
        "Скорее всего, по порядку: выключено зажигание; провод K-Line идёт к другому блоку или "
        "выводу; нет питания блока; это не Микас 5.4 / 7.1. Включите зажигание и повторите.",
    )


class NotAKLineAdapter(NoConnection):
    """An ELM327, or another adapter with a command interpreter, answered."""

    what: ClassVar[Text] = Text(
        "The adapter on this port is an ELM327 (or similar), not a plain K-Line adapter",
        "На этом порту ELM327 (или подобный), а не простой адаптер K-Line",
    )
    advice: Text = Text(
        "An ELM327 interprets the bytes it gets and can't carry this protocol. Use a KKL adapter "
        "(a “VAG-COM 409” cable with FT232 or CH340).",
        "ELM327 сам обрабатывает посланные байты и этот протокол передать не может. Нужен адаптер "
        "KKL (кабель «VAG-COM 409» на FT232 или CH340).",
    )


# The brokers of MQTT. No message has a password.


class NoBroker(NoConnection):
    """No connection to the MQTT broker `url`."""

    advice: Text = Text(
        "Check that the broker runs and that the network works.",
        "Проверьте, работает ли брокер и есть ли сеть.",
    )


class BrokerNotFound(NoBroker):
    """The name of the broker's computer is unknown."""

    what: ClassVar[Text] = Text(
        "The computer of the MQTT broker {url} is not found: its name is unknown in this network",
        "Компьютер с брокером MQTT {url} не найден: такого имени в сети нет",
    )
    advice: Text = Text(
        "Check the name, or write the address in numbers, like mqtt://192.168.1.10; a name that "
        "ends in .local needs mDNS (avahi) on this computer.",
        "Проверьте имя или укажите адрес числами: mqtt://192.168.1.10; для имени с .local на этом "
        "компьютере нужен mDNS (avahi).",
    )


class BrokerUnreachable(NoBroker):
    """No MQTT broker answers at the address. `problem`: what happened instead."""

    what: ClassVar[Text] = Text(
        "No MQTT broker answers at {url}: {problem}",
        "По адресу {url} брокер MQTT не отвечает: {problem}",
    )
    advice: Text = Text(
        "Likely, in order: the broker does not run; it listens to its own computer only (Mosquitto "
        "needs the line `listener 1883` for others); another port (usual are 1883, and 8883 with "
        "mqtts://); a firewall.",
        "Скорее всего, по порядку: брокер не запущен; он слушает только свой компьютер (для других "
        "Mosquitto нужна строка `listener 1883`); другой порт (обычно 1883, а с mqtts:// 8883); "
        "мешает брандмауэр.",
    )


class BrokerRefused(NoBroker):
    """The broker answered, and does not let this client in. `problem`: its reason."""

    what: ClassVar[Text] = Text(
        "The MQTT broker {url} refuses the connection: {problem}",
        "Брокер MQTT {url} отказывает в соединении: {problem}",
    )
    advice: Text = Text(
        "Check user name and password, and that the broker knows this user.",
        "Проверьте имя и пароль и заведён ли такой пользователь на брокере.",
    )


class BrokerNotTrusted(NoBroker):
    """The broker's certificate can't be verified. `problem`: why."""

    what: ClassVar[Text] = Text(
        "The certificate of the MQTT broker {url} is not trusted: {problem}",
        "Сертификату брокера MQTT {url} нет доверия: {problem}",
    )
    advice: Text = Text(
        "Likely, in order: the broker's certificate authority is your own, and has to be named; "
        "the certificate is for another name than the address says; it has expired; the clock of "
        "this computer is wrong.",
        "Скорее всего, по порядку: центр сертификации у вас свой, и его нужно указать; сертификат "
        "выдан на другое имя, чем в адресе; он просрочен; неверны часы этого компьютера.",
    )


class BrokerLost(NoBroker):
    """The connection to the broker broke off. `problem`: how."""

    what: ClassVar[Text] = Text(
        "The connection to the MQTT broker {url} is lost: {problem}",
        "Связь с брокером MQTT {url} потеряна: {problem}",
    )
