"""Parameters read again and again, cycle by cycle, by each method (§3 rows 61, 63, 71, 7F–83).

    single, batch        61, a request for each parameter or for many       RequestPoller
    list                 64 once, then 63                                   RequestPoller
    stream, stroke0 … 4  71, 7F … 83: the unit sends on its own             StreamPoller

A `Poller` runs one cycle a call. Its callers, `watch` and the sampler, decide which parameters a
cycle reads and how to continue after an error.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from math import inf
from typing import Literal, NamedTuple, get_args

from mikas import errors
from mikas.catalog import Parameter
from mikas.client.parameters.parameters import Parameters
from mikas.client.parameters.readings import Reading, Wanted
from mikas.commands import Availability, StreamAtStroke, StreamCyclic
from mikas.i18n import Text
from mikas.options import check_choice
from mikas.tester import Stream, StreamItem

FixedMethod = Literal[
    "single", "batch", "list", "stream", "stroke0", "stroke1", "stroke2", "stroke3", "stroke4"
]
Method = Literal["auto", FixedMethod]
"""How a session samples: by the fastest method that works (auto), or by this one."""

FIXED_METHODS: tuple[FixedMethod, ...] = get_args(FixedMethod)
METHODS: tuple[Method, ...] = get_args(Method)
"""The names that `method` may have."""
STREAMS = frozenset({"stream", *(m for m in FIXED_METHODS if m.startswith("stroke"))})

_SLICE = 0.1  # s that a cycle waits for a silent stream


class Turn(NamedTuple):
    """One request of a cycle: its parameters, by 61, or by 63 if they are `listed`.

    It may be used in many cycles.
    """

    wanted: Wanted
    listed: bool = False


def fixed_method(method: str) -> FixedMethod | None:
    """Return `method`, None for auto. Raises `UsageError` for any other text."""
    check_choice("method", method, METHODS)
    return next((known for known in FIXED_METHODS if known == method), None)


def named_method(method: str) -> FixedMethod:
    """Return the method. Raises `UsageError`, also for auto, which only a session can choose."""
    if method == "auto":
        raise errors.usage_error(
            "auto is the fastest method that works, which mikas.session() measures; watch takes "
            f"one of {', '.join(FIXED_METHODS)}",
            "auto — самый быстрый из работающих способов, его находит mikas.session(); у watch "
            f"способ один из: {', '.join(FIXED_METHODS)}",
        )
    check_choice("method", method, FIXED_METHODS)
    return next(known for known in FIXED_METHODS if known == method)


def check_rate(rate: float | None) -> None:
    """Raise `UsageError` unless `rate`, cycles a second, is more than 0."""
    if rate is not None and not 0 < rate < inf:
        raise errors.usage_error("a rate is more than 0 a second", "частота должна быть больше 0")


def next_due(due: float, now: float, period: float) -> float:
    """Return the time of the cycle after the one due at `due`; lost cycles are not made up for."""
    return max(due, now - period) + period


class Poller(ABC):
    """Reads by one method from one connected unit.

    Between two cycles the line is free, except under a stream, which `close` ends (D12).
    """

    @abstractmethod
    def cycle(self, turns: Sequence[Turn] = (), then: Turn | None = None) -> dict[str, Reading]:
        """Run one cycle of `turns`; return its readings by name.

        `then`: how the next cycle begins, if it follows at once; it is sent before this returns. A
        stream ignores both and returns its next response, or nothing yet. Raises a `LineError`, a
        `NoConnection`, or an `EcuRefused` if the unit refuses the method.
        """

    @abstractmethod
    def is_refusal(self, error: errors.MikasError) -> bool:
        """Whether `error` of `cycle` may be the unit's refusal of the method or of a parameter."""

    def use(self, parameters: Sequence[Parameter]) -> None:  # noqa: B027  (no stream: nothing)
        """Decode a stream by other `parameters` of the same data from here on; it goes on."""

    @abstractmethod
    def close(self) -> None:
        """Leave the line quiet; `cycle` may be called again. May raise a `LineError`."""


@dataclass(slots=True, eq=False)
class RequestPoller(Poller):
    """61, 63 and 64. `again`: the first cycle also requests parameters refused before."""

    _parameters: Parameters
    _single: bool
    _again: bool = False

    def cycle(self, turns: Sequence[Turn] = (), then: Turn | None = None) -> dict[str, Reading]:
        readings: dict[str, Reading] = {}
        for turn, following in zip(turns, [*turns[1:], then], strict=True):
            if following is not None and not self._again:
                self._parameters.announce(following.wanted, listed=following.listed)
            readings |= self._read(turn)
        self._again = False
        return readings

    def _read(self, turn: Turn) -> dict[str, Reading]:
        if turn.listed:
            return self._parameters.through_list(turn.wanted)
        return self._parameters.fetch(turn.wanted, single=self._single, again=self._again)

    def close(self) -> None:
        self._parameters.tester.settle()

    def is_refusal(self, error: errors.MikasError) -> bool:
        return isinstance(error, errors.EcuRefused | errors.NoResponse | errors.WrongLength)


