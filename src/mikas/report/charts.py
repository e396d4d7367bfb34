"""A chart as an SVG drawing: a channel's envelope, its reference as a band, the warm idle.

The number of its parts does not depend on the length of the recording or on its number of gaps.
Texts are escaped. No script and no `style` attribute: a page with a strict
Content-Security-Policy shows it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import ceil, floor, log10
from typing import TYPE_CHECKING, Final

import numpy as np
from markupsafe import Markup, escape

from mikas.i18n import Language, Text
from mikas.recording.formatting import clock, number
from mikas.report.measurements.alarms import Channel
from mikas.report.measurements.statistics import Envelope

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Column = NDArray[np.float64]

Span = tuple[float, float]

WIDTH: Final = 320
HEIGHT: Final = 190
_LEFT, _RIGHT, _TOP, _BOTTOM = 46, 314, 10, 154
_STRIP: Final = 5  # the bar of warm idle, on the time line
_TICKS: Final = 4
_MOST_BARS: Final = 300
_HUGE: Final = 1e100  # beyond all values with a meaning; differences of larger ones overflow


def chart(
    channel: Channel,
    curve: Envelope,
    seconds: float,
    language: Language,
    *,
    idle: Sequence[Span] = (),
    pauses: Sequence[Span] = (),
    label: str = "",
) -> Markup:
    """Return the drawing. `seconds`: length of the time axis; spans are in seconds on it."""
    reference = channel.reference
    plot = _Frame(max(seconds, curve.width), *_ends(curve, channel))
    parts = [
        svg("title", label),
        *(plot.bar("pause", span) for span in plot.distinct(pauses)),
        *([plot.level(reference)] if reference else []),
        *_value_axis(plot, channel, language),
        *_time_axis(plot, language),
        plot.course(curve),
        *(plot.bar("idle", span, _BOTTOM - _STRIP) for span in plot.distinct(idle)),
        svg("rect", cls="frame", x=_LEFT, y=_TOP, width=_RIGHT - _LEFT, height=_BOTTOM - _TOP),
    ]
    return Markup(
        '<svg class="chart" viewBox="0 0 {} {}" role="img" aria-label="{}">{}</svg>'
    ).format(WIDTH, HEIGHT, label, Markup("").join(parts))


class _Frame:
    """Converts seconds and values to coordinates."""

    def __init__(self, seconds: float, low: float, high: float) -> None:
        self.seconds, self.low, self.high = seconds, low, high

    def x(self, seconds: float) -> float:
        share = min(1.0, max(0.0, seconds / self.seconds))
        return _LEFT + share * (_RIGHT - _LEFT)

    def y(self, value: float) -> float:
        return _BOTTOM - (value - self.low) / (self.high - self.low) * (_BOTTOM - _TOP)

    def distinct(self, spans: Sequence[Span]) -> list[Span]:
        """Return the spans; if there are many, those that touch in the drawing as one."""
        if len(spans) <= _MOST_BARS:
            return list(spans)
        least = self.seconds / _MOST_BARS
        joined: list[Span] = []
        for began, ended in sorted((max(0.0, a), min(self.seconds, b)) for a, b in spans):
            if joined and began - joined[-1][0] < least:
                joined[-1] = joined[-1][0], max(ended, joined[-1][1])
            else:
                joined.append((began, ended))
        return joined

    def bar(self, cls: str, span: Span, top: int = _TOP) -> Markup:
        x = self.x(span[0])
        width = max(0.5, self.x(span[1]) - x)
        return svg("rect", cls=cls, x=x, y=top, width=width, height=_BOTTOM - top)

    def level(self, band: Span) -> Markup:
        top, bottom = self.y(band[1]), self.y(band[0])
        height = max(1.5, bottom - top)  # a band of one value is a line
        return svg("rect", cls="band", x=_LEFT, y=top, width=_RIGHT - _LEFT, height=height)

    def course(self, curve: Envelope) -> Markup:
        """Draw a line from column to column, up and down within each; broken without data."""
        pieces = []
        for run in _runs(np.isfinite(curve.most)):
            points = []
            for place in run:
                x = f"{self.x(curve.middles[place]):.1f}"
                low, high = self.y(curve.least[place]), self.y(curve.most[place])
                points.append(f"{x} {low:.1f}")
                if low - high >= 0.1:
                    points.append(f"{x} {high:.1f}")
            start = f"M{points[0]}"
            pieces.append(start + ("L" + " ".join(points[1:]) if points[1:] else "h0.5"))
        return svg("path", cls="course", d="".join(pieces))


def _runs(there: NDArray[np.bool_]) -> Iterator[range]:
    """Yield runs of columns with values; near ones are joined, as a slow parameter is read in every
    tenth cycle only.
    """
    places = np.flatnonzero(there)
    if not places.size:
        return
    nearest = max(2, 3 * int(np.median(np.diff(places)))) if places.size > 1 else 2
    for piece in np.split(places, np.flatnonzero(np.diff(places) > nearest) + 1):
        yield piece.tolist()


def _ends(curve: Envelope, channel: Channel) -> Span:
    """Return the ends of the value axis: all values and the reference are between them."""
    low, high = float(np.nanmin(curve.least)), float(np.nanmax(curve.most))
    if channel.reference is not None:
        low, high = min(low, channel.reference[0]), max(high, channel.reference[1])
    return axis_ends(low, high, channel)


def axis_ends(low: float, high: float, channel: Channel) -> Span:
    """Return the ends of a value axis, with room around `low` … `high`.

    It has the catalog's least span, and no negative part for a channel without negative values.
    """
    low, high = max(low, -_HUGE), min(high, _HUGE)
    lacking = ((channel.least_span or 0) - (high - low)) / 2
    room = max((high - low) * 0.06, lacking, 1e-9 * max(abs(low), abs(high)))
    possible = channel.range or channel.gauge_scale or (0, 0)
    if 0 <= low < room and possible[0] >= 0:
        return 0.0, high + 2 * room - low
    return low - room, high + room


def _value_axis(plot: _Frame, channel: Channel, language: Language) -> Iterator[Markup]:
    decimals, step = _step(plot.high - plot.low, channel.decimals)
    for count in range(ceil(plot.low / step), floor(plot.high / step) + 1):
        y = plot.y(count * step)
        yield svg("line", cls="grid", x1=_LEFT, x2=_RIGHT, y1=y, y2=y)
        text = number(count * step, decimals, language)
        yield svg("text", text, cls="value", x=_LEFT - 5, y=y + 3.5)


def _step(span: float, decimals: int) -> tuple[int, float]:
    """Return the number of decimals and a round distance between grid lines."""
    raw = max(span / _TICKS, 10.0**-decimals)
    power = floor(log10(raw))
    step = next(each for each in (1, 2, 5, 10) if each * 10**power >= raw * 0.999) * 10.0**power
    return max(0, -floor(log10(step) + 1e-9)), step


_TIME_STEPS: Final = (1, 2, 5, 10, 15, 30, 60, 120, 300, 600, 900, 1800, 3600, 7200, 14400, 36000)


_DAY: Final = 86400


def _time_axis(plot: _Frame, language: Language) -> Iterator[Markup]:
    step = _time_step(plot.seconds)
    for count in range(floor(plot.seconds / step) + 1):
        x = plot.x(count * step)
        yield svg("line", cls="grid", x1=x, x2=x, y1=_TOP, y2=_BOTTOM)
        label = clock(count * step)
        if step >= _DAY:
            days = count * step // _DAY
            label = Text(f"{days} d", f"{days} дн.").to(language)
        yield svg("text", label, cls="time", x=x, y=_BOTTOM + 16)


def _time_step(seconds: float) -> int:
    """Return a round distance between grid lines, of which there are at most six."""
    for step in _TIME_STEPS:
        if seconds / step <= _TICKS + 1:
            return step
    _, days = _step(seconds * _TICKS / (_TICKS + 1) / _DAY, 0)
    return _DAY * round(days)


def svg(tag: str, text: str = "", *, cls: str = "", **attributes: float | str) -> Markup:
    """Return an element of a drawing."""
    given = {"class": cls, **attributes} if cls else dict(attributes)
    pairs = "".join(
        f' {name}="{f"{value:.1f}" if isinstance(value, float) else escape(value)}"'
        for name, value in given.items()
    )
    return Markup(f"<{tag}{pairs}>{escape(text)}</{tag}>")
