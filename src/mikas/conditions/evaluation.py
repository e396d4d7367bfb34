"""When a rule acts: from samples, one after the other; pure, of bounded memory and time.

    condition   . F T T T T T F T T T T     . has no value; T it holds; F it does not
    for = 2 s         └──┴──┐   └──┴──┐
    acts                    ●         ●     the second only after `until` held, and `again` passed

A value counts until the next one of its channel: for two seconds, or two and a half of the
channel's usual steps where these are longer, at most a minute. So a condition never holds by
values from both sides of a gap, and a channel that is read in every tenth cycle still counts.
A condition that has no value does not hold, and releases nothing.

A value of an instrument beside the unit counts at the unit's samples, and only as long as the
instrument's definition says: a sample without it has none.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import inf, isfinite, nan
from typing import Final

from mikas.catalog import Catalog
from mikas.catalog.formulas import Calculation
from mikas.catalog.model import in_order
from mikas.client import Reading
from mikas.conditions.definition import LEAST_PAUSE, ActionRule
from mikas.sampling.events import Event, Gap, Sampled, UnitFound

PAUSE: Final = 2.0  # s for which a value counts
_ALIKE: Final = 2.5  # times the usual step
_LONGEST: Final = 60.0  # s


@dataclass(frozen=True, slots=True)
class Fired:
    """A rule acts. `time` and `since`, from which it held: link's clock."""

    rule: ActionRule
    """The rule."""
    time: float
    """The moment."""
    since: float
    """The beginning of the time for which the condition held."""
    values: Mapping[str, float]
    """The channels of the condition at that moment."""


class _Latest:
    """The last value of one channel, and for how long it counts."""

    __slots__ = ("_step", "span", "time", "value")

    def __init__(self, value: float, time: float) -> None:
        self.value, self.time, self.span = value, time, PAUSE
        self._step = inf  # the one before the last

    def take(self, value: float, time: float) -> None:
        step = time - self.time
        usual = min(step, self._step)  # the shorter of two: a gap is no usual step
        self.span = min(max(PAUSE, _ALIKE * usual), _LONGEST)
        self.value, self.time, self._step = value, time, step


class _RuleState:
    """How far one rule has come. `armed` false: it has acted, and waits for its release."""

    __slots__ = ("acted", "armed", "last", "latest", "since")

    def __init__(self) -> None:
        self.since: float | None = None  # the condition holds
        self.latest = 0.0  # it held then
        self.armed = True
        self.last: float | None = None  # it acted
        self.acted = 0

    def interrupt(self) -> None:
        self.since = None

    def follow(
        self, rule: ActionRule, time: float, span: float, *, holds: bool | None, released: bool
    ) -> bool:
        """Take one moment; return whether the rule acts. `holds` None: there is no value."""
        if released:
            self.armed = True
        if not holds:
            self.since = None
            return False
        if self.since is None or time - self.latest > span:
            self.since = time
        self.latest = time
        pause = max(rule.again, LEAST_PAUSE)  # a value that flickers does not act at each flip
        pauses = self.last is not None and 0 <= time - self.last < pause  # else: a clock set back
        if not self.armed or pauses or (rule.once and self.acted):
            return False
        if time - self.since < rule.hold:
            return False
        self.armed, self.last = False, time
        self.acted += 1
        return True


