"""State shared by the parts of a sampler: the request, the unit's methods, the latest values."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from math import inf
from operator import attrgetter

from mikas.client import Ecu, Reading
from mikas.client.parameters.derived import DerivedChannels, numbers_of
from mikas.client.parameters.polling import FixedMethod, check_rate, next_due
from mikas.commands import Datum
from mikas.errors import LineNotQuiet
from mikas.sampling.alarms import Alarms
from mikas.sampling.events import AlarmChanged, PlanChanged, Sampled
from mikas.sampling.jobs import JobQueue
from mikas.sampling.plan import Plan, Selection
from mikas.sampling.running.method_knowledge import MethodKnowledge

_SLICE = 0.1  # s between checks for jobs and new requests during a wait
_time = attrgetter("time")


@dataclass(frozen=True)
class SamplingRequest:
    """A request to sample. `method` None: the fastest; `rate`: most cycles a second."""

    selection: Selection
    method: FixedMethod | None = None
    rate: float | None = None

    def __post_init__(self) -> None:
        Plan(self.selection.parameters)  # raises `UsageError` for none
        check_rate(self.rate)


@dataclass(eq=False)
class SamplingContext:
    """The shared state; `strict` applies until `has_sampled`, the first sample of the run."""

    request: SamplingRequest
    """The request that is being served."""
    jobs: JobQueue
    strict: bool

    def __post_init__(self) -> None:
        self.latest: SamplingRequest = self.request
        """The latest request, by any thread."""
        self.first: frozenset[str] = frozenset()
        """The parameters that come first (`Plan.preferring`); set by any thread."""
        self.plan: Plan | None = None
        """The plan reported last; None before the first."""
        self.is_reported: bool = False
        """Whether `plan` is reported for the request."""
        self.stopped: bool = False
        self.relearn = False
        self.has_sampled: bool = False
        self.unended: LineNotQuiet | None = None
        """The error of a stream that the unit did not end (D12), until the next plan."""
        self.identity_check: IdentityCheck = IdentityCheck()
        self.knowledge: MethodKnowledge = MethodKnowledge()
        self.refused: set[Datum] = set()
        self.dropped: set[str] = set()
        """Names reported as refused."""
        self.read: set[str] = set()
        """Names of parameters that the unit has answered."""
        self.answered: frozenset[Datum] = frozenset()
        """The data of a trial that the unit has answered as a whole: they need no other trial."""
        self.due: float = -inf
        """The beginning of the next cycle, with a rate or in a cycle without requests."""
        self.pending_alarms: deque[AlarmChanged] = deque()
        """Those of the latest sample that are still to be yielded."""
        self._last: dict[str, Reading] = {}
        self._selection = self.request.selection  # of the plan reported last
        self.forget_totals()

    def start_run(self) -> None:
        """Forget what the run before has reported."""
        self.stopped = self.has_sampled = self.is_reported = False
        self.pending_alarms.clear()

    def forget_totals(self) -> None:
        """Reset derived channels and alarms: those before are another car's."""
        self._derived = DerivedChannels(self._selection.catalog, self._selection.derived)
        self._alarms = Alarms(self._selection.catalog)

    def forget_unit(self) -> None:
        """Forget methods, refusals and values of the unit."""
        self.knowledge = MethodKnowledge()
        self.refused.clear()
        self.dropped.clear()
        self.read.clear()
        self.answered = frozenset()
        self.is_reported = False
        self._last.clear()

    def start_request(self) -> None:
        """Serve the latest request; reset the state of the one before.

        The named parameters are requested again. Another catalog is no such wish: a parameter that
        the unit lacks costs a second.
        """
        before, self.request = self.request, self.latest
        request = self.request
        self.is_reported = False
        self.due = -inf
        if request.selection.explicit and request.selection.catalog is before.selection.catalog:
            self.refused.clear()
        if request.method is not None:
            del self.knowledge.failures[request.method]

    def goes_on_with(self, request: SamplingRequest, method: FixedMethod) -> bool:
        """Return whether `request` may be served without a pause, by `method` as now.

        Another catalog may. A selection that is requested again also has to be without refusals,
        as these are requested again.
        """
        before = self.request
        if (request.method, request.rate) != (before.method, before.rate):
            return False
        if request.selection.catalog is not before.selection.catalog:
            return True
        return not self.refused and request.method in (None, method)

    @property
    def is_current(self) -> bool:
        """Whether `request` is the latest request, without `stop` or `relearn`."""
        return self.request is self.latest and not self.relearn and not self.stopped

    def report_plan(self, plan: Plan, time: float) -> Iterator[PlanChanged | AlarmChanged]:
        """Report `plan`, unless it was reported for the request."""
        if not self.is_reported or self.plan != plan:
            self.is_reported, self.plan = True, plan
            names = {planned.parameter.name for planned in plan.parameters}
            # Values of other parameters are not stale but invalid.
            self._last = {name: r for name, r in self._last.items() if name in names}
            ended = self._adopt_selection(time)
            yield PlanChanged(time, plan, self.request.selection.catalog.version)
            yield from ended

    def _adopt_selection(self, time: float) -> list[AlarmChanged]:
        """Compute the channels of the request; return the alarms that another catalog ends."""
        selection, before = self.request.selection, self._selection
        if before is selection:
            return []
        self._selection, derived, alarms = selection, self._derived, self._alarms
        self._derived = DerivedChannels(selection.catalog, selection.derived)
        requested = [planned.parameter.name for planned in selection.parameters]
        self._derived.continue_from(derived, requested)
        if before.catalog is selection.catalog:
            return []
        self._alarms = Alarms(selection.catalog)
        return self._alarms.continue_from(alarms, time)

    def sampled(self, fresh: dict[str, Reading]) -> Iterator[Sampled | AlarmChanged]:
        """Yield the sample of `fresh` readings, the latest of the others as stale; then its alarms.

        None without readings, or before the requested rate allows one.
        """
        if not fresh:
            return
        self.has_sampled = True
        stale = {name: r for name, r in self._last.items() if name not in fresh}
        self._last.update(fresh)
        self.read.update(fresh)
        time, rate = min(map(_time, fresh.values())), self.request.rate
        if rate and time < self.due:
            return
        if rate:
            self._schedule_after(time, 1 / rate)
        numbers = numbers_of(fresh)
        derived = self._derived.update(fresh, time, numbers)
        # Values of this cycle are fresh, however long it lasts; only the others have an age.
        changed = self._alarms.update({**stale, **numbers, **derived}, time)
        self.pending_alarms.extend(changed)
        yield Sampled(time, fresh, stale, derived)
        while self.pending_alarms:
            yield self.pending_alarms.popleft()

    def schedule_empty_cycle(self, time: float, length: float) -> None:
        """End a cycle without requests by the rate, else after `length` seconds."""
        if self.request.rate:
            self._schedule_after(time, 1 / self.request.rate)
        else:
            self.due = time + length

    def _schedule_after(self, time: float, period: float) -> None:
        self.due = next_due(time if self.due == -inf else self.due, time, period)

    def wait_until_due(self, ecu: Ecu, due: float | None = None) -> bool:
        """Wait until `due`, by default the next cycle; False: a job or a request came first."""
        due = self.due if due is None else due
        now = ecu.tester.link.now
        while now() < due:
            if self.jobs or not self.is_current:
                return False
            ecu.tester.wait(min(due, now() + _SLICE))
        return True


class IdentityCheck:
    """Detects that another unit may answer.

    A response does not identify its unit (D13). Moving the plug to another car takes a second or
    more, in which every request meets silence. After such a silence no value is accepted before
    the passports are compared. A single lost or damaged response is no such silence.
    """

    def __init__(self) -> None:
        self.compare: Callable[[Ecu], None] = lambda _: None
        """Raises `SyncLost` for another unit, or the error that prevents the comparison."""
        self._suspected = False
        self._silences = 0

    def suspect(self) -> None:
        """Require a comparison: a stream stopped, perhaps by another cause than the unit."""
        self._suspected = True

    def confirm(self, ecu: Ecu) -> None:
        """Note that the unit of `ecu` was identified just now."""
        self._suspected = False
        self._silences = ecu.tester.line.silences

    def check(self, ecu: Ecu, pause: Callable[[], None]) -> None:
        """Compare if another unit may answer; `pause` leaves the line quiet before."""
        if self._suspected or ecu.tester.line.silences != self._silences:
            pause()
            self.compare(ecu)
            self.confirm(ecu)
