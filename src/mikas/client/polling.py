"""Parameters read again and again, cycle by cycle, by each method (§3 rows 61, 63, 71, 7F–83).

    single, batch        61, a request for each parameter or for many       RequestPoller
    list                 64 once, then 63                                   RequestPoller
    stream, stroke0 … 4  71, 7F … 83: the unit sends on its own             StreamPoller

A `Poller` runs one cycle a call. Its callers, `watch` and the sampler, decide which parameters a
cycle reads and how to continue after an error.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Generator, Sequence
from contextlib import closing
from math import inf
from typing import Literal, get_args

from mikas.catalog import Parameter
from mikas.client.data import refused
from mikas.client.parameters import Parameters, Reading, Sample
from mikas.client.streaming import ReadingStream
from mikas.errors import (
    EcuRefused,
    LineError,
    LinkLost,
    MikasError,
    NoConnection,
    NoResponse,
    NotSupported,
    WrongLength,
    usage_error,
)
from mikas.options import check_choice
from mikas.tester import Tester

FixedMethod = Literal[
    "single", "batch", "list", "stream", "stroke0", "stroke1", "stroke2", "stroke3", "stroke4"
]
Method = Literal["auto", FixedMethod]

FIXED_METHODS: tuple[FixedMethod, ...] = get_args(FixedMethod)
METHODS: tuple[Method, ...] = get_args(Method)
STREAMS = frozenset({"stream", *(m for m in FIXED_METHODS if m.startswith("stroke"))})

_SLICE = 0.1  # s that a cycle waits for a silent stream

Requests = Sequence[Sequence[Parameter]]
"""The parameters of each request of a cycle."""


def fixed_method(method: str) -> FixedMethod | None:
    """Return `method`, None for auto. Raises `UsageError` for any other text."""
    check_choice("method", method, METHODS)
    return next((known for known in FIXED_METHODS if known == method), None)


def check_rate(rate: float | None) -> None:
    """Raise `UsageError` unless `rate`, cycles a second, is more than 0."""
    if rate is not None and not 0 < rate < inf:
        raise usage_error("a rate is more than 0 a second", "частота должна быть больше 0")


def next_due(due: float, now: float, period: float) -> float:
    """Return the time of the cycle after the one due at `due`; lost cycles are not made up for."""
    return max(due, now - period) + period


class Poller(ABC):
    """Reads by one method from one connected unit.

    Between two cycles the line is free, except under a stream, which `close` ends (D12).
    """

    def __init__(self, parameters: Parameters) -> None:
        self._parameters = parameters

    @abstractmethod
    def cycle(
        self, requests: Requests = (), listed: Sequence[Parameter] = ()
    ) -> dict[str, Reading]:
        """Run one cycle; return its readings by name: by 61 for `requests`, by 63 for `listed`.

        A stream ignores both and returns its next response, or nothing yet. Raises a `LineError`, a
        `NoConnection`, or an `EcuRefused` if the unit refuses the method.
        """

    def refuses(self, parameters: Sequence[Parameter]) -> bool:
        """Whether the unit is known to refuse every one of `parameters`."""
        return self._parameters.refuses(parameters)

    @abstractmethod
    def is_refusal(self, error: MikasError) -> bool:
        """Whether `error` of `cycle` may be the unit's refusal of the method or of a parameter."""

    def close(self) -> None:  # noqa: B027  (only streams have to be ended)
        """Leave the line quiet; `cycle` may be called again. May raise a `LineError`."""


class RequestPoller(Poller):
    """61, 63 and 64. `again`: the first cycle also requests parameters refused before."""

    def __init__(
        self, parameters: Parameters, *, single: bool = False, again: bool = False
    ) -> None:
        super().__init__(parameters)
        self._method = "single" if single else "batch"
        self._again = again

    def cycle(
        self, requests: Requests = (), listed: Sequence[Parameter] = ()
    ) -> dict[str, Reading]:
        readings: dict[str, Reading] = {}
        for request in requests:
            got = self._parameters.fetch(request, self._method, again=self._again)
            readings |= self._parameters.readings(request, got)
        self._again = False
        if listed:
            readings |= self._parameters.through_list(tuple(listed))
        return readings

    def is_refusal(self, error: MikasError) -> bool:
        return isinstance(error, EcuRefused | NoResponse | WrongLength)


