"""Alarms: channels beyond their limits, and the events at which an alarm level changes.

    values ──► Alarms.update ──► AlarmChanged      at each change of level

A level begins beyond its limit and ends when the value is back within it by the hysteresis: noise
at a limit makes one event. That of a flag lasts until `FLAG_HOLD` seconds after it was last set: a
knock is shown for an eighth of a second, too short to be seen. A missing value changes no level.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from enum import StrEnum
from math import inf, isfinite, nan
from typing import Final, TypeAlias

from mikas.catalog import Catalog, Derived, InstrumentChannel, Level, Parameter
from mikas.client.parameters.derived import DerivedValue, number_of
from mikas.client.parameters.readings import Reading
from mikas.i18n import Text, joined, unit_after
from mikas.sampling.events import AlarmChanged

Value: TypeAlias = Reading | DerivedValue | float | None
"""A bare number is in the corrected interpretation and of the sample's time."""

FLAG_HOLD: Final = 3.0
"""Seconds after its last set value for which the alarm of a flag stays on."""

_FRESH = 1.0  # s; a value that is older than its sample by more is missing
_LEVELS = tuple(Level)
LEVEL_TEXTS = {
    Level.NONE: Text("no alarm", "тревоги нет"),
    Level.WARNING: Text("warning", "предупреждение"),
    Level.DANGER: Text("danger", "опасность"),
}


class Side(StrEnum):
    """The side on which the value is beyond its limit; a set flag is HIGH."""

    LOW = "low"
    HIGH = "high"


BEYOND = {Side.LOW: Text("below", "ниже"), Side.HIGH: Text("above", "выше")}


@dataclass(frozen=True, slots=True)
class AlarmState:
    """The alarm of a channel, by `value`, its latest one; None before the first.

    `side` and `limit` are None without an alarm. `set_at`: when a flag was set last.
    """

    channel: Parameter | Derived | InstrumentChannel
    level: Level = Level.NONE
    side: Side | None = None
    limit: float | None = None
    value: float | None = None
    set_at: float = -inf


class Alarms:
    """Compares each of `channels`, or of a catalog's, that has limits with these."""

    def __init__(self, channels: Catalog | Iterable[Derived | InstrumentChannel]) -> None:
        every = channels.channels.values() if isinstance(channels, Catalog) else channels
        self.states: dict[str, AlarmState] = {
            each.name: AlarmState(each) for each in every if each.alarm_limits
        }
        """The state of each channel that has limits, by name."""

    def update(self, values: Mapping[str, Value], time: float) -> list[AlarmChanged]:
        """Return the changes of level by this sample, in the order of the catalog."""
        events = []
        for name, state in self.states.items():
            if not isfinite(value := _number(values.get(name), time)):
                continue
            level, side, limit = _level_of(state, value, time)
            set_at = time if state.channel.is_flag and value else state.set_at
            after = AlarmState(state.channel, level, side, limit, value, set_at)
            self.states[name] = after
            if (level, side) != (state.level, state.side):
                events.append(_event(state, after, time))
        return events

    def lose(self, names: Iterable[str], time: float) -> list[AlarmChanged]:
        """Return the ends of the alarms of these channels, which have no value any more."""
        ended = []
        for name in names:
            state = self.states.get(name)
            if state is not None and state.level is not Level.NONE:
                en, ru = state.channel.text
                text = Text(f"{en}: no value any more", f"{ru}: значений больше нет")
                after = self.states[name] = AlarmState(state.channel, value=state.value)
                ended.append(_event(state, after, time, text))
        return ended

    def continue_from(self, before: Alarms, time: float) -> list[AlarmChanged]:
        """Take over the states of channels whose limits are the same; return the ends of the other
        alarms: these begin again at the next value that is beyond the present limits.
        """
        ended = []
        for name, state in before.states.items():
            now, channel = self.states.get(name), state.channel
            if now is not None and now.channel.alarm_limits == channel.alarm_limits:
                self.states[name] = replace(state, channel=now.channel)
            elif state.level is not Level.NONE:
                en, ru = channel.text
                text = Text(f"{en}: the limits were changed", f"{ru}: пределы изменены")
                ended.append(_event(state, AlarmState(channel, value=state.value), time, text))
        return ended


def _number(value: Value, time: float) -> float:
    if isinstance(value, Reading | DerivedValue):
        return number_of(value) if abs(time - value.time) <= _FRESH else nan
    return nan if value is None else float(value)


def _level_of(
    state: AlarmState, value: float, time: float
) -> tuple[Level, Side | None, float | None]:
    """Return the level of `value` at `time`, after `state`, its side and its limit."""
    limits = state.channel.alarm_limits
    assert limits is not None
    if limits.for_flag:
        is_on = bool(value) or 0 <= time - state.set_at < FLAG_HOLD
        return (limits.when_true, Side.HIGH, 1.0) if is_on else (Level.NONE, None, None)
    for side, sign, on_side in ((Side.HIGH, 1, limits.highs), (Side.LOW, -1, limits.lows)):
        held = _LEVELS.index(state.level) if state.side is side else 0
        for level, limit in reversed(on_side):
            margin = limits.hysteresis if _LEVELS.index(level) <= held else 0
            if sign * (value - limit) > -margin:
                return level, side, limit
    return Level.NONE, None, None


def _event(
    before: AlarmState, after: AlarmState, time: float, text: Text | None = None
) -> AlarmChanged:
    """Return the event of a change; `text`: instead of a sentence on the value."""
    better = after.side is None or (
        after.side is before.side and _LEVELS.index(after.level) < _LEVELS.index(before.level)
    )
    crossed = before if better else after
    assert crossed.side is not None
    assert crossed.limit is not None
    now = replace(crossed, level=after.level, value=after.value)
    return AlarmChanged(
        time,
        after.channel.name,
        after.level,
        before.level,
        crossed.side,
        after.value,
        crossed.limit,
        text or _sentence(before.level, now, better=better),
        better,
    )


def _sentence(before: Level, now: AlarmState, *, better: bool) -> Text:
    """Return the change as one sentence; `now` has the crossed limit and its side."""
    level, previous = LEVEL_TEXTS[now.level], LEVEL_TEXTS[before]
    name, unit = now.channel.text, now.channel.unit_text
    if now.channel.is_flag:
        if now.level is Level.NONE:
            return Text(f"{name.en}: over", f"{name.ru}: прекратилось")
        return Text(f"{name.en}: {level.en}", f"{name.ru}: {level.ru}")
    assert now.side is not None
    value = _with_unit(f"{now.value:.{now.channel.decimals}f}", unit)
    limit = _with_unit(f"{now.limit:.10g}", unit)
    en, ru = f"{name.en} {value.en}", f"{name.ru} {value.ru}"
    if not better:
        where = BEYOND[now.side]
        return Text(
            f"{en} is {where.en} {limit.en}: {level.en}",
            f"{ru} {where.ru} {limit.ru}: {level.ru}",
        )
    if now.level is Level.NONE:
        return Text(f"{en}: back within {limit.en}", f"{ru}: снова в пределах {limit.ru}")
    return Text(
        f"{en}: no longer {previous.en}, still {level.en}",
        f"{ru}: уже не {previous.ru}, но ещё {level.ru}",
    )


def _with_unit(number: str, unit: Text) -> Text:
    """Return a number with its unit; Russian has a decimal comma."""
    shown = Text(number, number.replace(".", ","))
    return Text(*map(str.rstrip, joined(" ", (shown, unit_after(shown, unit)))))
