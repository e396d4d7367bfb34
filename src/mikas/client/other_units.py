"""Other units on a line where no Mikas answers: named, in the place of “silent”.

On request only (`doctor --other-units`), one try each, and nothing that changes a unit:

- bytes that come unasked, as a re-flashed unit may send;
- `01` at other baud rates;
- the fast wake-up of KWP2000 (ISO 14230-2), then StartCommunication to the engine's unit;
- the slow one, the address 33 at 5 baud (ISO 14230-4).

A unit that woke up gets TesterPresent and StopCommunication, and is asleep again. An adapter's echo
is no answer. The baud rate is put back.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress

from mikas import kwp2000
from mikas.client.doctor import Step
from mikas.errors import LinkLost, PortKind, ReadingSuspended, hex_dump
from mikas.framing import Decoder, Frame, encode
from mikas.i18n import Text
from mikas.link import Link

NAMES = ("unasked", "other-baud", "kwp2000-fast", "kwp2000-slow")
"""The steps, in their order."""

OTHER_BAUDS = (4800, 10_400, 19_200, 38_400)
_AVAILABILITY = b"\x01"

_LISTEN = 2.0  # s for bytes that come unasked
_IDLE = 0.35  # s of silence before a wake-up: the standard wants 0.3
_NOISY = 3.0  # s; a line that is not silent for so long is not woken up
_ANSWER = 0.5  # s to the first byte of an answer
_LOW, _FAST = 0.025, 0.05  # s: low, and from its begin to the request
_BIT = 0.2  # s, at 5 baud
_BITS = 10  # of the address: start, eight, stop
_KEY_BYTES = 0.4  # s from the address to 55 and the key bytes
_W4 = 0.027  # s from the last key byte to its inverted form; an adapter hands it over late
_P3 = 0.06  # s from a response to the next request
_MOST = 64  # bytes that are kept of a talker

_MIKAS_ONLY = Text("mikas reads the Mikas 5.4 and 7.1 only", "mikas читает только Микас 5.4 и 7.1")
_LATER = Text(
    "a Mikas 7.6, 10.3, 11 or 12, or another maker's unit",
    "Микас 7.6, 10.3, 11 или 12 либо блок другого производителя",
)
_NO_BREAK = Text(
    "not tried: this port can't hold the line low (break)",
    "не проверялось: этот порт не умеет удерживать линию в нуле (break)",
)
_NO_BAUD = Text(
    "not tried: the baud rate of this port can't be changed from here",
    "не проверялось: скорость этого порта отсюда не меняется",
)
_NO_BAUD_TCP = Text(
    "not tried: over plain TCP the baud rate is the other end's; take an adapter on this computer, "
    "or rfc2217://",
    "не проверялось: через простой TCP скорость задаёт другая сторона; подключите адаптер к этому "
    "компьютеру или используйте rfc2217://",
)
_BUSY = Text(
    "not tried: bytes keep coming on the line", "не проверялось: на линии всё время идут байты"
)
_SILENT = Text("no answer", "ответа нет")
_OVER_NETWORK = Text(
    "no answer; a network does not keep the times of a wake-up exactly, so try with the adapter on "
    "this computer",
    "ответа нет; по сети времена пробуждения выдерживаются неточно, повторите с адаптером на этом "
    "компьютере",
)


class _NotTried(Exception):
    """The link can't do it, or the line is not free. `text`: which."""

    def __init__(self, text: Text) -> None:
        super().__init__(text.en)
        self.text = text


def other_units(link: Link) -> Iterator[Step]:
    """Yield a step for each of `NAMES`: `ok` true names what answers, None: nothing, or not tried.

    `link`: open, with no exchange under way. Raises `LinkLost`.
    """
    usual = link.baud
    for name, look in zip(NAMES, (_unasked, _other_baud, _fast, _slow), strict=True):
        try:
            found = look(link)
            step = Step(name, None if found is None else True, found or _silence(name, link))
        except _NotTried as why:
            step = Step(name, None, why.text)
        finally:
            if link.baud != usual:
                with suppress(LinkLost):
                    link.set_baud(usual)
        yield step


