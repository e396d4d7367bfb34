"""Readings again and again, by the method that was chosen (§3 rows 61, 63, 71, 7F–83)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import inf
from typing import Literal, get_args

from mikas.catalog import Parameter
from mikas.client.parameters import Parameters
from mikas.client.reading import Sample
from mikas.errors import EcuRefused, LineError, LinkLost, NoConnection, UsageError
from mikas.language import Text
from mikas.tester import Tester

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


class Watcher:
    """Runs one watch. A cycle that brought nothing is a sample with a gap; the next one is
    tried.
    """

    def __init__(
        self,
        tester: Tester,
        parameters: Parameters,
        wanted: Sequence[Parameter],
        rate: float | None,
    ) -> None:
        if rate is not None and not 0 < rate < inf:
            raise UsageError(
                problem=Text("a rate is more than 0 a second", "частота должна быть больше 0")
            )
        self._tester = tester
        self._parameters = parameters
        self._wanted = wanted
        self._names = [p.name for p in wanted]
        self._period = 1 / rate if rate else 0.0

    def samples(self, method: str) -> Iterator[Sample]:
        """Samples for ever. Raises `LinkLost`, and what says that the method itself is refused."""
        match method:
            case "auto" | "batch" | "single":
                return self._asked("single" if method == "single" else "batch")
            case "list":
                return self._from_list()
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

    def _asked(self, method: str) -> Iterator[Sample]:
        due = self._tester.link.now()
        while True:
            due = self._pace(due)
            try:
                got = self._parameters.fetch(self._wanted, method)
            except LinkLost:
                raise
            except (LineError, NoConnection) as error:
                yield self._gap(error)
                continue
            readings = self._parameters.readings(self._wanted, got)
            began = min((r.time for r in readings.values()), default=self._tester.link.now())
            yield Sample(began, readings)

    def _from_list(self) -> Iterator[Sample]:
        self._parameters.set_list(self._names)
        due = self._tester.link.now()
        lost = False
        while True:
            due = self._pace(due)
            try:
                if lost:
                    # The supply may have been off meanwhile, and the unit has forgotten its list.
                    self._parameters.set_list(self._names)
                    lost = False
                readings = self._parameters.read_list()
            except LinkLost:
                raise
            except (LineError, NoConnection) as error:
                lost = True
                yield self._gap(error)
                continue
            yield Sample(next(iter(readings.values())).time, readings)

    def _streamed(self, stroke: int | None) -> Iterator[Sample]:
        shown = -inf
        while True:
            try:
                with self._parameters.raw_stream(self._wanted, stroke) as stream:
                    for item in stream:
                        if item.time - shown >= self._period:
                            shown = item.time
                            yield Sample(item.time, self._parameters.of_item(self._wanted, item))
            except LinkLost:
                raise
            except (LineError, NoConnection) as error:
                yield self._gap(error)

    def _pace(self, due: float) -> float:
        """Waits until `due`; returns when the next cycle is."""
        if not self._period:
            return due
        self._tester.wait(due)
        # After a delay it goes on from now, lest it runs after what can't be caught up.
        return max(due, self._tester.link.now() - self._period) + self._period

    def _gap(self, error: LineError | NoConnection | EcuRefused) -> Sample:
        return Sample(self._tester.link.now(), reason=error)
