"""A port of a terminal server by Telnet and RFC 2217, as a port of `SerialLink` (`rfc2217://`).

The server is asked for binary transmission and for its port's settings. Every answer may be
missing: many servers leave one unacknowledged. What they answer has to be what was asked, or the
bytes would be of another rate. PURGE-DATA is not sent: the line is emptied by D13.
"""

from __future__ import annotations

import errno
import select
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import IntEnum
from typing import Final

from mikas.i18n import Text
from mikas.link.base import EMPTY_LINES, TEXT_ANSWER
from mikas.link.network.other_end import said_in
from mikas.link.network.tcp import Place, RawTcpPort
from mikas.link.network.telnet import (
    Event,
    Negotiation,
    Subnegotiation,
    TelnetDecoder,
    Verb,
    escaped,
    negotiation,
    subnegotiation,
)

FIRST_ANSWER: Final = 2.0  # s to the first bytes of Telnet
ANSWERS: Final = 1.0  # s to the acknowledgement of all settings

_BINARY: Final = 0  # RFC 856
_NO_GO_AHEAD: Final = 3  # RFC 858
_COM_PORT: Final = 44
_WANTED: Final = {_BINARY, _NO_GO_AHEAD, _COM_PORT}  # at either end
_MOST_FIRST: Final = 256  # bytes
_ANSWER: Final = 100  # added to a command's code in the server's answer
_CLOSE: Final = 0.03  # of its rate, by which a server's divisor may miss

_CONTROL: Final = 5
_NO_FLOW_CONTROL: Final = b"\x01"
_BREAK: Final = {True: b"\x05", False: b"\x06"}
_DTR: Final = {True: b"\x08", False: b"\x09"}
_RTS: Final = {True: b"\x0b", False: b"\x0c"}


class Setting(IntEnum):
    """Commands of COM-PORT-OPTION whose answer is what the port is set to."""

    BAUD_RATE = 1
    DATA_SIZE = 2
    PARITY = 3
    STOP_SIZE = 4


_SETTINGS: Final = frozenset(Setting)
_8N1: Final = {Setting.DATA_SIZE: 8, Setting.PARITY: 1, Setting.STOP_SIZE: 1}
_NAMES: Final = {
    Setting.BAUD_RATE: Text("baud rate", "скорость"),
    Setting.DATA_SIZE: Text("data bits", "число бит данных"),
    Setting.PARITY: Text("parity code", "код чётности"),
    Setting.STOP_SIZE: Text("stop bits code", "код стоповых бит"),
}


@dataclass(frozen=True, slots=True)
class LineSettings:
    """The settings of the server's port. `named`: the URL asks for some of them."""

    baud: int
    dtr: bool
    rts: bool
    named: bool


class NotSet(OSError):
    """The server does not set its port as asked. `text`: how."""

    def __init__(self, text: Text) -> None:
        super().__init__(errno.EPROTO, text.en)
        self.text = text


RAW_PORT: Final = Text(
    "it is a raw port, and the line's echo comes back: use socket:// (the same host and port)",
    "это порт без Telnet, от него вернулось эхо линии: используйте socket:// (с тем же адресом)",
)
NO_TELNET: Final = Text(
    "it does not speak RFC 2217 (try socket://)",
    "он не поддерживает RFC 2217 (попробуйте socket://)",
)
_SAYS: Final = Text(
    "it does not speak RFC 2217, and says “{said}” (try socket://, or another port number)",
    "он не поддерживает RFC 2217 и сообщает: «{said}» (попробуйте socket:// или другой порт)",
)
NO_ANSWER: Final = Text(
    "nothing came back: it does not speak RFC 2217 (try socket://), serves another client, or "
    "hangs",
    "он ничего не ответил: не поддерживает RFC 2217 (попробуйте socket://), занят другим клиентом "
    "или завис",
)
NO_COM_PORT: Final = Text(
    "it speaks Telnet and can't set its port (no RFC 2217): set baud rate, DTR and RTS at the "
    "server, and leave these options out",
    "он говорит по Telnet, но настроить порт не может (нет RFC 2217): задайте скорость, DTR и RTS "
    "на сервере, а эти параметры уберите",
)
SET_OTHERWISE: Final = Text(
    "the server sets its port otherwise: {name} {is_set}, not {asked}; set the port to {baud} "
    "baud, 8N1 at the server, or allow its clients to set it",
    "сервер настроил порт иначе: {name} {is_set} вместо {asked}; задайте порту на сервере {baud} "
    "бод, 8N1 или разрешите клиентам его настраивать",
)
_ANSWERS: Final = {
    (True, True): Verb.WILL,
    (True, False): Verb.WONT,
    (False, True): Verb.DO,
    (False, False): Verb.DONT,
}
_ASKED: Final = (
    (Verb.WILL, _BINARY),
    (Verb.DO, _BINARY),
    (Verb.DO, _NO_GO_AHEAD),
    (Verb.WILL, _COM_PORT),
    (Verb.DO, _COM_PORT),
)


