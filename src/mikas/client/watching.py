"""Readings again and again, by the method that was chosen (§3 rows 61, 63, 71, 7F–83)."""

from __future__ import annotations

from collections.abc import Generator, Sequence
from contextlib import closing
from math import inf

from mikas.client.data import refused
from mikas.client.methods import METHODS, STREAMS, stroke_of
from mikas.client.parameters import Parameters
from mikas.client.reading import Sample
from mikas.client.streaming import ReadingStream
from mikas.errors import LineError, LinkLost, NoConnection, NotSupported, UsageError
from mikas.i18n import Text
from mikas.tester import Tester

Samples = Generator[Sample, None, None]


class Watcher:
    """Runs one watch of the parameters of these names. A cycle that brought nothing is a sample
    with a gap; the next one is tried.
    """

    def __init__(
        self, tester: Tester, parameters: Parameters, names: Sequence[str], rate: float | None
    ) -> None:
        if rate is not None and not 0 < rate < inf:
            raise UsageError(
                problem=Text("a rate is more than 0 a second", "частота должна быть больше 0")
            )
        self._tester = tester
        self._parameters = parameters
        self._wanted = parameters.named(names)
        self._named = bool(names)
        self._period = 1 / rate if rate else 0.0

    def samples(self, method: str, count: int | None = None) -> Samples:
        """`count` samples, or samples for ever. They are to be closed, as every generator.

        Raises `LinkLost`, and what says that the method itself is refused.
        """
        samples = self._by(method)
        if count is None:
            return samples
        if count < 0:
            raise UsageError(problem=Text("a count is 0 or more", "число отсчётов — от 0"))
        return _limited(samples, count)

    def _by(self, method: str) -> Samples:
        if method == "list":
            return self._listed()
        if method in STREAMS:
            return self._streamed(stroke_of(method))
        if method in METHODS:
            return self._asked("single" if method == "single" else "batch")
        raise UsageError(
            problem=Text(
                f"there is no method “{method}”; there are {', '.join(METHODS)}",
                f"метода «{method}» нет; есть {', '.join(METHODS)}",
            )
        )

    def _asked(self, method: str) -> Samples:
        due = self._tester.link.now()
        again = self._named
        while True:
            due = self._pace(due)
            try:
                got = self._parameters.fetch(self._wanted, method, again=again)
                again = False
            except LinkLost:
                raise
            except (LineError, NoConnection) as error:
                yield self._gap(error)
                continue
            if got:
                readings = self._parameters.readings(self._wanted, got)
                yield Sample(min(r.time for r in readings.values()), readings)
            elif self._parameters.refuses(self._wanted):
                raise self._refused()  # nothing would be asked any more, and the log stay empty
            else:
                yield self._gap(self._refused())

    def _refused(self) -> NotSupported:
        return refused(self._wanted[0].name, self._wanted[0].code)

    def _listed(self) -> Samples:
        due = self._tester.link.now()
        works = False
        while True:
            due = self._pace(due)
            try:
                readings = self._parameters.through_list(self._wanted)
            except LinkLost:
                raise
            except (LineError, NoConnection, NotSupported) as error:
                if isinstance(error, NotSupported) and not works:
                    raise
                # The supply may have been off, and the unit has forgotten its list.
                self._parameters.forget_list()
                yield self._gap(error)
                continue
            works = True
            yield Sample(next(iter(readings.values())).time, readings)

    def _streamed(self, stroke: int | None) -> Samples:
        due: float | None = None
        stream = ReadingStream(self._tester, self._parameters, self._wanted, stroke)
        with closing(stream):
            while True:
                try:
                    came = stream.next()
                except LinkLost:
                    raise
                except (LineError, NoConnection) as error:
                    yield self._gap(error)
                    continue
                if came is not None and (due is None or came[0] >= due):
                    due = self._next(came[0] if due is None else due, came[0])
                    yield Sample(*came)

    def _pace(self, due: float) -> float:
        """Waits until `due`; returns when the next cycle is."""
        if not self._period:
            return due
        self._tester.wait(due)
        return self._next(due, self._tester.link.now())

    def _next(self, due: float, now: float) -> float:
        # After a delay it goes on from now, lest it runs after what can't be caught up.
        return max(due, now - self._period) + self._period

    def _gap(self, error: Exception) -> Sample:
        return Sample(self._tester.link.now(), reason=error)


def _limited(samples: Samples, count: int) -> Samples:
    """The first `count`. The last one comes when all is ended, so nobody has to ask for more."""
    with closing(samples):
        for _ in range(count - 1):
            yield next(samples)
        if count == 0:
            return
        last = next(samples)
    yield last
