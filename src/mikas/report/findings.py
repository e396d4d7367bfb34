"""The findings of the measurements. Pure; the only place where a value is rated.

A value is rated by its median at warm idle against the catalog's reference. It is not rated without
a reference, without enough warm idle, with too few values, or if a fault of its sensor's circuit
was stored then: the unit may have used a substitute value. `Unrated` has the reason.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from enum import StrEnum
from typing import Final

from mikas.catalog import Catalog, Fault, Meaning
from mikas.catalog.conversion import NO_TEXT
from mikas.catalog.ignition_only import is_absent
from mikas.catalog.model import in_order
from mikas.causes.result import CauseVerdict
from mikas.guided.definition import VerdictKind
from mikas.guided.result import TestResult
from mikas.i18n import Text
from mikas.report.measurements.alarms import Channel
from mikas.report.measurements.measurements import Measurements
from mikas.report.measurements.statistics import ChannelStatistics, is_inside
from mikas.report.subject import ClearedFaults, ReportSubject

FEWEST: Final = 5  # values at warm idle needed for a rating
_NAMED: Final = (CauseVerdict.CAUSES, CauseVerdict.UNKNOWN)
_LONG_ENOUGH: Final = 600.0  # s after which an erased fault should have come back


class BandPosition(StrEnum):
    """Position of a value to its reference; shown as a word and a shape."""

    INSIDE = "inside"
    LOW = "low"
    HIGH = "high"
    NONE = "none"  # not rated


class Unrated(StrEnum):
    """The reason why a value has no rating, the first that holds."""

    NO_REFERENCE = "no-reference"
    IGNITION_ONLY = "ignition-only"  # a channel that the unit does not have
    NO_IDLE = "no-idle"  # not enough warm idle
    SENSOR = "sensor"  # a fault of its sensor's circuit
    TOO_FEW = "too-few"  # values at warm idle


class Outcome(StrEnum):
    """The overall result."""

    GOOD = "good"
    ATTENTION = "attention"
    OPEN = "open"  # not enough data for either


@dataclass(frozen=True, slots=True)
class ChannelFinding:
    """One channel's row. `unrated` None: it has a rating. `meaning`: the possible cause of a value
    outside its reference. `sensor`: faults of the sensor that it comes from, also through a
    formula; `related`: other stored faults to look at with it.
    """

    channel: Channel
    stats: ChannelStatistics
    mark: BandPosition = BandPosition.NONE
    unrated: Unrated | None = Unrated.NO_REFERENCE
    meaning: Text = NO_TEXT
    sensor: tuple[int, ...] = ()
    related: tuple[int, ...] = ()


@dataclass(frozen=True, slots=True)
class Findings:
    """The content of the report. The statistics of `values` are those of warm idle, if there was
    enough, else of all the time. `cleared`: real faults that were stored before. `sensor`: the
    faults of each channel's sensor, also for channels that were not measured.
    """

    subject: ReportSubject
    measured: Measurements
    values: tuple[ChannelFinding, ...]
    cleared: tuple[ClearedFaults, ...] = ()
    sensor: Mapping[str, tuple[int, ...]] = field(default_factory=dict)

    @property
    def rated(self) -> tuple[ChannelFinding, ...]:
        """The values with a rating."""
        return tuple(value for value in self.values if value.unrated is None)

    @property
    def abnormal(self) -> tuple[ChannelFinding, ...]:
        """The values outside their references."""
        return tuple(value for value in self.rated if value.mark is not BandPosition.INSIDE)

    @property
    def suspended(self) -> tuple[ChannelFinding, ...]:
        """The values that a fault of their sensor keeps from being rated."""
        return tuple(value for value in self.values if value.unrated is Unrated.SENSOR)

    @property
    def failed_tests(self) -> tuple[TestResult, ...]:
        """The guided tests that found something, the latest of each."""
        latest = {test.test: test for test in sorted(self.subject.tests, key=lambda it: it.ended)}
        bad = (VerdictKind.ATTENTION, VerdictKind.BAD)
        return tuple(test for test in latest.values() if test.outcome in bad)

    @property
    def real_faults(self) -> tuple[Fault, ...]:
        """The stored faults without mere messages."""
        return tuple(each for each in self.subject.faults or () if not each.informational)

    def values_of(self, fault: Fault) -> tuple[ChannelFinding, ...]:
        """Return the measured values related to a fault."""
        measured = {value.channel.name: value for value in self.values}
        return tuple(measured[name] for name in fault.parameters if name in measured)

    @property
    def outcome(self) -> Outcome:
        """Attention: a fault, a value outside its reference, an alarm, retard for knock in many
        readings, a finding of a guided test, or a cause that the values speak for. Good: none of
        these, the faults were read, none is open, and some value was rated.
        """
        crossed = self.measured.alarms or self.measured.knock.often_retarded
        ranking = self.subject.causes
        named = ranking is not None and ranking.verdict in _NAMED
        if self.real_faults or self.abnormal or crossed or self.failed_tests or named:
            return Outcome.ATTENTION
        if ranking is not None and ranking.something_off:
            return Outcome.OPEN
        open_ones = any(is_open(self.subject, each) for each in self.cleared)
        known = self.rated and self.subject.faults is not None and not open_ones
        return Outcome.GOOD if known else Outcome.OPEN


def find(subject: ReportSubject, measured: Measurements) -> Findings:
    """Rate the measurements and return all findings."""
    at_idle = measured.idle.enough
    stats = measured.at_idle if at_idle else measured.whole
    gone = _real(subject.cleared)
    stored = [fault for fault in subject.faults or () if not fault.informational]
    sensor = _sensor_faults([*stored, *_stored_meanwhile(gone, measured)], subject.catalog)
    related = _by_channel(stored, lambda fault: fault.parameters)
    values = (
        _value(
            channel,
            stats[channel.name],
            at_idle=at_idle,
            dead=measured.ignition_only and is_absent(channel.name, subject.catalog),
            sensor=sensor.get(channel.name, ()),
            related=related.get(channel.name, ()),
        )
        for channel in measured.channels
        if channel.name in stats
    )
    return Findings(subject, measured, tuple(values), gone, sensor)


def _value(
    channel: Channel,
    stats: ChannelStatistics,
    *,
    at_idle: bool,
    dead: bool,
    sensor: tuple[int, ...],
    related: tuple[int, ...],
) -> ChannelFinding:
    beside = tuple(code for code in related if code not in sensor)
    found = ChannelFinding(channel, stats, sensor=sensor, related=beside)
    if channel.reference is None:
        return found
    if dead:
        return replace(found, unrated=Unrated.IGNITION_ONLY)
    if not at_idle:
        return replace(found, unrated=Unrated.NO_IDLE)
    if sensor:
        return replace(found, unrated=Unrated.SENSOR)
    if stats.count < FEWEST:
        return replace(found, unrated=Unrated.TOO_FEW)
    found, known = replace(found, unrated=None), channel.meaning or Meaning()
    if is_inside(stats.median, channel.reference):
        return replace(found, mark=BandPosition.INSIDE)
    if stats.median < channel.reference[0]:
        return replace(found, mark=BandPosition.LOW, meaning=known.low)
    return replace(found, mark=BandPosition.HIGH, meaning=known.high)


def _by_channel(
    faults: Iterable[Fault], names: Callable[[Fault], Iterable[str]]
) -> dict[str, tuple[int, ...]]:
    """Return the faults' numbers by the channels that `names` gives."""
    found: dict[str, dict[int, None]] = {}
    for fault in faults:
        for name in names(fault):
            found.setdefault(name, {})[fault.code] = None
    return {name: tuple(codes) for name, codes in found.items()}


