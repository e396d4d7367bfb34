"""The error of a connection to the broker, by what the system and the client library report."""

from __future__ import annotations

import errno
import re
import socket
import ssl
from typing import TYPE_CHECKING, Final

from mikas import errors
from mikas.errors.system import NEEDS_INTERFACE
from mikas.i18n import Text

if TYPE_CHECKING:
    from aiomqtt import MqttError

_NO_LISTENER: Final = Text("nothing listens at this port there", "этот порт там никто не слушает")
_NO_ANSWER: Final = Text("no answer within seconds", "нет ответа несколько секунд")
_NOT_MQTT: Final = Text(
    "it takes the connection, and does not answer as a broker does (a port with TLS, to be written "
    "mqtts://, or another program)",
    "соединение принято, но ответ — не брокера (порт с TLS, его адрес пишется mqtts://, или другая "
    "программа)",
)
_OTHER_PROGRAM: Final = Text(
    "another program answers there, with “{words}”: check the port",
    "там отвечает другая программа: «{words}»; проверьте порт",
)
_NOT_TLS: Final = Text(
    "it does not speak TLS there (without TLS the address begins with mqtt://)",
    "там нет TLS (без TLS адрес начинается с mqtt://)",
)
_TLS_REFUSED: Final = Text(
    "it does not accept our TLS: {words} (it may demand a certificate of ours)",
    "ему не подходит наш TLS: {words} (возможно, он требует от нас сертификат)",
)
_NO_TRUST: Final = {
    10: Text("it has expired", "срок его действия истёк"),
    9: Text("it is not valid yet", "срок его действия ещё не начался"),
    18: Text("the broker has signed it itself", "брокер подписал его сам"),
    19: Text("its authority is unknown here", "его центр сертификации здесь неизвестен"),
    20: Text("its authority is unknown here", "его центр сертификации здесь неизвестен"),
    62: Text("it is for another name", "он выдан на другое имя"),
    64: Text("it is for another address", "он выдан на другой адрес"),
}
"""By OpenSSL's number of a failed verification."""
_STRICT: Final = range(79, 94)
"""OpenSSL's numbers for certificates that are not made as RFC 5280 demands: Python verifies so from
3.13 on. The commonest is an authority of one's own without a key usage."""
_NOT_STRICT: Final = Text(
    "the certificates are not made as Python demands from 3.13 on ({words}): make your own "
    "authority anew with the key usage keyCertSign, and the broker's certificate with the key "
    "identifiers, as docs/how-to/mqtt.md shows",
    "сертификаты сделаны не так, как требует Python начиная с 3.13 ({words}): создайте свой центр "
    "сертификации заново с назначением ключа keyCertSign, а сертификат брокера — с "
    "идентификаторами ключей, как показано в docs/ru/how-to/mqtt.md",
)
_REFUSALS: Final = {
    132: Text("it does not speak MQTT 3.1.1", "он не знает MQTT 3.1.1"),
    133: Text("the client id is not allowed", "такой идентификатор клиента не разрешён"),
    134: Text("wrong user name or password", "неверное имя или пароль"),
    135: Text("not authorized", "нет доступа"),
    136: Text("it is not ready", "он не готов к работе"),
}
"""By the reason code that the client library makes of the broker's return code."""
_OF_THE_USER: Final = (134, 135)
_OF_THE_BROKER: Final = Text(
    "Check the broker's settings; its log says more.",
    "Проверьте настройки брокера; подробности — в его журнале.",
)
_SAME_CLIENT: Final = Text(
    "That is so each time: does another program publish under the same topic? The broker lets in "
    "one client of a name.",
    "Так каждый раз: не публикует ли в ту же тему другая программа? Клиента с одним именем брокер "
    "пускает только одного.",
)
_LEFT: Final = Text(
    "it sends more than a broker has to send here, or anything but MQTT, and was disconnected",
    "он шлёт больше, чем положено брокеру, или не MQTT, и потому отключён",
)
CLOSED: Final = Text("the broker has closed it", "её закрыл брокер")


def connecting_failed(url: str, error: MqttError | OSError | UnicodeError) -> errors.NoBroker:
    """Return the error of a connection that did not come about."""
    from aiomqtt import MqttCodeError
    from paho.mqtt.reasoncodes import ReasonCode

    from mikas.publish.client import NoWelcome

    if isinstance(error, MqttCodeError):
        code = error.rc.value if isinstance(error.rc, ReasonCode) else error.rc or 0
        words = str(error)
        advice = None if code in _OF_THE_USER else _OF_THE_BROKER
        problem = _REFUSALS.get(code, Text(words, words))
        return errors.BrokerRefused(url=url, problem=problem, advice=advice)
    match cause := error if isinstance(error, OSError | UnicodeError) else error.__context__:
        case NoWelcome(words=words) if words:
            return errors.BrokerUnreachable(url=url, problem=_OTHER_PROGRAM.filled(words=words))
        case ssl.SSLCertVerificationError():
            words = cause.verify_message
            problem = _NO_TRUST.get(cause.verify_code, Text(words, words))
            if cause.verify_code in _STRICT:
                problem = _NOT_STRICT.filled(words=words)
            return errors.BrokerNotTrusted(url=url, problem=problem)
        case ssl.SSLError():
            if "ALERT" in (cause.reason or ""):
                words = (cause.reason or "").replace("_", " ").lower()
                problem = _TLS_REFUSED.filled(words=words)
                return errors.BrokerRefused(url=url, problem=problem, advice=_OF_THE_BROKER)
            return errors.BrokerUnreachable(url=url, problem=_NOT_TLS)
        case socket.gaierror() | UnicodeError():  # a name that no computer can have
            return errors.BrokerNotFound(url=url)
        case ConnectionRefusedError():
            return errors.BrokerUnreachable(url=url, problem=_NO_LISTENER)
        case ConnectionResetError() | BrokenPipeError() | NoWelcome():
            return errors.BrokerUnreachable(url=url, problem=_NOT_MQTT)
        case OSError() if cause.errno is not None:
            is_local = cause.errno == errno.EINVAL
            problem = NEEDS_INTERFACE if is_local else errors.reason_of(cause)
            return errors.BrokerUnreachable(url=url, problem=problem)
        case OSError():  # a time-out has no number
            return errors.BrokerUnreachable(url=url, problem=_NO_ANSWER)
    return errors.BrokerUnreachable(url=url, problem=_NOT_MQTT)


def left(url: str, *, reached: bool) -> errors.NoBroker:
    """Return the error of a broker that was left because of what it sent."""
    kind = errors.BrokerLost if reached else errors.BrokerUnreachable
    return kind(url=url, problem=_LEFT)


def connection_lost(url: str, error: Exception, *, again: bool) -> errors.BrokerLost:
    """Return the error of a connection that broke off. `again`: as the ones before, at once."""
    cause = error if isinstance(error, OSError) else error.__context__
    is_silent = isinstance(cause, TimeoutError) or re.search("timed out|[Kk]eep ?alive", str(error))
    if is_silent:
        return errors.BrokerLost(url=url, problem=_NO_ANSWER)
    return errors.BrokerLost(url=url, problem=CLOSED, advice=_SAME_CLIENT if again else None)
