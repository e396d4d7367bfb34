"""The handshake: detects the echo, a Mikas, an ELM327, or a dead line (D1)."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from enum import Enum
from math import ceil, inf

from mikas.errors import (
    AnswersLate,
    EchoDiffers,
    EchoOnly,
    EchoTwice,
    LineError,
    LinkLost,
    NoEcho,
    NoResponse,
    NotAKLineAdapter,
    PortKind,
    ReadingSuspended,
    SyncLost,
    WrongEchoSetting,
)
from mikas.framing import TERMINATOR, Damage, Frame, encode
from mikas.i18n import Text
from mikas.link import Link
from mikas.link.base import EMPTY_LINES, TEXT_ANSWER
from mikas.tester.exchange import Reply
from mikas.tester.line import Line
from mikas.tester.line_sync import AVAILABILITY, LineSync, no_ecu_error
from mikas.tester.pauses import Pauses

_ELM_TEXT = frozenset(b"?>\r\n .0123456789abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ")


_ECHOED = Text(
    "The request came back before the response: the adapter returns what it sends, but the echo is "
    "set to off",
    "Перед ответом вернулся сам запрос: адаптер возвращает посланное, а в настройках эхо отключено",
)
_NOT_ECHOED = Text(
    "The response came without the request before it: the adapter does not return what it sends, "
    "but the echo is set to on",
    "Ответ пришёл без эха запроса: адаптер не возвращает посланное, а в настройках эхо включено",
)
_SLOWEST = 2.0  # s to a response


class Echo(Enum):
    """Whether the line returns the sent bytes; AUTO detects it at connect (D1)."""

    AUTO = "auto"
    ON = "on"
    OFF = "off"


@dataclass(slots=True)
class Handshake:
    """Handshakes that are repeated. `check` raises if the call is to end; `fail` counts errors."""

    line: Line
    sync: LineSync
    pauses: Pauses
    check: Callable[[], None]
    fail: Callable[[LineError], None]

    def repeated(self, echo: Echo, retries: int, *, listening_since: float) -> int:
        """As `handshake`, repeated up to `retries` times; find out the pause that the unit needs.

        Raises `AnswersLate` too.
        """
        attempt, before = 0, self.line.pause
        unlucky: LineError | None = None  # no response to a request that may have come too soon
        while True:
            self.sync.mark_lost()
            self.check()
            try:
                code = handshake(
                    self.line,
                    self.sync,
                    echo,
                    listening_since=listening_since,
                    again=attempt > 0 or unlucky is not None,
                )
                break
            except LineError as error:
                if unlucky is None and self.pauses.suspects(error, known=True):
                    unlucky = error  # it answered the first `01`, and not the one soon after
                    self.pauses.connect_patiently()
                    continue
                self.fail(error)
                refuse_elm(error.received or b"")
                if attempt >= retries:
                    self.line.pause = before
                    refuse_late_answer(self.line, self.sync, error)
                    raise
                attempt += 1
        self.sync.keep()
        if unlucky is not None and not self.pauses.found_by_trying(code, least=before):
            self.fail(unlucky)
        return code


def handshake(
    line: Line, sync: LineSync, echo: Echo, *, listening_since: float = inf, again: bool = False
) -> int:
    """Set `line.echo`; return the unit's version code, received twice: any byte but `01`.

    `listening_since`: when the port was opened, if nothing has been sent on it. `again`: after a
    failed handshake, also end a stream by strokes of an earlier session, which the short waits of
    the first attempt may miss. Raises `NoEcho`, `EchoOnly`, `EchoDiffers`, `EchoTwice`,
    `NotAKLineAdapter`, `SyncLost` or another `LineError`.
    """
    since, patience = min(listening_since, line.link.now()), line.timing.response_timeout
    received = sync.silence(patient=again)
    answered = _find_echo(line, echo, received)
    first = _request_version(line, answered=answered)
    _expect_silence(line, first, line.timing.idle_time)
    sent_before = line.sent_until
    second = _request_version(line, answered=True)
    # What an earlier session left shows within `response_timeout` after the opening, or in case of
    # doubt after the last response. If this was the late answer to the request before, its own
    # comes as much later as it was sent later.
    until = since + patience
    if again or not answered:
        until = second.ended + patience
    lag = line.sent_at_latest - sent_before
    quiet = max(until - line.link.now(), lag + line.idle_time)
    _expect_silence(line, second, quiet)
    if first.body != second.body:
        raise SyncLost(received=first.body, time=line.link.now())
    if second.body == AVAILABILITY:
        raise EchoTwice(request=encode(AVAILABILITY), received=second.wire, time=line.link.now())
    return second.body[0]


def _find_echo(line: Line, expected: Echo, received_before: bytes) -> bool:
    """Set `line.echo` by the bytes that follow `01`; return whether more than an echo arrived."""
    request, data = _send_availability(line)
    if not data:  # without an echo, one lost answer looks like a dead line
        line.count_silence()
        request, data = _send_availability(line)
    if data in (b"", request):
        line.count_silence()
    if not data:
        raise NoEcho(request=request, received=data, time=line.link.now())
    refuse_elm(received_before + data)
    sound = len(data) > 2 and data[-1] == TERMINATOR and sum(data[:-1]) & 0xFF == 0
    line.echo = data.startswith(request)
    if data == request and expected is Echo.OFF:
        raise EchoOnly(request=request, received=data, time=line.link.now())
    if not line.echo and not sound:
        raise EchoDiffers(request=request, received=data, time=line.link.now())
    if expected is (Echo.OFF if line.echo else Echo.ON):
        problem = _ECHOED if line.echo else _NOT_ECHOED
        raise WrongEchoSetting(
            problem=problem, request=request, received=data, time=line.link.now()
        )
    return data != request


def _send_availability(line: Line) -> tuple[bytes, bytes]:
    """Send `01`; return its frame and all bytes received."""
    timing = line.timing
    request = line.send(AVAILABILITY)
    deadline = line.sent_at_latest + timing.response_timeout
    last = deadline + timing.max_busy_time
    received = bytearray()
    while (chunk := line.read(deadline)).data and chunk.time < last:
        received += chunk.data
        if not request.startswith(received):
            # More than the echo has arrived, which is enough. Wait for the rest to end.
            line.heard = chunk.time
            deadline = min(chunk.time + timing.idle_time, last)
    return request, bytes(received)


def _late_answer(line: Line, sync: LineSync) -> float | None:
    """Return the seconds from `01` to its only response if that comes after the time-out (D14).

    For a handshake that failed because responses did not fit their requests. None: not so.
    """
    sync.silence(patient=True)
    line.send(AVAILABILITY)
    deadline, decoder = line.sent_at_latest + _SLOWEST, line.decoder()
    frames: list[tuple[Frame | Damage, float]] = []
    while len(frames) <= line.echo and (chunk := line.read(deadline)).data:
        frames += decoder.feed(chunk)
    if len(frames) != 1 + line.echo or line.wait_for_quiet(line.idle_time):
        return None
    answer, began = frames[-1]
    late = began - line.sent_until > line.timing.response_timeout
    return began - line.sent_until if late and isinstance(answer, Frame) else None


def _request_version(line: Line, *, answered: bool) -> Reply:
    """Return the answer to `01`. `answered`: one came before, so silence is a lost response."""
    try:
        return line.exchange(AVAILABILITY, confirms=True)
    except NoResponse as error:
        if answered:
            raise
        raise no_ecu_error(error, echoes=line.echo) from error


def _expect_silence(line: Line, reply: Reply, seconds: float) -> None:
    """Raise `SyncLost` unless `reply` is one byte, followed by `seconds` of silence."""
    extra = line.wait_for_quiet(seconds)
    if extra or len(reply.body) != 1:
        raise SyncLost(request=encode(AVAILABILITY), received=reply.wire + extra, time=reply.ended)


def refuse_elm(received: bytes) -> None:
    """Raise `NotAKLineAdapter` for the answer of an ELM327, which interprets bytes as text."""
    text = received.replace(encode(AVAILABILITY), b"").lstrip(b"\x01\xff")
    if _ELM_TEXT.issuperset(text) and (b"?" in text or b">" in text):
        raise NotAKLineAdapter(received=received)


def ask_for_words(link: Link) -> None:
    """Send empty lines into a network: a server that waits for a line (HTTP) answers by text."""
    if link.kind is PortKind.NETWORK:
        with suppress(LinkLost, ReadingSuspended):
            link.write(EMPTY_LINES)
            link.read(link.now() + TEXT_ANSWER)


def refuse_late_answer(line: Line, sync: LineSync, error: LineError) -> None:
    """Raise `AnswersLate` if the handshake ended with `error` as the response comes too late."""
    if not isinstance(error, SyncLost):
        return
    seconds = None
    with suppress(LineError):
        seconds = _late_answer(line, sync)
    if seconds is not None:
        raise AnswersLate(
            seconds=seconds,
            limit=line.timing.response_timeout,
            wanted=ceil(2.4 * seconds) / 2,
            request=error.request,
            received=error.received,
            time=line.link.now(),
        ) from error
