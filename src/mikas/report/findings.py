"""The findings of the measurements. Pure; the only place where a value is rated.

A value is rated by its median at warm idle against the catalog's reference. Without a reference,
without enough warm idle, or with too few values it is shown without a rating.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import Final

from mikas.catalog import Derived, Fault, Parameter
from mikas.catalog.conversion import NO_TEXT
from mikas.i18n import Text
from mikas.report.measurements import Channel, Measurements
from mikas.report.statistics import ChannelStatistics, is_inside
from mikas.report.subject import ClearedFaults, ReportSubject

_FEWEST: Final = 5  # values at warm idle needed for a rating
_LONG_ENOUGH: Final = 600.0  # s after which an erased fault should have come back


class BandPosition(StrEnum):
    """Position of a value to its reference; shown as a word and a shape."""

    INSIDE = "inside"
    LOW = "low"
    HIGH = "high"
    NONE = "none"  # not rated


class Outcome(StrEnum):
    """The overall result."""

    GOOD = "good"
    ATTENTION = "attention"
    OPEN = "open"  # not enough data for either


@dataclass(frozen=True, slots=True)
class ChannelFinding:
    """One channel's row. `meaning`: the possible cause of a value outside its reference.
    `faults`: stored faults that concern the channel.
    """

    channel: Channel
    stats: ChannelStatistics
    mark: BandPosition = BandPosition.NONE
    meaning: Text = NO_TEXT
    faults: tuple[int, ...] = ()


@dataclass(frozen=True, slots=True)
class FaultFinding:
    """A stored fault, with the measured values that it concerns."""

    fault: Fault
    values: tuple[ChannelFinding, ...]


@dataclass(frozen=True, slots=True)
class Findings:
    """The content of the report. `faults` None: not read. `at_idle`: the statistics are those of
    warm idle, else of the whole time. `gone`: real faults that were stored before.
    """

    subject: ReportSubject
    measured: Measurements
    outcome: Outcome
    faults: tuple[FaultFinding, ...] | None
    rated: tuple[ChannelFinding, ...]
    unrated: tuple[ChannelFinding, ...]
    at_idle: bool
    cleared: tuple[ClearedFaults, ...] = ()

    @property
    def abnormal(self) -> tuple[ChannelFinding, ...]:
        """The values outside their references."""
        return tuple(value for value in self.rated if value.mark is not BandPosition.INSIDE)

    @property
    def real_faults(self) -> tuple[FaultFinding, ...]:
        """The stored faults without mere messages."""
        return tuple(each for each in self.faults or () if not each.fault.informational)


def find(subject: ReportSubject, measured: Measurements) -> Findings:
    """Rate the measurements and return all findings."""
    at_idle = measured.idle.enough
    stats = measured.at_idle if at_idle else measured.whole
    bearing = _faults_by_parameter(subject.faults or ())
    values = {
        channel.name: _value(channel, stats[channel.name], bearing, judge=at_idle)
        for channel in measured.channels
        if channel.name in stats
    }
    judged = tuple(value for value in values.values() if value.mark is not BandPosition.NONE)
    faults = subject.faults
    stored = None if faults is None else tuple(_stored(fault, values) for fault in faults)
    gone = tuple(each for each in map(_without_messages, subject.cleared) if each.faults)
    return Findings(
        subject=subject,
        measured=measured,
        outcome=_outcome(faults, judged, is_open=any(is_open(subject, each) for each in gone)),
        cleared=gone,
        faults=stored,
        rated=judged,
        unrated=tuple(value for value in values.values() if value.mark is BandPosition.NONE),
        at_idle=at_idle,
    )


def _value(
    channel: Channel,
    stats: ChannelStatistics,
    bearing: Mapping[str, tuple[int, ...]],
    *,
    judge: bool,
) -> ChannelFinding:
    faults = bearing.get(channel.name, ())
    enough = judge and stats.count >= _FEWEST
    if isinstance(channel, Derived) or channel.reference is None or not enough:
        return ChannelFinding(channel, stats, faults=faults)
    mark = _mark(stats.median, channel.reference)
    return ChannelFinding(channel, stats, mark, _meaning(channel, mark), faults)


def _mark(median: float, reference: tuple[float, float]) -> BandPosition:
    if is_inside(median, reference):
        return BandPosition.INSIDE
    return BandPosition.LOW if median < reference[0] else BandPosition.HIGH


def _meaning(parameter: Parameter, mark: BandPosition) -> Text:
    if parameter.meaning is None or mark is BandPosition.INSIDE:
        return NO_TEXT
    return parameter.meaning.low if mark is BandPosition.LOW else parameter.meaning.high


def _faults_by_parameter(faults: tuple[Fault, ...]) -> dict[str, tuple[int, ...]]:
    """Return the stored faults that concern each parameter."""
    found: dict[str, tuple[int, ...]] = {}
    for fault in faults:
        for name in fault.parameters:
            found[name] = (*found.get(name, ()), fault.code)
    return found


def _stored(fault: Fault, values: Mapping[str, ChannelFinding]) -> FaultFinding:
    return FaultFinding(fault, tuple(values[name] for name in fault.parameters if name in values))


def is_open(subject: ReportSubject, gone: ClearedFaults) -> bool:
    """Whether it is too early to call these faults cured: they were not read again later."""
    return (subject.faults_read or gone.time) - gone.time < _LONG_ENOUGH


def _without_messages(gone: ClearedFaults) -> ClearedFaults:
    return replace(gone, faults=tuple(it for it in gone.faults if not it.informational))


def _outcome(
    faults: tuple[Fault, ...] | None, judged: tuple[ChannelFinding, ...], *, is_open: bool
) -> Outcome:
    if any(not fault.informational for fault in faults or ()):
        return Outcome.ATTENTION
    if any(value.mark is not BandPosition.INSIDE for value in judged):
        return Outcome.ATTENTION
    return Outcome.GOOD if judged and faults is not None and not is_open else Outcome.OPEN
