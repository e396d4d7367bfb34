"""What follows from what was measured. Pure; the only place where a value is judged.

A value is judged by its median at warm idle against the catalog's reference. Without a reference,
without enough of warm idle, or with too few values, it is shown and not judged.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import Final

from mikas.catalog import Derived, Fault, Parameter
from mikas.catalog.conversion import NO_TEXT
from mikas.i18n import Text
from mikas.report.measuring import Channel, Measured
from mikas.report.spread import Stats, is_inside
from mikas.report.subject import Subject
from mikas.report.told import Gone

_FEWEST: Final = 5  # values at warm idle to judge by
_LONG_ENOUGH: Final = 600.0  # s after which an erased fault should have come back


class Mark(StrEnum):
    """Where a value lies; shown as a word and a shape."""

    INSIDE = "inside"
    LOW = "low"
    HIGH = "high"
    NONE = "none"  # not judged


class Outcome(StrEnum):
    """What it all comes to."""

    GOOD = "good"
    ATTENTION = "attention"
    OPEN = "open"  # not enough is known to say either


@dataclass(frozen=True, slots=True)
class Value:
    """One channel's row. `meaning`: what its being off may mean. `faults`: those stored that bear
    on it.
    """

    channel: Channel
    stats: Stats
    mark: Mark = Mark.NONE
    meaning: Text = NO_TEXT
    faults: tuple[int, ...] = ()


@dataclass(frozen=True, slots=True)
class Stored:
    """A stored fault, with the measured values that bear on it."""

    fault: Fault
    values: tuple[Value, ...]


@dataclass(frozen=True, slots=True)
class Findings:
    """All that the report says. `faults` None: they were not read. `at_idle`: whether the values'
    numbers are those of warm idle, or of the whole time. `gone`: real faults that were stored.
    """

    subject: Subject
    measured: Measured
    outcome: Outcome
    faults: tuple[Stored, ...] | None
    judged: tuple[Value, ...]
    others: tuple[Value, ...]
    at_idle: bool
    gone: tuple[Gone, ...] = ()

    @property
    def off(self) -> tuple[Value, ...]:
        """The values outside their references."""
        return tuple(value for value in self.judged if value.mark is not Mark.INSIDE)

    @property
    def real_faults(self) -> tuple[Stored, ...]:
        """The stored faults without those numbers that are only messages."""
        return tuple(each for each in self.faults or () if not each.fault.informational)


def find(subject: Subject, measured: Measured) -> Findings:
    """Everything that follows."""
    at_idle = measured.idle.enough
    stats = measured.at_idle if at_idle else measured.whole
    bearing = _bearing(subject.faults or ())
    values = {
        channel.name: _value(channel, stats[channel.name], bearing, judge=at_idle)
        for channel in measured.channels
        if channel.name in stats
    }
    judged = tuple(value for value in values.values() if value.mark is not Mark.NONE)
    faults = subject.faults
    stored = None if faults is None else tuple(_stored(fault, values) for fault in faults)
    gone = tuple(each for each in map(_real, subject.gone) if each.faults)
    return Findings(
        subject=subject,
        measured=measured,
        outcome=_outcome(faults, judged, is_open=any(is_open(subject, each) for each in gone)),
        gone=gone,
        faults=stored,
        judged=judged,
        others=tuple(value for value in values.values() if value.mark is Mark.NONE),
        at_idle=at_idle,
    )


def _value(
    channel: Channel, stats: Stats, bearing: Mapping[str, tuple[int, ...]], *, judge: bool
) -> Value:
    faults = bearing.get(channel.name, ())
    enough = judge and stats.count >= _FEWEST
    if isinstance(channel, Derived) or channel.reference is None or not enough:
        return Value(channel, stats, faults=faults)
    mark = _mark(stats.median, channel.reference)
    return Value(channel, stats, mark, _meaning(channel, mark), faults)


def _mark(median: float, reference: tuple[float, float]) -> Mark:
    if is_inside(median, reference):
        return Mark.INSIDE
    return Mark.LOW if median < reference[0] else Mark.HIGH


def _meaning(parameter: Parameter, mark: Mark) -> Text:
    if parameter.meaning is None or mark is Mark.INSIDE:
        return NO_TEXT
    return parameter.meaning.low if mark is Mark.LOW else parameter.meaning.high


def _bearing(faults: tuple[Fault, ...]) -> dict[str, tuple[int, ...]]:
    """By parameter: the stored faults that concern it."""
    found: dict[str, tuple[int, ...]] = {}
    for fault in faults:
        for name in fault.parameters:
            found[name] = (*found.get(name, ()), fault.code)
    return found


def _stored(fault: Fault, values: Mapping[str, Value]) -> Stored:
    return Stored(fault, tuple(values[name] for name in fault.parameters if name in values))


def is_open(subject: Subject, gone: Gone) -> bool:
    """Whether it is too early to say that these are cured: they were not looked for again later."""
    return (subject.faults_read or gone.time) - gone.time < _LONG_ENOUGH


def _real(gone: Gone) -> Gone:
    return replace(gone, faults=tuple(it for it in gone.faults if not it.informational))


def _outcome(
    faults: tuple[Fault, ...] | None, judged: tuple[Value, ...], *, is_open: bool
) -> Outcome:
    if any(not fault.informational for fault in faults or ()):
        return Outcome.ATTENTION
    if any(value.mark is not Mark.INSIDE for value in judged):
        return Outcome.ATTENTION
    return Outcome.GOOD if judged and faults is not None and not is_open else Outcome.OPEN
