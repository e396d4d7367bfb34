"""Readings again and again, by the method that was chosen (§3 rows 61, 63, 71, 7F–83)."""

from __future__ import annotations

from collections.abc import Generator, Sequence
from contextlib import closing
from math import inf
from typing import Literal, get_args

from mikas.client.data import refused
from mikas.client.parameters import Parameters
from mikas.client.reading import Sample
from mikas.commands import Availability, StreamAtStroke, StreamCyclic
from mikas.errors import LineError, LinkLost, NoConnection, NoResponse, NotSupported, UsageError
from mikas.language import Text
from mikas.tester import StreamItem, Tester

Method = Literal[
    "auto",
    "single",
    "batch",
    "list",
    "stream",
    "stroke0",
    "stroke1",
    "stroke2",
    "stroke3",
    "stroke4",
]
METHODS: tuple[str, ...] = get_args(Method)

Samples = Generator[Sample, None, None]

_STANDS = Text(
    "A stream by strokes comes only while the engine turns.",
    "Поток по тактам идёт, только пока двигатель вращается.",
)


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
        match method:
            case "auto" | "batch" | "single":
                return self._asked("single" if method == "single" else "batch")
            case "list":
                return self._listed()
            case "stream":
                return self._streamed(None)
            case _ if method in METHODS:
                return self._streamed(int(method[-1]))
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
        works = False
        silent = 0
        while True:
            try:
                with self._parameters.raw_stream(self._wanted, stroke) as stream:
                    for item in stream:
                        works = True
                        if due is None or item.time >= due:
                            due = self._next(item.time if due is None else due, item.time)
                            yield self._of(item)
            except LinkLost:
                raise
            except NoResponse as error:
                reason, there = self._why_silent(error, stroke)
                if there and not works:
                    silent += 1
                    if silent == 1:
                        continue  # one request may have been lost
                    raise self._no_stream(stroke, error) from error
                yield self._gap(reason)
            except (LineError, NoConnection) as error:
                yield self._gap(error)

    def _of(self, item: StreamItem) -> Sample:
        return Sample(item.time, self._parameters.of_item(self._wanted, item))

    def _why_silent(
        self, error: NoResponse, stroke: int | None
    ) -> tuple[LineError | NoConnection, bool]:
        """What kept a stream silent, and whether the unit could well have sent."""
        try:
            self._tester.request(Availability())
            if stroke is None:
                return error, True
            rpm = self._parameters.read(["FREQ"])["FREQ"]
        except LinkLost:
            raise
        except (LineError, NoConnection) as nobody:
            return nobody, False
        except NotSupported:
            return error, False
        if not rpm.value:
            error.to_try = _STANDS
        return error, bool(rpm.value)

    def _no_stream(self, stroke: int | None, error: NoResponse) -> NotSupported:
        code = StreamCyclic.CODES[0] if stroke is None else StreamAtStroke.CODES[stroke]
        count = len(self._wanted)
        command = Text(
            f"a stream ({code:02X}) of {count} parameter(s)",
            f"потока ({code:02X}) с числом параметров {count}",
        )
        return NotSupported(command=command, request=error.request, received=b"", time=error.time)

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
