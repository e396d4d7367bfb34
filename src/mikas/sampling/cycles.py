"""One cycle of a plan, by each method: what is sent, what comes (§3 rows 61, 63, 71, 7F–83).

A `Cycles` runs one plan on one connected unit. `run(number)` does one cycle; between two of them
the line is free, save under a stream, which `pause` ends (D12).
"""

from __future__ import annotations

from abc import ABC, abstractmethod

from mikas.catalog import Parameter
from mikas.client import Ecu, Reading
from mikas.client.methods import STREAMS, stroke_of
from mikas.client.streaming import ReadingStream
from mikas.commands import Datum
from mikas.errors import EcuRefused, MikasError, NoResponse, WrongLength
from mikas.sampling.identity_check import IdentityCheck
from mikas.sampling.plan import Plan

_SLICE = 0.1  # s that a silent stream is waited for before others get a look in


class Cycles(ABC):
    """Runs `plan` on `ecu`. `doubt`: whether that is still the unit it was."""

    def __init__(self, ecu: Ecu, plan: Plan, identity_check: IdentityCheck | None = None) -> None:
        self.ecu = ecu
        self.plan = plan
        self.identity_check = identity_check
        self._parameters: dict[Datum, list[Parameter]] = {}
        for wanted in plan.parameters:
            parameter = wanted.parameter
            named = self._parameters.setdefault(Datum(parameter.code, parameter.size), [])
            if parameter not in named:
                named.append(parameter)

    def _named(self, data: tuple[Datum, ...]) -> list[Parameter]:
        return [parameter for datum in data for parameter in self._parameters[datum]]

    def expected(self, number: int) -> int:
        """How many readings cycle `number` should bring, if everything is answered."""
        return len(self._named(self.plan.due(number)))

    def run(self, number: int) -> dict[str, Reading]:
        """What cycle `number` (from 0) brought, by name. May be empty if nothing had its turn.

        Raises a `LineError`, a `NoConnection`, or an `EcuRefused` if the unit does not take the
        method; `SyncLost` also if it is, or may be, another unit that answers.
        """
        fresh = self._run(number)
        if fresh and self.identity_check:
            self.identity_check.check(self.ecu, self.pause)
        return fresh

    @abstractmethod
    def _run(self, number: int) -> dict[str, Reading]:
        """As `run`, whoever it was that answered."""

    def let_down(self, error: MikasError) -> bool:
        """Whether `error` of `run` may be the unit's answer to this method or to a parameter."""
        return isinstance(error, EcuRefused | NoResponse | WrongLength)

    def pause(self) -> None:  # noqa: B027  (most methods leave nothing to end)
        """Leaves the line quiet; `run` goes on all the same. May raise a `LineError`."""


class Asked(Cycles):
    """61, once for each parameter or for many."""

    def _run(self, number: int) -> dict[str, Reading]:
        readings: dict[str, Reading] = {}
        method = "single" if self.plan.method == "single" else "batch"
        for request in self.plan.requests(number):
            named = self._named(request)
            got = self.ecu.parameters.fetch(named, method)
            readings |= self.ecu.parameters.readings(named, got)
        return readings


class Listed(Asked):
    """64 once, then 63; what is wanted less often than that is asked by 61 in between."""

    def __init__(self, ecu: Ecu, plan: Plan, identity_check: IdentityCheck | None = None) -> None:
        super().__init__(ecu, plan, identity_check)
        ecu.parameters.forget_list()  # the unit may have lost its supply since it was set

    def expected(self, number: int) -> int:
        return len(self._named(self.plan.fast)) if self.plan.reads_list(number) else 0

    def _run(self, number: int) -> dict[str, Reading]:
        readings = super()._run(number)
        if self.plan.reads_list(number):
            readings |= self.ecu.parameters.through_list(tuple(self._named(self.plan.fast)))
        return readings


class Streamed(Cycles):
    """71, or 7F … 83: the unit sends by itself. A cycle may be empty while it is silent."""

    def __init__(self, ecu: Ecu, plan: Plan, identity_check: IdentityCheck | None = None) -> None:
        super().__init__(ecu, plan, identity_check)
        self._stream = ReadingStream(
            ecu.tester, ecu.parameters, self._named(plan.fast), stroke_of(plan.method)
        )

    def expected(self, number: int) -> int:  # noqa: ARG002  (a response has all or is damaged)
        return 0

    def _run(self, number: int) -> dict[str, Reading]:  # noqa: ARG002  (every cycle is alike)
        try:
            came = self._stream.next(_SLICE)
        except NoResponse:
            if self.identity_check:
                self.identity_check.suspect()
            raise
        return {} if came is None else came[1]

    def let_down(self, error: MikasError) -> bool:
        return isinstance(error, EcuRefused) or self._stream.silent > 1

    def pause(self) -> None:
        self._stream.close()


def cycles_of(ecu: Ecu, plan: Plan, identity_check: IdentityCheck | None = None) -> Cycles:
    """The runner that `plan`'s method needs."""
    if plan.method in STREAMS:
        return Streamed(ecu, plan, identity_check)
    return (
        Listed(ecu, plan, identity_check)
        if plan.method == "list"
        else Asked(ecu, plan, identity_check)
    )
