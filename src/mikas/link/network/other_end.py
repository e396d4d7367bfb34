"""Who answers at a network port in the place of a bridge, by what it has said.

Asked only when a connection has ended or a handshake has failed, so what a bridge sends before it
works (a banner) has no effect. `_SERVICES` is the one table: from bytes to a name and what to set.
"""

from __future__ import annotations

import re
from typing import Final, NamedTuple, TypeVar

from mikas.cleaning import clean_line
from mikas.errors import (
    EchoDiffers,
    LineError,
    LinkLost,
    NoConnection,
    NoEcho,
    OtherService,
    PortKind,
    PortTaken,
    met_on,
)
from mikas.i18n import Text

E = TypeVar("E", bound=NoConnection)

_LONGEST: Final = 100  # characters that are quoted
_SIGNS: Final = 5  # letters and digits of words
_ECHO: Final = b"\x01\xff\r"  # of a handshake (D1): there is a line behind it

_BUSY: Final = re.compile(
    r"\bin use\b|already (?:connected|open|active)|\bbusy\b|\boccupied\b|\blocked by\b"
    r"|(?:too many|max(?:imum|\.)?|limit|only (?:one|1|a single)|another|other|existing)\b.{0,20}"
    r"\b(?:user|conn|client|session)|server (?:is )?full"
    r"|forced off|kicked|taken over|disconnected by|replaced by"
    r"|занят|используется|уже (?:откры|подключ)|друг(?:ой|им) (?:клиент|пользоват)|слишком много"
    r"|verwendet|belegt|besetzt|占用",
    re.IGNORECASE,
)
_BAUD_AT_BRIDGE: Final = Text(
    "Set the bridge to plain TCP (raw, transparent) at 9600 baud, 8N1, and name that port.",
    "Настройте мост на простой TCP (raw, transparent), 9600 бод, 8N1, и укажите этот порт.",
)


class Service(NamedTuple):
    """What answers there, and what to do."""

    name: Text
    advice: Text


_TELNET: Final = Service(
    Text("a Telnet port", "порт Telnet"),
    Text(
        "Telnet eats the byte FF, which each request has. Use rfc2217:// with the same host and "
        "port, or set the port to raw at the server.",
        "Telnet съедает байт FF, а он есть в каждом запросе. Используйте rfc2217:// с тем же "
        "адресом или переведите порт на сервере в режим raw.",
    ),
)
_HTTP: Final = Service(
    Text("a web server (HTTP)", "веб-сервер (HTTP)"),
    Text(
        "That is the settings page of the bridge, or another computer: its serial port has another "
        "number (esp-link: 23; ESPHome's stream server: 6638; many bridges: 8899). "
        + _BAUD_AT_BRIDGE.en,
        "Это страница настроек моста или другой компьютер: у последовательного порта другой номер "
        "(esp-link: 23; stream server из ESPHome: 6638; у многих мостов: 8899). "
        + _BAUD_AT_BRIDGE.ru,
    ),
)
_TLS: Final = Service(
    Text("a port with encryption (TLS)", "порт с шифрованием (TLS)"),
    Text(
        "mikas speaks to bridges without TLS. " + _BAUD_AT_BRIDGE.en,
        "mikas обращается к мостам без TLS. " + _BAUD_AT_BRIDGE.ru,
    ),
)
_SSH: Final = Service(
    Text("an SSH server", "сервер SSH"),
    Text(
        "The serial port has another number: name the one of ser2net there.",
        "У последовательного порта другой номер: укажите порт ser2net на этом компьютере.",
    ),
)
_LOGIN: Final = Service(
    Text("a login prompt", "приглашение ко входу"),
    Text(
        "Switch the login of this port off at the server, or name the port without one.",
        "Отключите на сервере вход для этого порта или укажите порт без входа.",
    ),
)
_ESPHOME: Final = Service(
    Text("ESPHome's own interface", "собственный интерфейс ESPHome"),
    Text(
        "Name the port of its stream server: 6638, unless its configuration has another.",
        "Укажите порт компонента stream server: 6638, если в настройках не задан другой.",
    ),
)
_ESP_LINK: Final = Service(
    Text("esp-link's console", "консоль esp-link"),
    Text(
        "Its serial port is 23, plain TCP: socket://HOST:23, with 9600 baud on its page.",
        "Его последовательный порт — 23, простой TCP: socket://АДРЕС:23; на его странице задайте "
        "9600 бод.",
    ),
)
_ELM: Final = Service(
    Text("an ELM327 on Wi-Fi", "ELM327 по Wi-Fi"),
    Text(
        "It interprets the bytes it gets and can't carry this protocol. Use a plain bridge with a "
        "K-Line adapter behind it, or a KKL cable.",
        "Он сам обрабатывает посланные байты и этот протокол передать не может. Нужен простой мост "
        "с адаптером K-Line за ним или кабель KKL.",
    ),
)
_MQTT: Final = Service(
    Text("an MQTT broker", "брокер MQTT"),
    Text(
        "Values go there with the option for MQTT; the port of the adapter is another one.",
        "Туда значения отправляются параметром для MQTT; порт адаптера другой.",
    ),
)
_FILES_OR_MAIL: Final = Service(
    Text("a server of files or mail", "файловый или почтовый сервер"), _SSH.advice
)

