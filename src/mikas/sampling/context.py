"""What the parts of a sampler share: what is wanted, what is known of the unit, what came last."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf

from mikas.catalog import Parameter
from mikas.client import Ecu, Reading
from mikas.client.polling import FixedMethod, check_rate, next_due
from mikas.commands import Datum
from mikas.sampling.events import Sampled
from mikas.sampling.jobs import JobQueue
from mikas.sampling.method_knowledge import MethodKnowledge
from mikas.sampling.plan import Plan, PlannedParameter

_SLICE = 0.1  # s that a wait for the next cycle lasts before others get a look in


@dataclass(frozen=True)
class SamplingRequest:
    """What is wanted, until another is. `again`: also what the unit has refused before."""

    parameters: tuple[PlannedParameter, ...]
    method: FixedMethod | None = None
    rate: float | None = None
    retry_refused: bool = False

    def __post_init__(self) -> None:
        Plan(self.parameters).check()
        check_rate(self.rate)


class SamplingContext:
    """`strict` counts until `begun`: until the first sample ever."""

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
        """Names that were told to be refused."""
        self.due = -inf
        """When the next cycle begins, if a rate is wanted, or the one that runs asks nothing."""
        self._last: dict[str, Reading] = {}

    def forget_unit(self) -> None:
        """What was known was known of another one, or is to be forgotten."""
        self.knowledge = MethodKnowledge()
        self.refused.clear()
        self.dropped.clear()
        self._last.clear()

    def start_request(self, requested: SamplingRequest) -> None:
        """What held for the requested before does not hold for `requested`."""
        self.due = -inf
        if requested.retry_refused:
            self.refused.clear()
            self.dropped.clear()
        if requested.method is not None:
            self.knowledge.reset_failures(requested.method)

    def is_current(self, requested: SamplingRequest) -> bool:
        """Whether `requested` is what is wanted, and anything at all."""
        return requested is self.request and not self.relearn and not self.stopped

    def sample_of(self, fresh: dict[str, Reading]) -> Sampled:
        """What came, with the last known of what did not."""
        self.has_sampled = True
        stale = {name: r for name, r in self._last.items() if name not in fresh}
        self._last.update(fresh)
        return Sampled(min(r.time for r in fresh.values()), fresh, stale)

    def is_due(self, sampled: Sampled) -> bool:
        """Whether it is not sooner than the rate that is wanted; sets when the next is due."""
        if not self.request.rate:
            return True
        if sampled.time < self.due:
            return False
        self._schedule_after(sampled.time, 1 / self.request.rate)
        return True

    def schedule_empty_cycle(self, time: float, length: float) -> None:
        """The cycle that begins at `time` asks for nothing: it lasts what the rate that is wanted
        makes of one, else `length`.
        """
        if self.request.rate:
            self._schedule_after(time, 1 / self.request.rate)
        else:
            self.due = time + length

    def _schedule_after(self, time: float, period: float) -> None:
        self.due = next_due(time if self.due == -inf else self.due, time, period)

    def forget_values_outside(self, plan: Plan) -> None:
        """What is not asked any more is not stale, but gone."""
        names = {wanted.parameter.name for wanted in plan.parameters}
        self._last = {name: r for name, r in self._last.items() if name in names}

    def wait_until_due(
        self, ecu: Ecu, requested: SamplingRequest, due: float | None = None
    ) -> bool:
        """Waits until `due`, or the next sample is; False: somebody wants something before."""
        due = self.due if due is None else due
        now = ecu.tester.link.now
        while now() < due:
            if self.jobs or not self.is_current(requested):
                return False
            ecu.tester.wait(min(due, now() + _SLICE))
        return True


def datum_of(parameter: Parameter) -> Datum:
    """What of the unit it is read from."""
    return Datum(parameter.code, parameter.size)
