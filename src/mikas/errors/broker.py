"""No connection to an MQTT broker. No message has a password."""

from __future__ import annotations

from mikas.errors.connection import NoConnection
from mikas.i18n import Text


class NoBroker(NoConnection):
    """No connection to the MQTT broker `url`."""

    advice = Text(
        "Check that the broker runs and that the network works.",
        "Проверьте, работает ли брокер и есть ли сеть.",
    )


class BrokerNotFound(NoBroker):
    """The name of the broker's computer is unknown."""

    what = Text(
        "The computer of the MQTT broker {url} is not found: its name is unknown in this network",
        "Компьютер с брокером MQTT {url} не найден: такого имени в сети нет",
    )
    advice = Text(
        "Check the name, or write the address in numbers, like mqtt://192.168.1.10; a name that "
        "ends in .local needs mDNS (avahi) on this computer.",
        "Проверьте имя или укажите адрес числами: mqtt://192.168.1.10; для имени с .local на этом "
        "компьютере нужен mDNS (avahi).",
    )


class BrokerUnreachable(NoBroker):
    """No MQTT broker answers at the address. `problem`: what happened instead."""

    what = Text(
        "No MQTT broker answers at {url}: {problem}",
        "По адресу {url} брокер MQTT не отвечает: {problem}",
    )
    advice = Text(
        "Likely, in order: the broker does not run; it listens to its own computer only (Mosquitto "
        "needs the line `listener 1883` for others); another port (usual are 1883, and 8883 with "
        "mqtts://); a firewall.",
        "Скорее всего, по порядку: брокер не запущен; он слушает только свой компьютер (для других "
        "Mosquitto нужна строка `listener 1883`); другой порт (обычно 1883, а с mqtts:// 8883); "
        "мешает брандмауэр.",
    )


class BrokerRefused(NoBroker):
    """The broker answered, and does not let this client in. `problem`: its reason."""

    what = Text(
        "The MQTT broker {url} refuses the connection: {problem}",
        "Брокер MQTT {url} отказывает в соединении: {problem}",
    )
    advice = Text(
        "Check user name and password, and that the broker knows this user.",
        "Проверьте имя и пароль и заведён ли такой пользователь на брокере.",
    )


class BrokerNotTrusted(NoBroker):
    """The broker's certificate can't be verified. `problem`: why."""

    what = Text(
        "The certificate of the MQTT broker {url} is not trusted: {problem}",
        "Сертификату брокера MQTT {url} нет доверия: {problem}",
    )
    advice = Text(
        "Likely, in order: the broker's certificate authority is your own, and has to be named; "
        "the certificate is for another name than the address says; it has expired; the clock of "
        "this computer is wrong.",
        "Скорее всего, по порядку: центр сертификации у вас свой, и его нужно указать; сертификат "
        "выдан на другое имя, чем в адресе; он просрочен; неверны часы этого компьютера.",
    )


class BrokerLost(NoBroker):
    """The connection to the broker broke off. `problem`: how."""

    what = Text(
        "The connection to the MQTT broker {url} is lost: {problem}",
        "Связь с брокером MQTT {url} потеряна: {problem}",
    )
