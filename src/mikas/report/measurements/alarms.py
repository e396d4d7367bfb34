"""The alarms of the time covered: which limit, how often, how long, how far, when.

One rule: the limits are those of the catalog and those in the recorded events; an alarm is on from
a value beyond the limit until one that is back within it by the hysteresis, that of a flag until
`FLAG_HOLD` seconds after it was last set, as in `sampling/alarms.py`. The values decide wherever
they cover the time; an event counts where they do not show its alarm (its channel was not kept, or
is decoded differently now). A pause of more than `HOLDS` between two values adds nothing to the
duration.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from math import inf, isfinite, nan
from typing import TYPE_CHECKING, Final, TypeAlias

import numpy as np

from mikas.cancellation import check_cancelled
from mikas.catalog import Catalog, Derived, Level, Parameter
from mikas.errors import MikasError
from mikas.recording.table.channels import Rows
from mikas.sampling.alarms import FLAG_HOLD, Side
from mikas.sampling.events import AlarmChanged, Event, StateChanged, UnitFound

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Column = NDArray[np.float64]

HOLDS: Final = 15.0  # s for which a value stands; slow channels come every few seconds
_LEVELS: Final = tuple(Level)
_MOST_OTHER: Final = 64  # limits that the catalog does not have; a damaged file may name any
_ALARMING: Final = (Level.WARNING, Level.DANGER)
Channel: TypeAlias = Parameter | Derived


@dataclass(frozen=True, slots=True)
class Limit:
    """One limit of a channel. For a flag: HIGH, 1."""

    name: str
    level: Level
    side: Side
    value: float

    @property
    def sign(self) -> int:
        """1 if values above it are beyond it, else -1."""
        return 1 if self.side is Side.HIGH else -1

    @property
    def rank(self) -> tuple[int, float]:
        """Greater for a limit that is worse to cross."""
        return _LEVELS.index(self.level), self.sign * self.value


@dataclass(frozen=True, slots=True)
class Alarm:
    """The times beyond one limit. `seconds`: in all; `began`: of the first time; `peak`: the value
    farthest beyond it, at `peaked`; `still`: on at the end. `by_event`: known from events alone.
    `sets`: how often a flag was set; its alarm lasts longer, so it may be on fewer times.
    """

    channel: Channel
    limit: Limit
    times: int
    seconds: float
    began: float
    peak: float
    peaked: float
    still: bool = False
    by_event: bool = False
    sets: int = 0


def limits_of(catalog: Catalog, events: Iterable[Event] = ()) -> tuple[Limit, ...]:
    """Return the limits of the catalog's channels, and those that the alarm events name."""
    found: dict[Limit, None] = {}
    for channel in catalog.channels.values():
        if (own := channel.alarm_limits) is None:
            continue
        if own.for_flag:
            found[Limit(channel.name, own.when_true, Side.HIGH, 1.0)] = None
        for side, on_side in ((Side.HIGH, own.highs), (Side.LOW, own.lows)):
            for level, value in on_side:
                found[Limit(channel.name, level, side, float(value))] = None
    most = len(found) + _MOST_OTHER
    for event in events:
        if (limit := _limit_of(event, catalog)) is not None and len(found) < most:
            found[limit] = None
    return tuple(found)


def _limit_of(event: Event, catalog: Catalog) -> Limit | None:
    """Return the limit that an alarm event names; None for another event, or damaged fields."""
    if not isinstance(event, AlarmChanged) or event.limit is None or not isfinite(event.limit):
        return None
    level = event.before if event.better else event.level  # whose limit the event has
    if level not in _ALARMING or event.side not in tuple(Side):
        return None
    try:
        name = catalog.channel(event.name).name
    except MikasError:  # of a catalog with more channels
        return None
    return Limit(name, Level(level), Side(event.side), float(event.limit))