_SERVICES: Final = (
    (re.compile(rb"\A[\x15\x16]\x03[\x00-\x04]"), _TLS),
    (re.compile(rb"\ASSH-\d"), _SSH),
    (re.compile(rb"esp-link", re.IGNORECASE), _ESP_LINK),
    (re.compile(rb"\AHTTP/\d|<!doctype html|<html|400 bad request", re.IGNORECASE), _HTTP),
    (re.compile(rb"ELM ?327|OBDLink|STN[12]\d{3}", re.IGNORECASE), _ELM),
    (re.compile(rb"\A\x01\x00.[\x00\x01]Bad |esphome", re.IGNORECASE | re.DOTALL), _ESPHOME),
    (re.compile(rb"(?:login|user ?name|password) ?: ?", re.IGNORECASE), _LOGIN),
    (re.compile(rb"\A220[ -]"), _FILES_OR_MAIL),
    (re.compile(rb"\A\x20\x02"), _MQTT),
)
_UNKNOWN: Final = Service(
    Text("another program", "другая программа"),
    Text(
        "Check the host and the port number: the bridge's serial port has another one, or is not "
        "set to plain TCP (raw, transparent).",
        "Проверьте адрес и номер порта: у последовательного порта моста другой номер, или он не "
        "переведён в режим простого TCP (raw, transparent).",
    ),
)
_NEGOTIATION: Final = re.compile(rb"\A\xff[\xfa-\xfe]")
_WITHOUT_FF: Final = re.compile(rb"\A(?:\x01\r?\n?\0?)+\Z")  # the echo of `01 FF 0D`, eaten
_BY_NUMBER: Final = {
    **dict.fromkeys((80, 8080, 8000), _HTTP),
    **dict.fromkeys((443, 8443, 8883), _TLS),
    22: _SSH,
    1883: _MQTT,
    6053: _ESPHOME,
}
_SAID: Final = Text(" (it says “{said}”)", " (он сообщает: «{said}»)")
_UNSAID: Final = Text("", "")
_LIKELY: Final = Text("{name}, by its number", "судя по номеру, {name}")
_CLIENT: Final = Text("another client{said}", "другим клиентом{said}")
CLOSED_THERE: Final = Text("closed by the other end", "закрыта другой стороной")
_ENDED_WITHOUT_A_WORD: Final = Text(
    "closed by the other end without a word: a server of another kind (with TLS, of MQTT, a "
    "database), or one that serves another client",
    "закрыта другой стороной без объяснений: там сервер другого рода (с TLS, MQTT, база данных) "
    "или он занят другим клиентом",
)
_ENDED: Final = Text(
    "closed by the other end, which said “{said}”",
    "закрыта другой стороной, она сообщила: «{said}»",
)
_AFTER_THE_END: Final = Text(
    "Likely, in order: another program or phone has taken the connection, and the bridge serves "
    "one at a time; the bridge, or the program that shares the adapter, was restarted; the serial "
    "port has another number.",
    "Скорее всего, по порядку: соединение заняла другая программа или телефон, а мост обслуживает "
    "одного; перезапущен мост или программа, которая раздаёт адаптер; у последовательного порта "
    "другой номер.",
)
_GREETED: Final = Text(
    "Nothing came back, not even the echo of what was sent; before, the other end said “{said}”",
    "На посланное не принято ничего, даже эха; до этого другая сторона сообщила: «{said}»",
)
_IF_ANOTHER: Final = Text(
    "If these are not the bridge's words, another program has this port: check the host and the "
    "port number. Otherwise: ",
    "Если это слова не моста, порт занимает другая программа: проверьте адрес и номер порта. "
    "Иначе: ",
)