class ConditionWatch:
    """Follows samples with the rules; one thread may call.

    `requires`: the parameters that have to be sampled; `beside`: the instruments' channels that are
    needed besides. Raises `UnknownParameter` for a rule of another catalog.
    """

    def __init__(self, rules: Iterable[ActionRule], catalog: Catalog) -> None:
        self.rules: tuple[ActionRule, ...] = tuple(rules)
        names = tuple(dict.fromkeys(name for rule in self.rules for name in rule.channels))
        for name in names:
            catalog.formula_channel(name)
        self.requires: tuple[str, ...] = catalog.required_by(names)
        self.beside: tuple[str, ...] = catalog.required_beside(names)
        derived = in_order(catalog.derived, (name for name in names if name in catalog.derived))
        self._derived = [(each.name, each.calculation()) for each in derived]
        self._formulas = [
            (rule, Calculation(rule.condition), Calculation(rule.release) if rule.release else None)
            for rule in self.rules
        ]
        self._wanted = frozenset((*self.requires, *self.beside))
        needs = (rule.condition.inputs for rule in self.rules)
        self._needs = [(*catalog.required_by(it), *catalog.required_beside(it)) for it in needs]
        self._latest: dict[str, _Latest] = {}
        self._states = [_RuleState() for _ in self.rules]
        self._time = -inf

    def follow(self, event: Event) -> tuple[Fired, ...]:
        """Take an event of sampling; return the rules that act now."""
        if isinstance(event, Sampled):
            fresh = event.fresh
            values = {name: _corrected(fresh[name]) for name in self.requires if name in fresh}
            near = event.instruments
            values |= {name: near[name].value for name in self.beside if name in near}
            return self.add(event.time, values)
        if isinstance(event, Gap) or (isinstance(event, UnitFound) and event.another):
            self.interrupt()
        return ()

    def take_over(self, before: ConditionWatch) -> None:
        """Know of the same rules whether and when they have acted, as `before` does."""
        acted = dict(zip(before.rules, before._states, strict=True))
        self._states = [
            acted.get(rule, state) for rule, state in zip(self.rules, self._states, strict=True)
        ]
        self.interrupt()

    def interrupt(self) -> None:
        """Forget all values: what held before does not count any more."""
        self._latest.clear()
        for state in self._states:
            state.interrupt()

    def add(self, time: float, values: Mapping[str, float]) -> tuple[Fired, ...]:
        """Take the values of one moment; return the rules that act then.

        A time before the last one is a clock that was set: all before is forgotten.
        """
        if time < self._time:
            self.interrupt()
        self._time = time
        spans = [self._span(names) for names in self._needs]  # before this step
        for name in self.beside:
            if not isfinite(values.get(name, nan)):
                self._latest.pop(name, None)
        for name, value in values.items():
            if name not in self._wanted or not isfinite(value):
                continue
            if name in self._latest:
                self._latest[name].take(value, time)
            else:
                self._latest[name] = _Latest(value, time)
        return tuple(self._fired(time, self._known(time), spans))

    def value(self, rule: ActionRule) -> float:
        """Return what the rule's formula gives by the latest values; NaN: no value."""
        return _number(Calculation(rule.condition), self._known(self._time))

    def values(self, rule: ActionRule) -> dict[str, float]:
        """Return the latest values of the channels of the rule's condition, as far as known."""
        known = self._known(self._time)
        return {name: known[name] for name in rule.condition.inputs if name in known}

    def _known(self, time: float) -> dict[str, float]:
        known = {
            name: each.value for name, each in self._latest.items() if time - each.time <= each.span
        }
        for name, calculation in self._derived:
            number = _number(calculation, known)
            if isfinite(number):
                known[name] = number
        return known

    def _fired(
        self, time: float, known: Mapping[str, float], spans: Sequence[float]
    ) -> Iterator[Fired]:
        for (rule, condition, release), state, span in zip(
            self._formulas, self._states, spans, strict=True
        ):
            number = _number(condition, known)
            holds = bool(number) if isfinite(number) else None
            if release is None:
                released = holds is False
            else:
                free = _number(release, known)
                released = isfinite(free) and bool(free)
            if state.follow(rule, time, span, holds=holds, released=released):
                assert state.since is not None
                named = {name: known[name] for name in rule.condition.inputs}
                yield Fired(rule, time, state.since, named)

    def _span(self, names: Iterable[str]) -> float:
        """Return the longest time between two samples over which a condition on `names` goes on."""
        return max((self._latest[it].span for it in names if it in self._latest), default=PAUSE)


def _corrected(reading: Reading) -> float:
    """Return the value of the corrected interpretation, which formulas are in."""
    if reading.interpretation == "corrected":
        return float(reading.value)
    return float(reading.parameter.decode(reading.raw))


def _number(calculation: Calculation, known: Mapping[str, float]) -> float:
    if any(name not in known for name in calculation.inputs):
        return nan
    return calculation.number(known)