class AlarmCollector:
    """Watches the limits over consecutive blocks of rows; `events`: of the same time."""

    def __init__(self, catalog: Catalog, events: Sequence[Event] = ()) -> None:
        self._catalog, self._events = catalog, events
        self._watches = [_LimitWatch(limit, catalog) for limit in limits_of(catalog, events)]

    def add(self, rows: Rows) -> None:
        """Add rows, parameters in the corrected interpretation."""
        for watch in self._watches:
            column = rows.values.get(watch.limit.name)
            if column is not None:
                check_cancelled()
                watch.add(rows.times, column)

    @property
    def watched(self) -> frozenset[str]:
        """The channels with limits that had a value."""
        return frozenset(watch.limit.name for watch in self._watches if watch.has_values)

    def alarms(self, began: float | None, ended: float | None) -> tuple[Alarm, ...]:
        """Return the alarms of the values and of the events between two times, worst first."""
        recorded: dict[Limit, list[_Recorded]] = defaultdict(list)
        for each in _recorded(self._events, self._catalog, began, ended):
            recorded[each.limit].append(each)
        found = [
            alarm
            for watch in self._watches
            if (alarm := watch.alarm(recorded[watch.limit])) is not None
        ]
        return tuple(sorted(found, key=lambda it: (-it.limit.rank[0], it.began, -it.limit.rank[1])))


def worst(alarms: Iterable[Alarm]) -> tuple[Alarm, ...]:
    """Return of each channel and side the alarm of the worst limit."""
    found: dict[tuple[str, Side], Alarm] = {}
    for alarm in alarms:
        key = (alarm.limit.name, alarm.limit.side)
        if key not in found or alarm.limit.rank > found[key].limit.rank:
            found[key] = alarm
    return tuple(found.values())


@dataclass(frozen=True, slots=True)
class _Recorded:
    """An alarm as the events have it."""

    limit: Limit
    began: float
    ended: float
    peak: float
    peaked: float
    still: bool


class _LimitWatch:
    """One limit: whether the alarm is on after the last value, and the totals so far."""

    def __init__(self, limit: Limit, catalog: Catalog) -> None:
        self.limit = limit
        self._channel = catalog.channel(limit.name)
        own = self._channel.alarm_limits
        self._hysteresis = own.hysteresis if own is not None else 0.0
        self._on = False
        self._last = nan  # the last value's time
        self._begins: list[Column] = []
        self._ends: list[Column] = []
        self._seconds = 0.0
        self._sets, self._is_set, self._set_at = 0, False, -inf  # of a flag
        self._peak, self._peaked = -inf, nan  # the value times the sign

    @property
    def has_values(self) -> bool:
        return isfinite(self._last)

    def add(self, times: Column, column: Column) -> None:
        there = np.isfinite(column)
        times, values = times[there], column[there] * self.limit.sign
        if not times.size:
            return
        self._last, last = float(times[-1]), self._last
        on = self._held(times, values) if self._channel.is_flag else self._states(values)
        if not (self._on or on.any()):
            return
        steps = np.diff(times, prepend=last)
        before = np.concatenate(([self._on], on[:-1]))
        counted = before & (steps > 0) & (steps <= HOLDS)  # false for the first value: NaN
        self._seconds += float(steps[counted].sum())
        self._begins.append(times[on & ~before])
        self._ends.append(times[~on & before])
        beyond = np.where(on, values, -inf)
        if beyond.max() > self._peak:
            at = int(beyond.argmax())
            self._peak, self._peaked = float(beyond[at]), float(times[at])
        self._on = bool(on[-1])

    def _held(self, times: Column, values: Column) -> NDArray[np.bool_]:
        """Return whether the alarm of a flag is on after each value, and count how often it was
        set.
        """
        is_set: NDArray[np.bool_] = np.not_equal(values, 0)
        if not is_set.any() and self._set_at == -inf:
            return is_set  # the usual case, quick
        before = np.concatenate(([self._is_set], is_set[:-1]))
        self._sets += int((is_set & ~before).sum())
        latest = np.maximum.accumulate(np.where(is_set, np.arange(values.size), -1))
        set_at = np.where(latest >= 0, times[latest], self._set_at)
        since = times - set_at
        self._is_set, self._set_at = bool(is_set[-1]), float(set_at[-1])
        held: NDArray[np.bool_] = is_set | ((since >= 0) & (since < FLAG_HOLD))
        return held

    def _states(self, values: Column) -> NDArray[np.bool_]:
        """Return whether the alarm is on after each value: on beyond the limit, off when it is back
        within it by the hysteresis, else as before.
        """
        over = values - self.limit.sign * self.limit.value
        begins, ends = over > 0, over <= -self._hysteresis
        if not (self._on or begins.any()):
            return begins  # the usual case, quick
        settled = np.where(begins | ends, np.arange(values.size), -1)
        latest = np.maximum.accumulate(settled)
        states: NDArray[np.bool_] = np.where(latest >= 0, begins[latest], self._on)
        return states

    def alarm(self, recorded: Sequence[_Recorded]) -> Alarm | None:
        """Return the alarm; `recorded`: the same one as the events have it."""
        begins = np.concatenate([*self._begins, np.empty(0)])
        ends = np.concatenate([*self._ends, np.full(int(self._on), inf)])
        first, last = np.sort(begins), np.sort(ends)
        alone = [each for each in recorded if not _overlaps(each, first, last)]
        if not begins.size and not alone:
            return None
        sign = self.limit.sign
        peaks = [(sign * each.peak, each.peaked) for each in alone if isfinite(each.peak)]
        if begins.size:
            peaks.append((self._peak, self._peaked))
        peak, peaked = max(peaks, key=lambda it: it[0], default=(nan, nan))
        return Alarm(
            channel=self._channel,
            limit=self.limit,
            times=int(begins.size) + len(alone),
            seconds=self._seconds + sum(each.ended - each.began for each in alone),
            began=float(min([*begins[:1], *(each.began for each in alone)])),
            peak=sign * peak,
            peaked=peaked,
            still=self._on or any(each.still for each in alone),
            by_event=not begins.size,
            sets=self._sets,
        )