class Rfc2217Port(RawTcpPort):
    """A port behind a terminal server, which is asked for `settings`.

    `can_break`: whether the server speaks RFC 2217, not Telnet alone.
    """

    telnet = True

    def __init__(self, settings: LineSettings, *, patience: float) -> None:
        super().__init__(patience=patience)
        self.can_break: bool = False
        self._settings = settings
        self._decoder = TelnetDecoder(_COM_PORT)
        self._binary = True  # of the bytes that are sent
        self._before = b""  # received before the settings are agreed on
        self._agreed: dict[tuple[bool, int], bool] = {}  # by whether it is done here, and option
        self._unanswered: dict[Setting, int] = {}

    def open(self, place: Place) -> None:
        """Connect and agree on the settings. Raises `OSError`."""
        super().open(place)
        try:
            self._negotiate()
        except BaseException:
            self.give_up()
            raise

    def write(self, data: bytes) -> int:
        super().write(escaped(data, binary=self._binary))
        return len(data)

    @property
    def break_condition(self) -> bool:
        """Whether the line is held low; known to the server only."""
        return False

    @break_condition.setter
    def break_condition(self, low: bool) -> None:
        self._command(_CONTROL, _BREAK[low])

    @property
    def baudrate(self) -> int:
        """The baud rate that the server was asked for."""
        return self._settings.baud

    @baudrate.setter
    def baudrate(self, baud: int) -> None:
        self._settings = replace(self._settings, baud=baud)
        self._command(Setting.BAUD_RATE, baud.to_bytes(4, "big"))

    def _negotiate(self) -> None:
        ours, theirs = (True, _COM_PORT), (False, _COM_PORT)
        opening = b"".join(negotiation(*each) for each in _ASKED)
        self._send(opening)

        def decided() -> bool:
            known = [self._agreed[it] for it in (ours, theirs) if it in self._agreed]
            return any(known) or len(known) == 2

        self._wait(FIRST_ANSWER, decided)
        if not self._before:
            self._send(EMPTY_LINES)
            self._wait(TEXT_ANSWER, lambda: bool(self._before))
        if self._before.startswith(opening):  # the K-Line's echo; a server's answer has other verbs
            raise NotSet(RAW_PORT)
        if not self._decoder.spoken:
            said = said_in(self.first)
            silent = NO_TELNET if self.first else NO_ANSWER
            raise NotSet(_SAYS.filled(said=said) if said else silent)
        self.can_break = self._agreed.get(ours, False) or self._agreed.get(theirs, False)
        if self.can_break:
            self._set_up()
            self._wait(ANSWERS, lambda: not self._unanswered)
        elif self._settings.named:
            raise NotSet(NO_COM_PORT)

    def _set_up(self) -> None:
        wanted = self._settings
        self._unanswered = {Setting.BAUD_RATE: wanted.baud, **_8N1}
        for setting, value in self._unanswered.items():
            size = 4 if setting is Setting.BAUD_RATE else 1
            self._command(setting, value.to_bytes(size, "big"))
        for control in (_NO_FLOW_CONTROL, _DTR[wanted.dtr], _RTS[wanted.rts]):
            self._command(_CONTROL, control)

    def _wait(self, seconds: float, is_over: Callable[[], bool]) -> None:
        """Drop the data that come, for so many seconds at most: older than the port."""
        until = time.monotonic() + seconds
        while not is_over() and (left := until - time.monotonic()) > 0:
            if select.select([self.fileno()], [], [], left)[0]:
                self.read(_MOST_FIRST)

    def read(self, size: int) -> bytes:
        """Return the data that have arrived; none if it was the server's own talk."""
        received = self._receive(size)
        if len(self._before) < _MOST_FIRST:
            self._before += received
        data, events = self._decoder.feed(received)
        self._note(data)
        for event in events:
            self._react(event)
        return data

    def _react(self, event: Event) -> None:
        match event:
            case Negotiation(Verb.DO | Verb.DONT as verb, option):
                self._agree(option, here=True, wanted=verb is Verb.DO)
            case Negotiation(verb, option):
                self._agree(option, here=False, wanted=verb is Verb.WILL)
            case Subnegotiation(option, data) if option == _COM_PORT and data:
                self._answered(data[0] - _ANSWER, data[1:])

    def _agree(self, option: int, *, here: bool, wanted: bool) -> None:
        """Answer a change of an option; a repetition, or an answer to `_ASKED`, gets none."""
        before = self._agreed.get((here, option))
        self._agreed[here, option] = done = wanted and option in _WANTED
        if here and option == _BINARY:
            self._binary = done
        asked = (Verb.WILL if here else Verb.DO, option) in _ASKED
        if before is done or (before is None and (asked or not wanted)):
            return
        self._send(negotiation(_ANSWERS[here, done], option))

    def _answered(self, code: int, value: bytes) -> None:
        """Compare an answer with the setting that was asked for; notifications have other codes."""
        if code not in _SETTINGS:
            return
        setting = Setting(code)
        self._unanswered.pop(setting, None)
        asked = _8N1.get(setting, self._settings.baud)
        is_set = int.from_bytes(value, "big")
        off = _CLOSE * asked if setting is Setting.BAUD_RATE else 0
        if is_set and abs(is_set - asked) > off:  # 0: the server does not say
            baud, name = self._settings.baud, _NAMES[setting]
            raise NotSet(SET_OTHERWISE.filled(name=name, asked=asked, is_set=is_set, baud=baud))

    def _command(self, code: int, value: bytes) -> None:
        self._send(subnegotiation(_COM_PORT, bytes([code]) + value))