def _sensor_faults(faults: Iterable[Fault], catalog: Catalog) -> dict[str, tuple[int, ...]]:
    """Return the sensor faults by channel; a derived channel has those of its inputs."""
    found = _by_channel(faults, lambda fault: fault.sensor)
    if found:
        for channel in in_order(catalog.derived, catalog.derived):
            codes = dict.fromkeys(code for name in channel.inputs for code in found.get(name, ()))
            if codes:
                found[channel.name] = tuple(codes)
    return found


def _stored_meanwhile(gone: Iterable[ClearedFaults], measured: Measurements) -> Iterator[Fault]:
    """Yield the faults that were still stored in a part of the time that the values are of."""
    spans = measured.idle.spans if measured.idle.enough else ()
    began = spans[0][0] if spans else measured.began
    for each in gone:
        if began is not None and each.time > began:
            yield from each.faults


def is_open(subject: ReportSubject, gone: ClearedFaults) -> bool:
    """Whether it is too early to call these faults cured: they were not read again later."""
    return (subject.faults_read or gone.time) - gone.time < _LONG_ENOUGH


def _real(cleared: Iterable[ClearedFaults]) -> tuple[ClearedFaults, ...]:
    """Return the cleared faults without mere messages."""
    real = (
        replace(gone, faults=tuple(it for it in gone.faults if not it.informational))
        for gone in cleared
    )
    return tuple(gone for gone in real if gone.faults)