def _overlaps(each: _Recorded, begins: Column, ends: Column) -> bool:
    """Whether one of the intervals, given by sorted begins and sorted ends, meets the alarm."""
    began, over = np.searchsorted(begins, each.ended, "right"), np.searchsorted(ends, each.began)
    return bool(began > over)


def _recorded(
    events: Sequence[Event], catalog: Catalog, began: float | None, ended: float | None
) -> Iterator[_Recorded]:
    """Yield the alarms between two times by their events alone.

    An alarm is on from the event with its level until one that ends it; where the line broke or
    another unit answers, nothing is known from then on.
    """
    if began is None or ended is None:
        return
    running: dict[str, list[_Recorded]] = {}

    def over(
        alarms: Iterable[_Recorded], time: float, *, still: bool = False
    ) -> Iterator[_Recorded]:
        for each in alarms:
            first, last = max(began, each.began), min(ended, time)
            if first <= last:
                yield replace(each, began=first, ended=last, still=still)

    for event in events:
        if isinstance(event, UnitFound) or (isinstance(event, StateChanged) and event.is_broken):
            for name in list(running):
                yield from over(running.pop(name), event.time)
        limit = _limit_of(event, catalog)
        if limit is None or not isinstance(event, AlarmChanged):
            continue
        now = running.pop(limit.name, [])
        yield from over((it for it in now if _ends(it.limit, event, limit)), event.time)
        kept = [_further(it, event) for it in now if not _ends(it.limit, event, limit)]
        if not event.better and all(it.limit != limit for it in kept):
            value = nan if event.value is None else event.value
            kept.append(_Recorded(limit, event.time, inf, value, event.time, still=False))
        running[limit.name] = kept
    for left in running.values():
        yield from over(left, ended, still=True)


def _ends(on: Limit, event: AlarmChanged, named: Limit) -> bool:
    """Whether an alarm that is on ends by an event of its channel."""
    if event.level not in _ALARMING:
        return True
    if on.side is not named.side:
        return True
    return _LEVELS.index(on.level) > _LEVELS.index(Level(event.level))


def _further(alarm: _Recorded, event: AlarmChanged) -> _Recorded:
    sign = alarm.limit.sign
    if event.value is None or (isfinite(alarm.peak) and sign * event.value <= sign * alarm.peak):
        return alarm
    return replace(alarm, peak=event.value, peaked=event.time)