class StreamPoller(Poller):
    """71, or 7F … 83 with `stroke`: the unit sends `wanted` on its own.

    A stopped stream is started again (D12).
    """

    def __init__(
        self, parameters: Parameters, wanted: Sequence[Parameter], stroke: int | None
    ) -> None:
        self._parameters = parameters
        self._tester = parameters.tester
        self._wanted = parameters.wanted(wanted)
        self._stroke = stroke
        self._stream: Stream | None = None
        self._heard = 0.0
        self._works = False  # whether a response has ever been received
        self._silent = 0  # silences in a row, though the unit answers and could have sent

    def cycle(
        self,
        turns: Sequence[Turn] = (),  # noqa: ARG002  (all cycles are equal)
        then: Turn | None = None,  # noqa: ARG002  (the unit sends the next one by itself)
    ) -> dict[str, Reading]:
        """As `Poller.cycle`. A damaged response does not end the stream.

        Raises `NotSupported` if the unit does not start it, `NoResponse` if the unit answers, but
        its stream has stopped, `EngineStopped` for a stream by strokes without strokes.
        """
        while True:
            try:
                item = self._next()
            except StopIteration:
                self._stream = None  # closed by another caller: start it again
            except errors.NoResponse as error:
                reason = self._end() or self._why_silent(error)
                if self._works or not self._silent or reason is not error:
                    raise reason from error
                if self._silent > 1:  # the request of the first may have been lost
                    raise self._not_supported(error) from error
            except errors.ReadingSuspended as error:
                if error.is_short and self._stream is not None:  # it goes on
                    self._heard = self._tester.link.now()
                    return {}
                self._end()
                raise
            except errors.MikasError as error:
                if isinstance(error, errors.LineError) and self._stream is not None:
                    # Only one response was damaged: the unit sends.
                    self._heard, self._silent = self._tester.link.now(), 0
                else:
                    self._end()
                raise
            else:
                if item is None:
                    return {}
                self._works, self._silent, self._heard = True, 0, self._tester.link.now()
                return self._wanted.of_item(item)

    def is_refusal(self, error: errors.MikasError) -> bool:
        return isinstance(error, errors.EcuRefused) or self._silent > 1

    def use(self, parameters: Sequence[Parameter]) -> None:
        wanted = self._parameters.wanted(parameters)
        if wanted.data != self._wanted.data:
            raise ValueError("the unit sends other data")
        self._wanted = wanted

    def close(self) -> None:
        stream, self._stream = self._stream, None
        if stream is not None:
            with suppress(errors.NoConnection):  # no ECU, so no stream
                stream.close()

    def _next(self) -> StreamItem | None:
        if self._stream is None:
            self._stream = self._parameters.stream(self._wanted, self._stroke)
            self._heard = self._tester.link.now()
        until = self._heard + self._stream.silence
        deadline = min(until, self._tester.link.now() + _SLICE)
        # Until a response has fitted, one that does not fit may be a refusal of so many parameters.
        item = self._stream.read(deadline, raise_errors=self._works)
        if item is None and not self._stream.running:
            raise StopIteration
        if item is None and self._tester.link.now() >= until:
            raise self._stream.fallen_silent()
        return item

    def _end(self) -> errors.NoConnection | None:
        """End the stream after a failure; return a `NoConnection` met by that, or None."""
        stream, self._stream = self._stream, None
        if stream is not None:
            try:
                stream.close()
            except errors.NoConnection as error:
                return error
            except errors.MikasError:  # the same failure, or a consequence of it
                pass
        return None

    def _why_silent(self, error: errors.NoResponse) -> errors.LineError | errors.NoConnection:
        """Return the reason of a silence; count the silence if the unit could have sent."""
        try:
            self._tester.request(Availability())
            if self._stroke is None:
                self._silent += 1
                return error
            rpm = self._parameters.read(["FREQ"])["FREQ"]
        except errors.LinkLost:
            raise
        except (errors.LineError, errors.NoConnection) as cause:
            return cause
        except errors.NotSupported:
            return error
        if rpm.value:
            self._silent += 1
            return error
        self._silent = 0
        return errors.EngineStopped(
            seconds=error.fields["seconds"],
            request=error.request,
            received=error.received,
            time=error.time,
        )

    def _not_supported(self, error: errors.NoResponse) -> errors.NotSupported:
        cyclic = self._stroke is None
        code = StreamCyclic.CODES[0] if cyclic else StreamAtStroke.CODES[self._stroke or 0]
        count = len(self._wanted.parameters)
        command = Text(
            f"a stream ({code:02X}) of parameters ({count})",
            f"потока ({code:02X}) с числом параметров {count}",
        )
        return errors.NotSupported(
            command=command, request=error.request, received=b"", time=error.time
        )


def create_poller(
    parameters: Parameters,
    method: FixedMethod,
    streamed: Sequence[Parameter] = (),
    *,
    again: bool = False,
) -> Poller:
    """Create the poller of `method`; `streamed`: the parameters of a stream."""
    if method in STREAMS:
        stroke = int(method[-1]) if method.startswith("stroke") else None
        return StreamPoller(parameters, streamed, stroke)
    return RequestPoller(parameters, method == "single", again)
