"""What the parts of a sampler share: what is wanted, what is known of the unit, what came last."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf

from mikas.catalog import Parameter
from mikas.client import Ecu, Reading
from mikas.client.methods import FixedMethod
from mikas.commands import Datum
from mikas.errors import UsageError
from mikas.i18n import Text
from mikas.sampling.events import Sampled
from mikas.sampling.jobs import Jobs
from mikas.sampling.method_knowledge import MethodKnowledge
from mikas.sampling.plan import Plan, Wanted

_SLICE = 0.1  # s that a wait for the next cycle lasts before others get a look in


@dataclass(frozen=True)
class Wish:
    """What is wanted, until another is. `again`: also what the unit has refused before."""

    wanted: tuple[Wanted, ...]
    method: FixedMethod | None = None
    rate: float | None = None
    again: bool = False

    def __post_init__(self) -> None:
        Plan(self.wanted).check()
        if self.rate is not None and not 0 < self.rate < inf:
            raise UsageError(
                problem=Text("a rate is more than 0 a second", "частота должна быть больше 0")
            )


class Session:
    """`strict` counts until `begun`: until the first sample ever."""

    def __init__(self, wish: Wish, jobs: Jobs, *, strict: bool) -> None:
        self.wish = wish
        self.jobs = jobs
        self.strict = strict
        self.stopped = False
        self.relearn = False
        self.begun = False
        self.learning = MethodKnowledge()
        self.refused: set[Datum] = set()
        self.dropped: set[str] = set()
        """Names that were told to be refused."""
        self.due = -inf
        """When the next cycle begins, if a rate is wanted, or the one that runs asks nothing."""
        self._last: dict[str, Reading] = {}

    def another_unit(self) -> None:
        """What was known was known of another one, or is to be forgotten."""
        self.learning = MethodKnowledge()
        self.refused.clear()
        self.dropped.clear()
        self._last.clear()

    def begin(self, wish: Wish) -> None:
        """What held for the wish before does not hold for `wish`."""
        self.due = -inf
        if wish.again:
            self.refused.clear()
            self.dropped.clear()
        if wish.method is not None:
            self.learning.reset_failures(wish.method)

    def is_current(self, wish: Wish) -> bool:
        """Whether `wish` is what is wanted, and anything at all."""
        return wish is self.wish and not self.relearn and not self.stopped

    def sampled(self, fresh: dict[str, Reading]) -> Sampled:
        """What came, with the last known of what did not."""
        self.begun = True
        stale = {name: r for name, r in self._last.items() if name not in fresh}
        self._last.update(fresh)
        return Sampled(min(r.time for r in fresh.values()), fresh, stale)

    def in_time(self, sampled: Sampled) -> bool:
        """Whether it is not sooner than the rate that is wanted; sets when the next is due."""
        if not self.wish.rate:
            return True
        if sampled.time < self.due:
            return False
        self._due_after(sampled.time, 1 / self.wish.rate)
        return True

    def rest(self, time: float, length: float) -> None:
        """The cycle that begins at `time` asks for nothing: it lasts what the rate that is wanted
        makes of one, else `length`.
        """
        if self.wish.rate:
            self._due_after(time, 1 / self.wish.rate)
        else:
            self.due = time + length

    def _due_after(self, time: float, period: float) -> None:
        # After a delay it goes on from now, lest it runs after what can't be caught up.
        due = time if self.due == -inf else self.due
        self.due = max(due, time - period) + period

    def keep_only(self, plan: Plan) -> None:
        """What is not asked any more is not stale, but gone."""
        names = {wanted.parameter.name for wanted in plan.wanted}
        self._last = {name: r for name, r in self._last.items() if name in names}

    def waited(self, ecu: Ecu, wish: Wish, due: float | None = None) -> bool:
        """Waits until `due`, or the next sample is; False: somebody wants something before."""
        due = self.due if due is None else due
        now = ecu.tester.link.now
        while now() < due:
            if self.jobs or not self.is_current(wish):
                return False
            ecu.tester.wait(min(due, now() + _SLICE))
        return True


def datum_of(parameter: Parameter) -> Datum:
    """What of the unit it is read from."""
    return Datum(parameter.code, parameter.size)
