"""One cycle of a plan, by each method: what is sent, what comes (§3 rows 61, 63, 71, 7F–83).

A `Cycles` runs one plan on one connected unit. `run(number)` does one cycle; between two of them
the line is free, save under a stream, which `close` ends (D12).
"""

from __future__ import annotations

from abc import ABC, abstractmethod

from mikas.catalog import Parameter
from mikas.client import Ecu, Reading
from mikas.commands import Datum
from mikas.sampling.plan import STREAMS, Plan
from mikas.tester import Stream


class Cycles(ABC):
    """Runs `plan` on `ecu`."""

    def __init__(self, ecu: Ecu, plan: Plan) -> None:
        self.ecu = ecu
        self.plan = plan
        self._parameters: dict[Datum, list[Parameter]] = {}
        for wanted in plan.wanted:
            parameter = wanted.parameter
            datum = Datum(parameter.code, parameter.size)
            self._parameters.setdefault(datum, []).append(parameter)

    def _named(self, data: tuple[Datum, ...]) -> list[Parameter]:
        return [parameter for datum in data for parameter in self._parameters[datum]]

    @abstractmethod
    def run(self, number: int) -> dict[str, Reading]:
        """What cycle `number` (from 0) brought, by name. May be empty if nothing had its turn.

        Raises a `LineError`, a `NoConnection`, or an `EcuRefused` if the unit does not take the
        method.
        """

    def close(self) -> None:  # noqa: B027  (most methods leave nothing to end)
        """Leaves the line quiet."""


class Asked(Cycles):
    """61, once for each parameter or for many."""

    def run(self, number: int) -> dict[str, Reading]:
        readings: dict[str, Reading] = {}
        method = "single" if self.plan.method == "single" else "batch"
        for request in self.plan.requests(number):
            named = self._named(request)
            got = self.ecu.parameters.fetch(named, method)
            readings |= self.ecu.parameters.readings(named, got)
        return readings


class Listed(Asked):
    """64 once, then 63; what is wanted less often than that is asked by 61 in between."""

    def run(self, number: int) -> dict[str, Reading]:
        readings = super().run(number)
        if self.plan.reads_list(number):
            readings |= self.ecu.parameters.through_list(tuple(self._named(self.plan.fast)))
        return readings

    def close(self) -> None:
        """Nothing to end; but the unit may have lost its supply when this begins again."""
        self.ecu.parameters.forget_list()


class Streamed(Cycles):
    """71, or 7F … 83: the unit sends by itself."""

    def __init__(self, ecu: Ecu, plan: Plan) -> None:
        super().__init__(ecu, plan)
        self._named_ones = self._named(plan.fast)
        self._stream: Stream | None = None

    def run(self, number: int) -> dict[str, Reading]:  # noqa: ARG002  (every cycle is alike)
        if self._stream is None:
            stroke = None if self.plan.method == "stream" else int(self.plan.method[-1])
            self._stream = self.ecu.parameters.raw_stream(self._named_ones, stroke)
        try:
            item = next(self._stream)
        except BaseException:
            self.close()
            raise
        return self.ecu.parameters.of_item(self._named_ones, item)

    def close(self) -> None:
        """Ends the stream."""
        stream, self._stream = self._stream, None
        if stream is not None:
            stream.close()


def cycles_of(ecu: Ecu, plan: Plan) -> Cycles:
    """The runner that `plan`'s method needs."""
    if plan.method in STREAMS:
        return Streamed(ecu, plan)
    return Listed(ecu, plan) if plan.method == "list" else Asked(ecu, plan)
