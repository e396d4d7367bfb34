"""The value axes of the lines in one pane: one for each unit, fitted to its visible part.

The rule of the dashboard's chart (`web/src/lib/series/valueAxis.ts`); the cases in
`valueAxis.cases.json` beside it hold both equal. An axis is never narrower than the catalog's least
span, so that noise does not fill it, and does not go below 0 for a channel that can't. Constant
lines never cover each other: the axes have their middles at different heights.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from sys import float_info
from typing import Final

from mikas.catalog import Derived, InstrumentChannel, Parameter
from mikas.recording.table.channels import Channel

# Room above and below the values, as a share of their extent.
_ROOM: Final = 0.06
# The height of 0 on the first axis that begins there, and how much higher on each further one.
_FOOT: Final = 0.03
_HIGHER: Final = 0.05
# A line that moves less than this share of its axis counts as constant.
_STILL: Final = 0.02
_FLAG: Final = 0.24  # the height of a flag's own lane at the foot of the pane


@dataclass(frozen=True, slots=True)
class Scale:
    """What the catalog says of a channel's axis; `key`: what the lines of one axis share."""

    name: str
    key: str
    is_flag: bool = False
    least_span: float = 10.0
    never_negative: bool = True


@dataclass(frozen=True, slots=True)
class AxisLine:
    """A line. `seen`: its extremes, None without a value. `band`: a range drawn behind it."""

    scale: Scale
    seen: tuple[float, float] | None
    band: tuple[float, float] | None = None


@dataclass(frozen=True, slots=True)
class Axis:
    """The values at the lower and the upper edge. `floor`: values below 0 do not exist."""

    low: float
    high: float
    floor: bool


def scale_of(channel: Parameter | Derived | InstrumentChannel | Channel, key: str) -> Scale:
    """Return what the catalog says of the channel's axis. A `Channel`: it says nothing."""
    if isinstance(channel, Channel):
        least = 10 * 10.0**-channel.decimals
        return Scale(channel.name, key, channel.is_flag, least, never_negative=False)
    extent = channel.range or channel.gauge
    own = channel.span_least if isinstance(channel, InstrumentChannel) else channel.least_span
    least = own or 10 * 10.0**-channel.decimals
    return Scale(channel.name, key, channel.is_flag, least, extent is None or extent[0] >= 0)


def axes_of(lines: Sequence[AxisLine]) -> list[Axis]:
    """Return the axis of each line; lines of one key have the same."""
    flags = [line for line in lines if line.scale.is_flag]
    axes = {line.scale.key: _lane(at, len(flags)) for at, line in enumerate(flags)}
    taken = [height for line in flags for height in _heights([line], axes[line.scale.key])]
    keys = list(dict.fromkeys(line.scale.key for line in lines if not line.scale.is_flag))
    for rank, key in enumerate(keys):
        own = [line for line in lines if line.scale.key == key]
        axis = _apart(own, _fitted(own, rank, len(keys)), taken, len(lines))
        taken += _heights(own, axis)
        axes[key] = axis
    return [axes[line.scale.key] for line in lines]


def stacked_axes(lines: Sequence[AxisLine]) -> list[Axis]:
    """Return an axis for each line that places it in a lane of its own, the first at the top."""
    axes = []
    for at, line in enumerate(lines):
        alone = Axis(-0.15, 1.15, floor=True) if line.scale.is_flag else axes_of([line])[0]
        height = alone.high - alone.low
        bottom = alone.low - height * (len(lines) - 1 - at)
        axes.append(replace(alone, low=bottom, high=bottom + height * len(lines)))
    return axes


def _wanted(lines: Sequence[AxisLine]) -> tuple[float, float]:
    """Return the least and the greatest value that the axis of `lines` has to show."""
    seen = [span for line in lines for span in (line.seen, line.band) if span is not None]
    return (min(low for low, _ in seen), max(high for _, high in seen)) if seen else (0.0, 0.0)


def _fitted(lines: Sequence[AxisLine], rank: int, count: int) -> Axis:
    """Return the axis number `rank` of `count`, a constant line's height on which is its own."""
    low, high = _wanted(lines)
    finest = 16 * float_info.epsilon * max(abs(low), abs(high))  # both edges differ in any case
    least = max(line.scale.least_span for line in lines)
    extent = max((high - low) * (1 + 2 * _ROOM), least, finest) or 1.0
    bottom = low - (extent - (high - low)) * (count - rank) / (count + 1)
    stands = low >= 0 and all(line.scale.never_negative for line in lines)
    if stands:
        bottom = max(bottom, -extent * (_FOOT + _HIGHER * rank))
    return Axis(bottom, bottom + extent, stands)


def _lane(index: int, count: int) -> Axis:
    """Return a flag's axis: flags stand over each other at the foot, each in a lane of its own."""
    height = min(_FLAG, 0.9 / count)
    extent = 1 / (0.8 * height)
    low = -(_FOOT + index * height) * extent
    return Axis(low, low + extent, floor=True)


def _height(axis: Axis, value: float) -> float:
    return (value - axis.low) / (axis.high - axis.low)


def _moved(axis: Axis, share: float) -> Axis:
    """Return the same axis with every value `share` of the pane higher."""
    by = share * (axis.high - axis.low)
    return replace(axis, low=axis.low - by, high=axis.high - by)


def _heights(lines: Sequence[AxisLine], axis: Axis) -> list[float]:
    """Return the heights of the constant lines."""
    still = _STILL * (axis.high - axis.low)
    seen = [line.seen for line in lines if line.seen is not None]
    return [_height(axis, (low + high) / 2) for low, high in seen if high - low <= still]


def _apart(lines: Sequence[AxisLine], axis: Axis, taken: Sequence[float], count: int) -> Axis:
    """Move the axis until no constant line is at a height that is taken.

    If there is no room to move, it becomes longer.
    """
    distance = min(0.05, 0.4 / count)
    low, high = _wanted(lines)
    tried = axis
    for _ in range(6):
        bottom, top = _height(tried, low), _height(tried, high)
        for way in _ways(distance):
            if way and (bottom + way < _FOOT / 2 or top + way > 1 - _FOOT / 2):
                continue
            placed = _moved(tried, way)
            own = _heights(lines, placed)
            if all(abs(one - other) >= distance - 1e-9 for one in own for other in taken):
                return placed
        tried = replace(tried, high=tried.low + (tried.high - tried.low) * 1.3)
    return axis


def _ways(distance: float) -> Iterator[float]:
    yield 0.0
    step = 1
    while step * distance < 1:
        yield step * distance
        yield -step * distance
        step += 1