def _silence(name: str, link: Link) -> Text:
    if name == "unasked":
        return Text("no bytes come unasked", "сам по себе никто ничего не передаёт")
    woken = name.startswith("kwp2000")
    return _OVER_NETWORK if woken and link.kind is PortKind.NETWORK else _SILENT


# Each try returns what it found in words; None: nothing.


def _unasked(link: Link) -> Text | None:
    received = _received(link, link.now() + _LISTEN)
    if not received:
        return None
    shown = hex_dump(received[:_MOST])
    return Text(
        f"bytes come unasked: {shown}. A re-flashed unit or another device talks on this line; "
        f"{_MIKAS_ONLY.en}",
        f"байты идут без запроса: {shown}. На линии говорит перепрошитый блок или другое "
        f"устройство; {_MIKAS_ONLY.ru}",
    )


def _other_baud(link: Link) -> Text | None:
    usual, wire, odd = link.baud, encode(_AVAILABILITY), ""
    for baud in OTHER_BAUDS:
        if baud == usual:
            continue
        _set_baud(link, baud)
        _quiet(link)
        received = _exchanged(link, wire)
        answers = [each for each in Decoder().feed(received) if isinstance(each, Frame)]
        if any(len(each.body) == 1 and each.body != _AVAILABILITY for each in answers):
            shown = hex_dump(received)
            return Text(
                f"`01` is answered at {baud} baud ({shown}): a re-flashed unit. Try it with "
                f"?baud={baud} behind the port",
                f"на `01` приходит ответ при {baud} бод ({shown}): блок перепрошит. Попробуйте "
                f"с ?baud={baud} после порта",
            )
        if received and not odd:
            odd = f"{baud}: {hex_dump(received[:_MOST])}"
    if odd:
        return Text(
            f"bytes come after `01`, but no answer to it, at {odd}. Another kind of unit, or one "
            "of another baud rate",
            f"после `01` приходят байты, но не ответ, {odd}. Блок другого рода или с другой "
            "скоростью",
        )
    return None


def _fast(link: Link) -> Text | None:
    _set_baud(link, kwp2000.BAUD)
    _quiet(link)
    began = link.now()
    _hold_low(link, _LOW)
    _received(link, began + _FAST)  # the echo of the break
    received = _exchanged(link, kwp2000.encode(kwp2000.START))
    if not received:
        return None
    message = kwp2000.find(received)
    if message is None:
        return _strange("fast", received)
    started = message.data[:1] == bytes([kwp2000.START[0] + kwp2000.POSITIVE])
    keys = hex_dump(message.data[1:3]) if started else ""
    present = _stopped(link, message.source) if started else False
    said = Text(f"key bytes {keys}", f"ключевые байты {keys}")
    if not started:
        said = Text(f"it refuses: {hex_dump(message.data)}", f"отказ: {hex_dump(message.data)}")
    return _kwp2000("fast", said, message.source, present=present)


def _slow(link: Link) -> Text | None:
    _set_baud(link, kwp2000.BAUD)
    _quiet(link)
    _send_slowly(link, kwp2000.OBD)
    received = _received(link, link.now() + _KEY_BYTES, count=3)
    begin = received.find(kwp2000.SYNC)
    if begin < 0 or len(received) < begin + 3:
        return _strange("slow", received) if received else None
    keys = received[begin + 1 : begin + 3]
    _received(link, link.now() + _W4)
    confirmed = _exchanged(link, bytes([keys[1] ^ 0xFF]))
    shown = hex_dump(keys)
    if keys[1] != 0x8F:  # ISO 14230-2: of KWP2000
        return Text(
            f"a unit answers the slow wake-up at {kwp2000.BAUD} baud with the key bytes {shown}: "
            f"ISO 9141-2 or a maker's own protocol. {_MIKAS_ONLY.en}",
            f"на медленное пробуждение ({kwp2000.BAUD} бод) отвечает блок с ключевыми байтами "
            f"{shown}: ISO 9141-2 или собственный протокол производителя. {_MIKAS_ONLY.ru}",
        )
    woken = bytes([kwp2000.OBD ^ 0xFF]) in confirmed
    present = _stopped(link, None) if woken else False
    said = Text(f"key bytes {shown}", f"ключевые байты {shown}")
    return _kwp2000("slow", said, None, present=present)


