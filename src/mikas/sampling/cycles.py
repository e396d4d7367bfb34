"""The cycles of a plan on one unit: what is due in each, read by the plan's method."""

from __future__ import annotations

from mikas.catalog import Parameter
from mikas.client import Ecu, Reading
from mikas.client.ecu import poller_of
from mikas.client.polling import STREAMS
from mikas.commands import Datum
from mikas.errors import MikasError, NoResponse
from mikas.sampling.identity_check import IdentityCheck
from mikas.sampling.plan import Plan


class PlanCycles:
    """Runs `plan` on `ecu`, cycle by cycle. `identity_check`: whether that is still the same unit.

    Between two cycles the line is free, except under a stream, which `pause` ends (D12).
    """

    def __init__(self, ecu: Ecu, plan: Plan, identity_check: IdentityCheck | None = None) -> None:
        self.ecu = ecu
        self.plan = plan
        self.identity_check = identity_check
        self._parameters: dict[Datum, list[Parameter]] = {}
        for planned in plan.parameters:
            parameter = planned.parameter
            named = self._parameters.setdefault(Datum(parameter.code, parameter.size), [])
            if parameter not in named:
                named.append(parameter)
        self._streams = plan.method in STREAMS
        self._poller = poller_of(ecu, plan.method, self._named(plan.fast))
        if plan.method == "list":
            ecu.forget_list()  # the unit may have lost its supply since it was set

    def _named(self, data: tuple[Datum, ...]) -> list[Parameter]:
        return [parameter for datum in data for parameter in self._parameters[datum]]

    def expected(self, number: int) -> int:
        """How many readings cycle `number` brings at least, if everything is answered."""
        if self._streams:
            return 0  # a response holds all of them, or is damaged
        if self.plan.method == "list":
            return len(self._listed(number))
        return len(self._named(self.plan.due(number)))

    def run(self, number: int) -> dict[str, Reading]:
        """Run cycle `number` (from 0) and return its readings by name.

        Empty if nothing is due, or a stream has sent nothing yet. Raises a `LineError`, a
        `NoConnection`, or an `EcuRefused` if the unit refuses the method; `SyncLost` also if
        another unit answers, or may.
        """
        requests = [self._named(request) for request in self.plan.requests(number)]
        try:
            fresh = self._poller.cycle(requests, self._listed(number))
        except NoResponse:
            if self._streams and self.identity_check:
                self.identity_check.suspect()
            raise
        if fresh and self.identity_check:
            self.identity_check.check(self.ecu, self.pause)
        return fresh

    def _listed(self, number: int) -> list[Parameter]:
        return self._named(self.plan.fast) if self.plan.reads_list(number) else []

    def refuses(self, parameter: Parameter) -> bool:
        """Whether the unit is known to refuse `parameter`."""
        return self._poller.refuses([parameter])

    def is_refusal(self, error: MikasError) -> bool:
        """Whether `error` of `run` may be the unit's answer to the method or to a parameter."""
        return self._poller.is_refusal(error)

    def pause(self) -> None:
        """Leave the line quiet; `run` may be called again. May raise a `LineError`."""
        self._poller.close()
