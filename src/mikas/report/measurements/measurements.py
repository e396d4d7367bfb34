"""Statistics, envelope and warm idle of each channel, collected from rows.

Rows come in blocks, from a recording or from the memory of a running session. Only value counts and
a few hundred columns a channel are kept.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from mikas.cancellation import check_cancelled
from mikas.catalog import Catalog
from mikas.recording.ignition_only import RowsInjectionWatch
from mikas.recording.table.channels import Rows
from mikas.report.measurements.alarms import Alarm, AlarmCollector, Channel
from mikas.report.measurements.knock import Knock, KnockCounter
from mikas.report.measurements.statistics import (
    BlockTimes,
    ChannelStatistics,
    Envelope,
    ValueCounts,
)
from mikas.report.measurements.warm_idle import WarmIdle, WarmIdleFinder
from mikas.sampling.events import Event

_FINER = 2  # decimals beyond those shown, for computed channels


@dataclass(frozen=True, slots=True)
class Measurements:
    """By channel name: `whole` over all the time, `at_idle` at warm idle.

    `began`, `ended` None: there were no rows. `watched`: the channels with limits that had a value.
    """

    channels: tuple[Channel, ...]
    began: float | None
    ended: float | None
    rows: int
    idle: WarmIdle
    whole: Mapping[str, ChannelStatistics]
    at_idle: Mapping[str, ChannelStatistics]
    curves: Mapping[str, Envelope]
    alarms: tuple[Alarm, ...] = ()
    watched: frozenset[str] = frozenset()
    knock: Knock = field(default_factory=Knock)
    ignition_only: bool = False

    @property
    def seconds(self) -> float:
        """The duration of the measurement."""
        if self.began is None or self.ended is None:
            return 0.0
        return max(0.0, self.ended - self.began)


class MeasurementCollector:
    """Collects the rows of one unit. `names`: the channels that they may have, in order. `events`:
    of the same time, for the alarms.

    A derived channel that accumulates has an envelope, but no useful statistics.
    """

    def __init__(
        self, catalog: Catalog, names: Iterable[str], events: Sequence[Event] = ()
    ) -> None:
        self._alarms = AlarmCollector(catalog, events)
        self._knock = KnockCounter()
        self._injection = RowsInjectionWatch()
        self._channels = tuple(catalog.channel(name) for name in names)
        self._finder = WarmIdleFinder(channel.name for channel in self._channels)
        counted = [each for each in self._channels if not each.accumulates]
        self._elsewhere = {each.name: ValueCounts(each.decimals + _FINER) for each in counted}
        self._at_idle = {each.name: ValueCounts(each.decimals + _FINER) for each in counted}
        self._curves: dict[str, Envelope] = {}
        self._began: float | None = None
        self._ended: float | None = None
        self._rows = 0

    def add(self, rows: Rows) -> None:
        """Add rows, parameters in the corrected interpretation."""
        if not len(rows.times):
            return
        if self._began is None:
            self._began = float(rows.times[0])
            self._curves = {each.name: Envelope() for each in self._channels}
        times = BlockTimes(rows.times, self._began)
        idle = self._finder.find(rows)
        elsewhere = ~idle
        self._alarms.add(rows)
        self._knock.add(rows)
        self._injection.add_rows(rows)
        for channel in self._channels:
            column = rows.values.get(channel.name)
            if column is None:
                continue
            check_cancelled()
            self._curves[channel.name].add(times, column)
            if channel.name in self._at_idle:
                self._at_idle[channel.name].add(column[idle])
                self._elsewhere[channel.name].add(column[elsewhere])
        self._ended = float(np.max(rows.times))
        self._rows += len(rows.times)

    @property
    def measured(self) -> Measurements:
        """The measurements so far, without channels that had no value."""
        whole = self._stats(
            {name: idle.with_others(self._elsewhere[name]) for name, idle in self._at_idle.items()}
        )
        present = {name for name, curve in self._curves.items() if np.isfinite(curve.most).any()}
        return Measurements(
            channels=tuple(each for each in self._channels if each.name in present),
            began=self._began,
            ended=self._ended,
            rows=self._rows,
            idle=self._finder.found,
            whole=whole,
            at_idle=self._stats(self._at_idle),
            curves={name: curve for name, curve in self._curves.items() if name in present},
            knock=self._knock.found,
            ignition_only=self._injection.ignition_only,
            alarms=self._alarms.alarms(self._began, self._ended),
            watched=self._alarms.watched,
        )

    def _stats(self, spreads: Mapping[str, ValueCounts]) -> dict[str, ChannelStatistics]:
        stats = {
            each.name: spreads[each.name].stats(each.reference)
            for each in self._channels
            if each.name in spreads
        }
        return {name: found for name, found in stats.items() if found is not None}
