"""The rules of matching: which received frame is an echo, which request a response answers.

A response carries neither its command nor an identifier, so a file is judged as the tester judges
the line (D1, D13): no value comes out of a file that the tester would have refused.

- The echo is the first thing received after a request, byte for byte. What comes in its place
  voids the exchange. A frame that repeats a sent one is an echo, never a response, also after its
  echo, where a response may look so by chance: it has no value, and the exchange is over.
- A request that is no stream has one response: the first frame after the echo, if it fits (length,
  address, content), comes in time, and nothing comes with it. A second one answers nothing.
- With the first byte of the next request, the one before has had all its responses. A damaged one
  is not known: nothing answers it, nor the one before. Unless its echo shows that it was no 64, the
  unit's list (63) is not known any more either; nor is it behind a missing part, nor behind an
  echo of a 64, or a `00`, that belongs to no request.
- After a failed exchange, and after a stream, nothing counts until `01` has been answered by
  exactly one response, the unit's version, with nothing behind it.

Whether the line echoes is decided by `01`, whose response never repeats it, or by a request that
came back before its response. The begin of a recording, and what follows a missing part, count as
trusted: the tester asks for no value on a line that it does not trust.

`exchanges.scalar` applies these rules to every frame, `exchanges.columns` and `exchanges.turns`
only to irregular traffic: for regular traffic they compute their outcome in one step.
"""

from __future__ import annotations

from collections import deque
from enum import Enum, auto
from math import inf
from typing import Final

from mikas.commands import COMMANDS_BY_CODE, Availability
from mikas.commands.base import ERROR, OK
from mikas.framing import encode
from mikas.recording.exchanges.fitting import Fitting
from mikas.recording.exchanges.layouts import WRITE_LIST
from mikas.recording.exchanges.verdicts import (
    DAMAGE,
    ECHO,
    NO_REQUEST,
    REFUSED,
    UNKNOWN,
    Doubt,
    Received,
    SentRequest,
    Verdict,
)

# s; an unfinished frame is abandoned after such a silence: longer than D14's pause inside a
# response and a latency timer. If a request was sent in between, the tester has abandoned it.
SILENCE: Final = 0.25
SILENCE_AFTER_SENDING: Final = 0.02

AVAILABILITY: Final = Availability().body()
_MOST_UNECHOED: Final = 64
_MODELS: Final = frozenset([b"\x09", b"\x0a"])  # versions that need no second `01` (D13)

# s from the end of a request to its response: D14's 500 ms, as seen through a latency timer. A
# tester that waits longer shows it by what it sends next, and when: one that gave up waits for as
# long again (`Timing.late`), but for a late response, then synchronizes by `01`.
PATIENCE: Final = 0.51
_GIVEN_UP: Final = 0.9
_SOON: Final = 0.5
_MARGIN: Final = 1.25
_AT_ONCE: Final = 10  # as the tester's


class Stage(Enum):
    """How far an exchange has come."""

    NONE = auto()  # no request is known
    ASKED = auto()
    ECHOED = auto()
    STREAMING = auto()  # every further frame is a response
    ANSWERED = auto()
    LATE = auto()  # by a response that came too late
    VOID = auto()