def _kwp2000(kind: str, said: Text, source: int | None, *, present: bool) -> Text:
    wake = {"fast": "быстрое", "slow": "медленное"}[kind]
    address = "" if source is None else f"{source:02X}"
    en = f", address {address}" if address else ""
    ru = f", адрес {address}" if address else ""
    also = Text(", and TesterPresent", " и на TesterPresent") if present else Text("", "")
    return Text(
        f"this unit speaks KWP2000: it answers the {kind} wake-up at {kwp2000.BAUD} baud{also.en} "
        f"({said.en}{en}). It is {_LATER.en}; {_MIKAS_ONLY.en}",
        f"этот блок говорит по KWP2000: отвечает на {wake} пробуждение на {kwp2000.BAUD} "
        f"бод{also.ru} ({said.ru}{ru}). Это {_LATER.ru}; {_MIKAS_ONLY.ru}",
    )


def _strange(kind: str, received: bytes) -> Text:
    wake = {"fast": "быстрого", "slow": "медленного"}[kind]
    shown = hex_dump(received[:_MOST])
    return Text(
        f"bytes come after the {kind} wake-up, but no message of KWP2000: {shown}. Another kind of "
        "unit",
        f"после {wake} пробуждения приходят байты, но не сообщение KWP2000: {shown}. Блок другого "
        "рода",
    )


# The line


def _set_baud(link: Link, baud: int) -> None:
    if link.baud != baud and not link.set_baud(baud):
        raise _NotTried(_NO_BAUD_TCP if link.kind is PortKind.NETWORK else _NO_BAUD)


def _hold_low(link: Link, seconds: float) -> None:
    if link.can_break:
        link.send_break(seconds)
    if not link.can_break:  # it may turn out at the first attempt
        raise _NotTried(_NO_BREAK)


def _received(link: Link, until: float, *, count: int | None = None) -> bytes:
    """Return what comes until then, the first `_MOST` bytes of it; or `count` bytes, at once."""
    received = bytearray()
    while count is None or len(received) < count:
        try:
            chunk = link.read(until)
        except ReadingSuspended as error:
            received += error.received or b""
            continue
        received += chunk.data[: _MOST - len(received)]
        if not chunk.data or link.now() >= until:
            break
    return bytes(received)


def _quiet(link: Link) -> None:
    """Wait for a silent line."""
    last = link.now() + _NOISY
    while _received(link, link.now() + _IDLE):
        if link.now() > last:
            raise _NotTried(_BUSY)


def _exchanged(link: Link, wire: bytes) -> bytes:
    """Send `wire`; return the bytes of the answer, without the echo."""
    link.write(wire)
    until = link.now() + len(wire) * link.byte_time + _ANSWER
    return _received(link, until).removeprefix(wire)


def _send_slowly(link: Link, address: int) -> None:
    """Send `address` at 5 baud by holding the line low."""
    began = link.now()
    bits = [0, *(address >> place & 1 for place in range(8)), 1]
    place = 0
    while place < _BITS:
        end = place
        while end < _BITS and bits[end] == bits[place]:
            end += 1
        if not bits[place]:
            _hold_low(link, began + end * _BIT - link.now())
        else:
            _received(link, began + end * _BIT)  # the echo of the break
        place = end


def _stopped(link: Link, unit: int | None) -> bool:
    """Send TesterPresent and StopCommunication; return whether the first one was answered."""
    target, present = kwp2000.ENGINE if unit is None else unit, False
    for service in (kwp2000.PRESENT, kwp2000.STOP):
        _received(link, link.now() + _P3)
        message = kwp2000.find(_exchanged(link, kwp2000.encode(service, target)))
        if service == kwp2000.PRESENT and message is not None:
            present = message.data[:1] == bytes([service[0] + kwp2000.POSITIVE])
    return present
