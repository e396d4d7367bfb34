"""State shared by the parts of a sampler: the request, the unit's methods, the latest values."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf

from mikas.client import Ecu, Reading
from mikas.client.polling import FixedMethod, check_rate, next_due
from mikas.commands import Datum
from mikas.sampling.events import Sampled
from mikas.sampling.jobs import JobQueue
from mikas.sampling.method_knowledge import MethodKnowledge
from mikas.sampling.plan import Plan, PlannedParameter

_SLICE = 0.1  # s between checks for jobs and new requests during a wait


@dataclass(frozen=True)
class SamplingRequest:
    """A request to sample. `retry_refused`: include parameters that the unit refused before."""

    parameters: tuple[PlannedParameter, ...]
    method: FixedMethod | None = None
    rate: float | None = None
    retry_refused: bool = False

    def __post_init__(self) -> None:
        Plan(self.parameters).check()
        check_rate(self.rate)


class SamplingContext:
    """The shared state; `strict` applies until `has_sampled`, the first sample of the run."""

    def __init__(self, requested: SamplingRequest, jobs: JobQueue, *, strict: bool) -> None:
        self.request = requested
        self.jobs = jobs
        self.strict = strict
        self.stopped = False
        self.relearn = False
        self.has_sampled = False
        self.knowledge = MethodKnowledge()
        self.refused: set[Datum] = set()
        self.dropped: set[str] = set()
        """Names reported as refused."""
        self.due = -inf
        """The beginning of the next cycle, with a rate or in a cycle without requests."""
        self._last: dict[str, Reading] = {}

    def forget_unit(self) -> None:
        """Forget methods, refusals and values of the unit."""
        self.knowledge = MethodKnowledge()
        self.refused.clear()
        self.dropped.clear()
        self._last.clear()

    def start_request(self, requested: SamplingRequest) -> None:
        """Reset the state of the request before `requested`."""
        self.due = -inf
        if requested.retry_refused:
            self.refused.clear()
            self.dropped.clear()
        if requested.method is not None:
            self.knowledge.reset_failures(requested.method)

    def is_current(self, requested: SamplingRequest) -> bool:
        """Return whether `requested` is the latest request, without `stop` or `relearn`."""
        return requested is self.request and not self.relearn and not self.stopped

    def sample_of(self, fresh: dict[str, Reading]) -> Sampled:
        """Return the event of `fresh` readings; the latest of the others are stale."""
        self.has_sampled = True
        stale = {name: r for name, r in self._last.items() if name not in fresh}
        self._last.update(fresh)
        return Sampled(min(r.time for r in fresh.values()), fresh, stale)

    def is_due(self, sampled: Sampled) -> bool:
        """Return whether the requested rate allows `sampled`; if so, set when the next is due."""
        if not self.request.rate:
            return True
        if sampled.time < self.due:
            return False
        self._schedule_after(sampled.time, 1 / self.request.rate)
        return True

    def schedule_empty_cycle(self, time: float, length: float) -> None:
        """End a cycle without requests by the rate, else after `length` seconds."""
        if self.request.rate:
            self._schedule_after(time, 1 / self.request.rate)
        else:
            self.due = time + length

    def _schedule_after(self, time: float, period: float) -> None:
        self.due = next_due(time if self.due == -inf else self.due, time, period)

    def forget_values_outside(self, plan: Plan) -> None:
        """Forget values of parameters outside `plan`, which are not stale but invalid."""
        names = {planned.parameter.name for planned in plan.parameters}
        self._last = {name: r for name, r in self._last.items() if name in names}

    def wait_until_due(
        self, ecu: Ecu, requested: SamplingRequest, due: float | None = None
    ) -> bool:
        """Wait until `due`, by default the next cycle; False: a job or a request came first."""
        due = self.due if due is None else due
        now = ecu.tester.link.now
        while now() < due:
            if self.jobs or not self.is_current(requested):
                return False
            ecu.tester.wait(min(due, now() + _SLICE))
        return True
