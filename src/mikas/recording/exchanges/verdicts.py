"""The verdicts of matching on received frames: echo, response to which request, or why none."""

from __future__ import annotations

from enum import Enum
from typing import Final, NamedTuple

from mikas.i18n import Text


class SentRequest(NamedTuple):
    """A request frame. `serial`: counts all frames sent on the port from 0; -1: not known.
    `body`: None if not known, or damaged.
    """

    serial: int
    body: bytes | None


NO_REQUEST: Final = -1
UNKNOWN: Final = SentRequest(NO_REQUEST, None)


class Doubt(Enum):
    """Why a received frame answers no request."""

    NO_REQUEST = Text("its request is not known", "запрос к нему неизвестен")
    NO_ECHO = Text("it came in place of the echo", "он пришёл вместо эха")
    FAILED = Text("the exchange has failed", "обмен не удался")
    SECOND = Text("the request has its response already", "на запрос уже был ответ")
    TOGETHER = Text("more than one response came", "пришло больше одного ответа")
    TOO_SOON = Text(
        "it began while the request was being sent", "он начался, пока посылался запрос"
    )
    LATE = Text("later than the tester waits", "позже, чем ждёт тестер")
    NOT_IN_SYNC = Text(
        "after a failed exchange nothing counts until 01 is answered",
        "после сбоя обмена ничто не в счёт до ответа на 01",
    )


class Received(NamedTuple):
    """A received frame, or damage, which has no `body`.

    `start`, `end`: its bytes in the direction's stream. `began`, `ended`: times of the packets with
    its first and last byte. `wire_time`: when its first byte began on the wire, as far as it
    matters: on a line without echo. `followed`: more than bare terminators comes in the packet
    behind it.
    """

    wire: bytes
    body: bytes | None
    start: int
    end: int
    began: float
    ended: float
    wire_time: float
    followed: bool


class Verdict(NamedTuple):
    """On a received frame: an echo, or the request that it answers, or why it answers none."""

    echo: bool
    answers: SentRequest
    doubt: Doubt | None


ECHO: Final = Verdict(True, UNKNOWN, None)
DAMAGE: Final = Verdict(False, UNKNOWN, None)
REFUSED: Final = {doubt: Verdict(False, UNKNOWN, doubt) for doubt in Doubt}