class StreamPoller(Poller):
    """71, or 7F … 83 with `stroke`: the unit sends `streamed` on its own."""

    def __init__(
        self,
        tester: Tester,
        parameters: Parameters,
        streamed: Sequence[Parameter],
        stroke: int | None,
    ) -> None:
        super().__init__(parameters)
        self._stream = ReadingStream(tester, parameters, streamed, stroke)

    def cycle(
        self,
        requests: Requests = (),  # noqa: ARG002  (all cycles are equal)
        listed: Sequence[Parameter] = (),  # noqa: ARG002
    ) -> dict[str, Reading]:
        response = self._stream.next(_SLICE)
        return {} if response is None else response[1]

    def is_refusal(self, error: MikasError) -> bool:
        return isinstance(error, EcuRefused) or self._stream.silent > 1

    def close(self) -> None:
        self._stream.close()


def create_poller(
    tester: Tester,
    parameters: Parameters,
    method: FixedMethod,
    streamed: Sequence[Parameter] = (),
    *,
    again: bool = False,
) -> Poller:
    """Create the poller of `method`; `streamed`: the parameters of a stream."""
    if method in STREAMS:
        stroke = int(method[-1]) if method.startswith("stroke") else None
        return StreamPoller(tester, parameters, streamed, stroke)
    return RequestPoller(parameters, single=method == "single", again=again)


class Watcher:
    """One watch of the parameters of these names, at most `rate` samples a second."""

    def __init__(
        self,
        tester: Tester,
        parameters: Parameters,
        names: Sequence[str],
        method: FixedMethod,
        rate: float | None,
    ) -> None:
        check_rate(rate)
        self._tester = tester
        self._parameters = parameters
        self._wanted = parameters.named(names)
        self._method = method
        self._poller = create_poller(tester, parameters, method, self._wanted, again=bool(names))
        self._period = 1 / rate if rate else 0.0
        self._due: float | None = None
        self._worked = False

    def samples(self, count: int | None = None) -> Generator[Sample, None, None]:
        """Yield `count` samples, or samples without end; a failed cycle is a sample with a gap.

        Raises `LinkLost`, `NotSupported` if the unit refuses the method or every parameter.
        """
        if count is not None and count < 0:
            raise usage_error("a count is 0 or more", "число отсчётов — от 0")
        samples = self._samples()
        return samples if count is None else _first(samples, count)

    def _samples(self) -> Generator[Sample, None, None]:
        with closing(self._poller):
            while True:
                try:
                    readings = self._cycle()
                except LinkLost:
                    raise
                except (LineError, NoConnection) as error:
                    yield self._gap(error)
                except NotSupported as error:
                    if not (self._worked and self._method == "list"):
                        raise
                    yield self._gap(error)
                else:
                    if readings:
                        self._worked = True
                        yield Sample(min(r.time for r in readings.values()), readings)
                    elif self._method not in STREAMS:
                        yield self._gap(refused(self._wanted[0].name, self._wanted[0].code))

    def _cycle(self) -> dict[str, Reading]:
        """Run the next cycle when it is due; return {} without readings in time."""
        if self._method in STREAMS:
            readings = self._poller.cycle()
            times = [reading.time for reading in readings.values()]
            return readings if times and self._is_due(min(times)) else {}
        self._wait()
        if self._method == "list":
            return self._poller.cycle(listed=self._wanted)
        readings = self._poller.cycle([self._wanted])
        if not readings and self._poller.refuses(self._wanted):
            # Every request would be skipped, and a log would stay empty without an error.
            raise refused(self._wanted[0].name, self._wanted[0].code)
        return readings

    def _wait(self) -> None:
        if self._period:
            if self._due is not None:
                self._tester.wait(self._due)
            now = self._tester.link.now()
            self._due = next_due(now if self._due is None else self._due, now, self._period)

    def _is_due(self, time: float) -> bool:
        """Whether a stream's response of this time is due; if so, set the next due time."""
        if self._due is not None and time < self._due:
            return False
        self._due = next_due(time if self._due is None else self._due, time, self._period)
        return True

    def _gap(self, error: MikasError) -> Sample:
        if self._method == "list":
            # After a power cycle the unit has lost its list.
            self._parameters.forget_list()
        return Sample(self._tester.link.now(), error=error)


def _first(samples: Generator[Sample, None, None], count: int) -> Generator[Sample, None, None]:
    """Yield the first `count` samples; end the method before the last one is yielded."""
    with closing(samples):
        for _ in range(count - 1):
            yield next(samples)
        if count == 0:
            return
        last = next(samples)
    yield last
