"""A guided test as data: steps, measures and rules, as `loading` makes them from a file.

A field with a rule in its annotation is a key of the file (`schema_of`).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Annotated, Final

from mikas.catalog import Catalog, Derived
from mikas.catalog.conversion import NO_TEXT
from mikas.catalog.formula_syntax import Parsed
from mikas.catalog.loading.fields import (
    ANY,
    TEXT,
    between,
    boolean,
    choice,
    integer,
    schema_of,
    span,
    string,
    strings,
)
from mikas.i18n import Text

SECONDS = "SECONDS"
"""In the formulas of a step: seconds since it began."""

IDLE_THROTTLE: Final = 5
"""% that the throttle shows at most with the pedal released, in tests, reports and fleets. It is
more than the 0 % of a sound one: the idle of a maladjusted one is found, and then rated.
"""
CONSTANTS: Final = {"IDLE_THROTTLE": float(IDLE_THROTTLE)}
"""Numbers with a name in all formulas of a test."""


class VerdictKind(StrEnum):
    """The kind of a verdict, in order of weight: a later one outweighs an earlier."""

    GOOD = "good"
    UNKNOWN = "unknown"
    ATTENTION = "attention"
    BAD = "bad"


class Certainty(StrEnum):
    """How sure a finding is, from least to most."""

    LOW = "low"
    MEDIUM = "medium"
    HIGH = "high"

    @property
    def less(self) -> Certainty:
        """The next lower one."""
        return Certainty.MEDIUM if self is Certainty.HIGH else Certainty.LOW


class Statistic(StrEnum):
    """What a measure computes from the values of its formula.

    `slope` is per minute. `jump`: the largest change from one reading to the next. `fall`: the
    largest drop below an earlier value, in time or in the order of `by`. `seconds`: how long the
    formula was true; `share`: in which percentage of the readings; `times`: how often it became so.
    """

    MIN = "min"
    MAX = "max"
    MEAN = "mean"
    MEDIAN = "median"
    FIRST = "first"
    LAST = "last"
    SLOPE = "slope"
    SPREAD = "spread"
    PERCENTILE = "percentile"
    JUMP = "jump"
    FALL = "fall"
    SECONDS = "seconds"
    SHARE = "share"
    TIMES = "times"


@dataclass(frozen=True, slots=True)
class GuidedStep:
    """One instruction, and when it is done.

    After `prepare` seconds the step is done once `until` has held for `hold` seconds without a gap.
    Its measures take the readings of that time, or with `whole` all since `prepare`. After
    `timeout` seconds `advice` is shown; the step goes on. `by_hand`: no data show that the driver
    did it; `optional`: rules over its measures are left out if it was not done. `targets`: by
    channel, where its value belongs. In the data no input may be missing for longer than
    `longest_gap` seconds, and each comes at least `rate` times a second.
    """

    name: str
    text: Annotated[Text, TEXT]
    until: Annotated[Parsed | None, string] = None
    hold: Annotated[float, between(0, 3600)] = 0.0
    prepare: Annotated[float, between(0, 600)] = 0.0
    whole: Annotated[bool, boolean] = False
    by_hand: Annotated[bool, boolean] = False
    optional: Annotated[bool, boolean] = False
    timeout: Annotated[float, between(1, 7200)] = 120.0
    advice: Annotated[Text, TEXT] = NO_TEXT
    watch: Annotated[tuple[str, ...], strings] = ()
    targets: Annotated[Mapping[str, tuple[float, float]], {ANY: span}, "target"] = field(
        default_factory=dict
    )
    longest_gap: Annotated[float, between(0.05, 60)] = 1.0
    rate: Annotated[float, between(0, 200)] = 0.0


@dataclass(frozen=True, slots=True)
class Measure:
    """One number: `statistic` of the formula `of` over the readings of a step where `when` is true.

    `last`: only those of the last seconds. `fewest`: readings that it needs. `resolution`: the
    step of the raw value, if `of` is a parameter alone; 0: unknown.
    """

    name: str
    text: Annotated[Text, TEXT]
    step: Annotated[str, string]
    of: Annotated[Parsed, string]
    when: Annotated[Parsed | None, string]
    by: Annotated[Parsed | None, string]
    statistic: Annotated[Statistic, choice(Statistic, *Statistic)]
    percentile: Annotated[float, between(0, 100)] = 50.0
    last: Annotated[float | None, between(0.1, 3600)] = None
    fewest: Annotated[int, integer(1, 10_000)] = 3
    unit: Annotated[Text, string] = NO_TEXT
    decimals: Annotated[int, integer(0, 4)] = 1
    resolution: float = 0.0

    @property
    def formulas(self) -> Iterator[Parsed]:
        """Its formulas."""
        return (each for each in (self.of, self.when, self.by) if each is not None)


@dataclass(frozen=True, slots=True)
class Rule:
    """`when` over measures gives `outcome`; `text` has the measures in braces.

    `ignition_only`: counts only on a unit that controls the ignition alone.
    """

    name: str
    when: Annotated[Parsed, string]
    formula: str
    outcome: Annotated[VerdictKind, choice(VerdictKind, *VerdictKind), "verdict"]
    text: Annotated[Text, TEXT]
    check: Annotated[Text, TEXT]
    doubt: Annotated[Text, TEXT]
    confidence: Annotated[Certainty, choice(Certainty, *Certainty)] = Certainty.MEDIUM
    ignition_only: Annotated[bool, boolean] = False


@dataclass(frozen=True, slots=True)
class GuidedTest:
    """One test. `start`: must be true before the first step; `needs` is that in words.

    `any_order`: in a recording each step is looked for by itself, and the one that decides most
    counts. `own`: from a file of the user. `channels`: the parameters to sample, those of the
    formulas and the watched ones; `beside`: the instruments' channels among these. `chart`:
    channels drawn with the verdict.
    """

    name: str
    title: Annotated[Text, TEXT]
    finds: Annotated[Text, TEXT]
    minutes: Annotated[float, between(0.1, 600)]
    needs: Annotated[Text, TEXT]
    start: Annotated[Parsed | None, string]
    chart: Annotated[tuple[str, ...], strings]
    any_order: Annotated[bool, boolean]
    steps: Annotated[tuple[GuidedStep, ...], {ANY: schema_of(GuidedStep)}, "step"]
    measures: Annotated[Mapping[str, Measure], {ANY: schema_of(Measure)}, "measure"]
    rules: Annotated[tuple[Rule, ...], {ANY: schema_of(Rule)}, "rule"]
    channels: tuple[str, ...]
    own: bool = False
    beside: tuple[str, ...] = ()


def parameters_of(catalog: Catalog, names: Iterator[str] | tuple[str, ...]) -> tuple[str, ...]:
    """Return the parameters that channels need, derived ones by their inputs, each once.

    Among them are the channels of instruments beside the unit that they are or need.
    """
    found: dict[str, None] = {}
    for name in names:
        if name == SECONDS:
            continue
        channel = catalog.formula_channel(name)
        needed: tuple[str, ...] = (channel.name,)
        if isinstance(channel, Derived):
            own = [channel.name]
            needed = (*catalog.required_by(own), *catalog.required_beside(own))
        found |= dict.fromkeys(needed)
    return tuple(found)