def at_the_end(url: str, number: int, first: bytes, last: bytes, *, telnet: bool) -> LinkLost:
    """Return the error of a connection that the other end has closed.

    `number`: of the port; `first`, `last`: bytes that came. `telnet`: they are free of Telnet.
    """
    if _is_busy(last):
        return _taken(url, last)
    if _ECHO in first:  # a bridge
        return _ended(url, CLOSED_THERE)
    if service := _service(first, telnet=telnet):
        return _other(url, service, first)
    if not first and (service := _BY_NUMBER.get(number)):
        return _other(url, _likely(service), first)
    said = said_in(last)
    return _ended(url, _ENDED.filled(said=said) if said else _ENDED_WITHOUT_A_WORD)


def in_handshake(url: str, number: int, first: bytes, *, telnet: bool) -> LinkLost | None:
    """Return the error of a handshake that failed, if `first` or the port's number explains it."""
    if _ECHO in first:
        return None
    if _is_busy(first):
        return _taken(url, first)
    if service := _service(first, telnet=telnet):
        return _other(url, service, first)
    if not telnet and _WITHOUT_FF.match(first):
        return _other(url, _TELNET, b"")
    if not first and (service := _BY_NUMBER.get(number)):
        return _other(url, _likely(service), first)
    return None


def with_words(url: str, first: bytes, error: NoConnection | LineError) -> NoConnection | LineError:
    """Return the error of a handshake with words of the other end, which explain nothing.

    What answers a request in words is no bridge; what has said some before may be one.
    """
    match error:
        case EchoDiffers(received=bytes() as received) if _is_text(received):
            return _other(url, _UNKNOWN, received)
        case NoEcho() if _is_text(first) and error.has_class_advice:
            error.reason = _GREETED.filled(said=said_in(first))
            advice = _error(error).advice
            error.use_class_advice(Text(*map(str.__add__, _IF_ANOTHER, advice)))
    return error


def said_in(data: bytes) -> str:
    """Return the text in `data` on one line, or "" if it is none."""
    data = re.sub(rb"\xff(?:[\xfb-\xfe].|\xfa.*?\xff\xf0|[\xf0-\xf9])", b"", data, flags=re.DOTALL)
    text = data.decode("utf-8", "replace").strip()
    if len(re.findall(r"[^\W_]", text)) * 2 < len(text):
        return ""
    text = re.sub("\ufffd+", "\ufffd", clean_line(text.replace("\r", " ")))
    return " ".join(text.split())[:_LONGEST]


def _is_text(data: bytes) -> bool:
    """Return whether `data` has words, and not some byte of a line that passes for a letter."""
    return len(re.findall(r"[^\W_]", said_in(data))) >= _SIGNS


def _is_busy(data: bytes) -> bool:
    return _BUSY.search(data.decode("utf-8", "replace")) is not None


def _service(first: bytes, *, telnet: bool) -> Service | None:
    for pattern, service in _SERVICES:
        if pattern.search(first):
            return service
    return _TELNET if not telnet and _NEGOTIATION.match(first) else None


def _likely(service: Service) -> Service:
    return Service(_LIKELY.filled(name=service.name), service.advice)


def _ended(url: str, problem: Text) -> LinkLost:
    error = _error(LinkLost(url=url, problem=problem))
    error.use_class_advice(_AFTER_THE_END)
    return error


def _taken(url: str, data: bytes) -> PortTaken:
    return _error(PortTaken(url=url, holder=_CLIENT.filled(said=_quoted(data))))


def _other(url: str, service: Service, data: bytes) -> OtherService:
    name, advice = service
    return _error(OtherService(url=url, service=name, said=_quoted(data), advice=advice))


def _quoted(data: bytes) -> Text:
    said = said_in(data)
    return _SAID.filled(said=said) if said else _UNSAID


def _error(error: E) -> E:
    return met_on(PortKind.NETWORK, error)