class Matching:
    """The state of one port. `request`: the last one; `count`: how many were sent.

    `echoes`: whether the line returns the sent bytes; None: not known yet. `trusted`: whether a
    response counts. `patience`: s that the tester waits for one. `listed`: length of the responses
    to 63. `lists_lost`: serials of the requests behind which the unit's list is not known any more,
    until they are taken. `unechoed`: sent frames whose echo may follow, the first one's also again.
    """

    def __init__(self, fitting: Fitting, byte_time: float) -> None:
        self.fitting = fitting
        self.request: SentRequest = UNKNOWN
        self.count: int = 0
        self.echoes: bool | None = None
        self.trusted: bool = True
        self.patience: float = PATIENCE
        self.listed: int | None = None
        self.bodies: list[bytes] = []
        self.stage: Stage = Stage.NONE
        self._byte_time = byte_time
        self._numbers: dict[bytes, int] = {}
        self.unechoed: deque[bytes] = deque(maxlen=_MOST_UNECHOED)
        self._wire = b""
        self._from = 0  # where in the received stream the request's echo begins
        self._sent_until = -inf
        self._due = -inf  # when the last byte of the request or of its echo was on the line
        self._at_once: int | None = None  # responses before an emulator counts as a wire
        self._delay = 0.0  # of a late response
        self._answered_at = -inf
        self._trusted_before: bool | None = None  # a late response, if it may have been taken
        self.lists_lost: list[int] = []
        self._is_partial = self._is_damaged = False  # what was sent may be a 64
        self._answer = b""  # to the present `01`
        self._version: bytes | None = None
        self._last_version: bytes | None = None  # the response to the last clean `01`

    def number(self, body: bytes | None) -> int:
        """Return the number of a request body, its place in `bodies`; NO_REQUEST for None."""
        if body is None:
            return NO_REQUEST
        number = self._numbers.setdefault(body, len(self.bodies))
        if number == len(self.bodies):
            self.bodies.append(body)
        return number

    @property
    def is_stream(self) -> bool:
        """Whether the last request is a stream's, with its echo, if the line has one."""
        return self.stage is Stage.STREAMING

    @property
    def _is_availability(self) -> bool:
        return self.request.body == AVAILABILITY

    @property
    def doubts_list(self) -> bool:
        """Whether what was sent may be a 64, until its echo has come."""
        return self._is_partial or self._is_damaged

    def interrupt(self, stream: bytes | None = None) -> None:
        """Drop the request: a part of the file is missing, perhaps with a request in it.

        A stream continues: its next response is one of many. `stream`: the request in the missing
        part whose responses follow.
        """
        self.lose_list()
        if stream is not None:
            self.request, self.stage = SentRequest(self.count, stream), Stage.STREAMING
            self.count += 1
            self.unechoed.append(encode(stream))
            self.trusted = True
        if self.stage is not Stage.STREAMING:
            self.request, self.stage = UNKNOWN, Stage.NONE
            self.trusted = True

    def lose_list(self) -> None:
        """Know the unit's list no more."""
        self.listed = None
        self._is_partial = self._is_damaged = False
        if self.lists_lost[-1:] != [self.count - 1]:
            self.lists_lost.append(self.count - 1)

    def take_lists_lost(self) -> list[int]:
        """Return `lists_lost`, and begin a new one."""
        lost, self.lists_lost = self.lists_lost, []
        return lost

    # Sending

    def turn(self) -> None:
        """Begin to send after receiving: missing echoes will not follow any more."""
        self.unechoed.clear()
        if self.doubts_list:
            self.lose_list()

    def begin_sending(self, time: float, received: int) -> None:
        """Begin a request, or go on with it, at `time`, behind so many received bytes."""
        self.end_exchange(time)
        self._is_damaged |= self._is_partial
        self._is_partial, self._from = True, received

    def end_exchange(self, time: float) -> None:
        """End the exchange before: a byte of the next request is sent at `time`."""
        stage, self.stage = self.stage, Stage.NONE
        if stage is Stage.NONE:
            return
        if stage is Stage.LATE and self._has_waited(time):
            self._trusted_before = self.trusted
        if stage is Stage.STREAMING:
            self.trusted = False
        elif stage is not Stage.ANSWERED:
            # Without an echo, a response may look like its request.
            self.trusted &= stage is Stage.ECHOED and self.echoes is False
        elif self._is_availability:
            self._confirm()

    def _has_waited(self, time: float) -> bool:
        """Return whether the tester, which sends at `time`, may have taken a late response."""
        is_quick = time < self._sent_until + _GIVEN_UP
        is_patient = self._delay > _GIVEN_UP and time < self._answered_at + _SOON
        return is_quick or is_patient

    def _learn_patience(self, trusted: bool) -> None:
        """Trust as before a late response, which the tester has taken."""
        if trusted or self._is_availability:
            self.patience = max(self.patience, _MARGIN * self._delay)
            self.trusted = trusted
            if self._is_availability:
                self._confirm()

    def _confirm(self) -> None:
        """Judge a clean answer to `01` (D13)."""
        version, before = self._answer, self._last_version
        self._last_version = version
        is_own = version == self._version or (self._version is None and version in _MODELS)
        if is_own or version == before:
            self._version = version
            self.trusted = True
        elif self._version is not None:
            self.trusted = False

    def sent(self, wire: bytes, body: bytes | None, time: float, received: int) -> None:
        """Take a sent frame, or damage, which has no `body`.

        `time`: of the packet with its first byte. `received`: bytes received before it.
        """
        if self.stage is not Stage.NONE:  # more than one in a packet
            self.end_exchange(time)
        if body is not None and self._is_damaged:
            self.lose_list()
        before, self._trusted_before = self._trusted_before, None
        if before is not None and body not in (None, AVAILABILITY):
            self._learn_patience(before)
        self.request = SentRequest(self.count, body)
        self.count += 1
        self.unechoed.append(wire)
        self._is_partial = False
        if body is None:
            self._is_damaged = True
            return
        self.stage = Stage.ASKED
        self._wire, self._from = wire, received
        self._sent_until = self._due = time + len(wire) * self._byte_time
        if body[:1] == WRITE_LIST:
            self.listed = None

    def follow(self, count: int, body: bytes, wire: bytes, *, streams: bool = False) -> None:
        """Follow `count` requests, each with its echo, if the line echoes, and one response that
        fits and comes in time. `body`, `wire`: of the last one, which `streams`.
        """
        self.count += count
        self.request = SentRequest(self.count - 1, body)
        self.stage = Stage.STREAMING if streams else Stage.ANSWERED
        self.unechoed.clear()
        self.unechoed.append(wire)
        if not self.echoes:
            self._at_once = max(0, (self._at_once or 0) - count)

    # Receiving

    def received(self, it: Received) -> Verdict:
        """Take a received frame, or damage."""
        was_sent = it.wire in self.unechoed
        if self.stage is Stage.NONE or it.end <= self._from:
            self._judge_list(it)
            return self._apart(it, Doubt.NO_REQUEST, was_sent=was_sent)
        if self.stage is Stage.ASKED:
            if was_sent and it.wire == self._wire and it.start == self._from:
                return self._echo(it)
            if self.echoes or was_sent:
                self.stage = Stage.VOID
                return self._apart(it, Doubt.NO_ECHO, was_sent=was_sent)
        if was_sent or self.stage in (Stage.ANSWERED, Stage.LATE, Stage.VOID):
            doubt = Doubt.SECOND if self.stage is Stage.ANSWERED else Doubt.FAILED
            if self.stage is Stage.ECHOED and it.wire == self._wire and not self._is_availability:
                self.stage = Stage.ANSWERED  # the tester took it for the response, perhaps rightly
            elif self.stage is not Stage.STREAMING:
                self.stage = Stage.VOID
            return self._apart(it, doubt, was_sent=was_sent)
        return self._response(it)

    def _judge_list(self, it: Received) -> None:
        """Learn from the echo of a request that is not known whether it was a 64."""
        if self.echoes and it.start == self._from and self.doubts_list:
            if it.body is None or it.body[:1] == WRITE_LIST:
                self.lose_list()
            self._is_partial = self._is_damaged = False

    def _apart(self, it: Received, doubt: Doubt, *, was_sent: bool) -> Verdict:
        """Return the verdict on an echo, or on bytes that answer no request."""
        if was_sent:
            self._drop_before(it.wire)
            if self._is_availability and it.wire == self._wire:
                self.echoes = True
            return ECHO
        if it.body is None:
            return DAMAGE
        if it.body[:1] == WRITE_LIST or it.body == OK:  # all that is left of a 64, perhaps
            self.lose_list()
        return REFUSED[doubt]

    def _drop_before(self, wire: bytes) -> None:
        """Drop the sent frames before this one, whose echo has come. It may come again."""
        while self.unechoed[0] != wire:
            self.unechoed.popleft()

    def _echo(self, it: Received) -> Verdict:
        self._drop_before(it.wire)
        self._due = max(self._due, it.ended)
        is_stream = self._asks_stream()
        self.stage = Stage.STREAMING if is_stream else Stage.ECHOED
        if self._is_availability:
            self.echoes = True
        return ECHO

    def _asks_stream(self) -> bool:
        body = self.request.body
        command = COMMANDS_BY_CODE.get(body[0]) if body else None
        return command is not None and command.STREAM

    def _response(self, it: Received) -> Verdict:
        """Judge the first thing behind a request and its echo, or any of a stream."""
        if self._asks_stream():
            self.stage = Stage.STREAMING
            if it.body is None:
                return DAMAGE
            return self._answered()
        was_echoed, self.stage = self.stage is Stage.ECHOED, Stage.VOID
        if it.body is None:
            return DAMAGE
        if it.followed:
            return REFUSED[Doubt.TOGETHER]
        if not was_echoed and not self.echoes and self._is_too_soon(it.wire_time):
            return REFUSED[Doubt.TOO_SOON]
        if (delay := it.began - self._due) > self.patience:
            self.stage, self._delay, self._answered_at = Stage.LATE, delay, it.ended
            self._answer = it.body
            return REFUSED[Doubt.LATE]
        request = self.request.body
        assert request is not None
        if not self.fitting.fits(request, it.body, self.listed):
            return self._answered()  # shown as what it is; no value comes of it
        self.stage = Stage.ANSWERED
        if self._is_availability:
            return self._version_answered(it.body, is_first=it.start == self._from)
        self.echoes = self.echoes or was_echoed
        if self.trusted and request[:1] == WRITE_LIST and it.body == OK:
            self.listed = self.fitting.list_length(request)
        return self._answered()

    def _is_too_soon(self, wire_time: float) -> bool:
        """Return whether a response without an echo began before its request was out (D2).

        An emulator without a wire may answer so, as its answer to `01` shows, or to a recording's
        first request (`Line.receive`).
        """
        if wire_time >= self._due - self._byte_time / 2:
            self._at_once = max(0, (self._at_once or 0) - 1)
        elif self._at_once is None or self._at_once or self._is_availability:
            self._at_once = _AT_ONCE
        else:
            return True
        return False

    def _version_answered(self, version: bytes, *, is_first: bool) -> Verdict:
        if version == ERROR:
            self.stage = Stage.VOID
            return REFUSED[Doubt.FAILED]
        if self.echoes is None and is_first:
            self.echoes = False
        self._answer = version
        if (
            not self.trusted
            and self._version
            and version not in (self._version, self._last_version)
        ):
            return REFUSED[Doubt.NOT_IN_SYNC]
        return Verdict(False, self.request, None)

    def _answered(self) -> Verdict:
        if not self.trusted:
            return REFUSED[Doubt.NOT_IN_SYNC]
        return Verdict(False, self.request, None)
