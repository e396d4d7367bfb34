"""A picture of a recording, drawn with matplotlib (the extra `plot`).

As the dashboard's chart: panes that share time, an axis for each unit, at most two of which have
labels; gaps hatched below the lines, flags in lanes at the foot, markers and alarms above. A text
from a recording is never taken for mathematics between two `$`.
"""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from matplotlib import pyplot as plt
from matplotlib.colors import to_rgb
from matplotlib.ticker import FuncFormatter, Locator, MaxNLocator
from matplotlib.transforms import ScaledTranslation

from mikas.notebook import time_axis
from mikas.notebook.panes import DAY, NIGHT, Palette
from mikas.notebook.picture import Picture, PlottedLine
from mikas.recording.formatting import short
from mikas.recording.table.channels import calendar, united

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D

_WIDTH: Final = 10.0  # inches; of the figure
_PANE: Final = 1.5  # the height of a pane's plot
_LEGEND: Final = 0.28  # above each pane
_HEAD: Final = 0.25  # the title; as much again for flags
_FOOT: Final = 0.35
_SIDE: Final = 0.65  # an axis with labels
_MARGIN: Final = 0.3
_LETTER: Final = 0.07  # inches; the width of one
_SMALL: Final = 8.5
_DOT: Final = 2.5  # points; the width of a value that stands alone
_BESIDE: Final = 0.03  # inches between two lines that would cover each other
_STRIPE, _EDGE = 0.13, 0.5  # how opaque a reference's range and its edges are
_MOST_GAPS: Final = 500  # hatched one by one
_SHORTEST_REASON: Final = 0.7  # inches of a gap that has room for its reason
_SHORTEST_FLAG, _LONGEST_FLAG = 4, 30  # characters


@dataclass(frozen=True, eq=False)
class Plot:
    """A drawn recording; its times are seconds from the first row.

    `panes`: from top to bottom, each with the axis at the left. `axes` and `lines`: matplotlib's,
    by channel.
    """

    figure: Figure
    """matplotlib's figure."""
    panes: tuple[Axes, ...]
    axes: dict[str, Axes] = field(repr=False)
    lines: dict[str, Line2D] = field(repr=False)

    def _ipython_display_(self) -> None:
        """Show the figure, unless the notebook shows it at the end of the cell by itself."""
        if not plt.fignum_exists(getattr(self.figure, "number", -1)):
            from IPython.display import display

            display(self.figure)  # type: ignore[no-untyped-call]  # IPython's


def draw(picture: Picture, figsize: tuple[float, float] | None, ax: Axes | None) -> Plot:
    """Draw the picture in a new figure, or its only pane in `ax`."""
    figure: Figure
    if ax is None:
        figure, panes = _figure(picture, figsize)
    else:
        figure, panes = ax.figure.figure, (ax,)  # not a part of it
    plot = Plot(figure, panes, {}, {})
    palette = NIGHT if _is_dark(panes[0]) else DAY
    for pane, lines in zip(panes, picture.panes, strict=True):
        _Pane(pane, picture, palette).draw(lines, plot)
    _flags(panes, picture, palette)
    foot = panes[-1]
    foot.xaxis.set_major_locator(_RoundTimes(picture.zero))
    foot.xaxis.set_major_formatter(FuncFormatter(partial(_time_label, picture)))
    foot.set_xlim(picture.begin, picture.end)
    _reasons(foot, picture, palette)
    return plot


def _figure(
    picture: Picture, figsize: tuple[float, float] | None
) -> tuple[Figure, tuple[Axes, ...]]:
    count = len(picture.panes)
    head = _HEAD * (2 if picture.flags else 1) + _LEGEND
    whole = head + count * _PANE + (count - 1) * _LEGEND + _FOOT
    width, height = figsize or (_WIDTH, whole)
    pane = max(0.3, (height - head - _FOOT - (count - 1) * _LEGEND) / count)
    is_right = not picture.stacked and any(len(_keys(lines)) > 1 for lines in picture.panes)
    figure, axes = plt.subplots(
        count,
        sharex=True,
        squeeze=False,
        figsize=(width, height),
        gridspec_kw={
            "left": _SIDE / width,
            "right": 1 - (_SIDE if is_right else _MARGIN) / width,
            "top": max(0.3, 1 - head / height),
            "bottom": min(0.2, _FOOT / height),
            "hspace": _LEGEND / pane,
        },
    )
    figure.text(
        _MARGIN / width, 1 - 0.08 / height, picture.title, va="top", size="medium", parse_math=False
    )
    return figure, tuple(axes[:, 0])


def _keys(lines: Sequence[PlottedLine]) -> list[str]:
    """Return the keys of the axes with labels: not those of flags."""
    return list(dict.fromkeys(it.key for it in lines if not it.trace.channel.is_flag))[:2]


def _is_dark(ax: Axes) -> bool:
    red, green, blue = to_rgb(ax.get_facecolor())
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue < 0.5


class _Pane:
    """Draws one pane. Each axis of values is a matplotlib `Axes`; the first one has the ground."""

    def __init__(self, ax: Axes, picture: Picture, palette: Palette) -> None:
        self._ax, self._picture, self._palette = ax, picture, palette

    def draw(self, lines: Sequence[PlottedLine], plot: Plot) -> None:
        self._gaps()
        self._ax.grid(visible=True, alpha=0.35, linewidth=0.6)
        self._ax.set_axisbelow(True)
        self._ax.margins(x=0)
        keys = [] if self._picture.stacked else _keys(lines)
        for number, group in enumerate(self._groups(lines)):
            ax = self._ax if number == 0 else self._ax.twinx()
            self._axis(ax, group, keys)
            for line in group:
                plot.axes[line.trace.channel.name] = ax
                plot.lines[line.trace.channel.name] = self._line(ax, line)
        self._legend([plot.lines[line.trace.channel.name] for line in lines], lines)

    def _groups(self, lines: Sequence[PlottedLine]) -> list[list[PlottedLine]]:
        """Return the lines of each axis, those with labels first."""
        if self._picture.stacked:
            return [[line] for line in lines]
        groups: dict[str, list[PlottedLine]] = {}
        for line in sorted(lines, key=lambda line: line.trace.channel.is_flag):
            groups.setdefault(line.key, []).append(line)
        return list(groups.values())

    def _axis(self, ax: Axes, group: Sequence[PlottedLine], keys: Sequence[str]) -> None:
        axis, colour = group[0].axis, self._palette.muted
        if len(group) == 1:
            colour = self._palette.traces[group[0].trace.colour]
        ax.set_ylim(axis.low, axis.high)
        if ax is not self._ax:
            ax.grid(visible=False)
            ax.xaxis.set_visible(False)
        if group[0].key not in keys:
            ax.yaxis.set_visible(False)
            return
        ax.yaxis.set_major_locator(_Values(floor=axis.floor))
        language = self._picture.language
        ax.yaxis.set_major_formatter(FuncFormatter(lambda value, _: short(value, language)))
        ax.tick_params(axis="y", colors=colour, labelsize=_SMALL)
        self._ax.tick_params(axis="x", labelsize=_SMALL)

    def _line(self, ax: Axes, line: PlottedLine) -> Line2D:
        channel, colour = line.trace.channel, self._palette.traces[line.trace.colour]
        if line.band is not None and not channel.is_flag:
            low, high = line.band
            ax.axhspan(low, high, color=colour, alpha=_STRIPE, linewidth=0)
            for edge in line.band:
                ax.axhline(edge, color=colour, alpha=_EDGE, linewidth=0.8)
        style: dict[str, Any] = {"drawstyle": "steps-post"} if channel.is_flag else {}
        alone = _alone(line)
        if alone:
            style |= {"marker": "o", "markersize": _DOT, "markevery": alone}
        if line.covered:
            up = ScaledTranslation(0, line.covered * _BESIDE, ax.figure.dpi_scale_trans)
            style["transform"] = ax.transData + up
        (drawn,) = ax.plot(
            line.times, line.values, color=colour, linewidth=1.2, label=channel.name, **style
        )
        return drawn

    def _legend(self, drawn: Sequence[Line2D], lines: Sequence[PlottedLine]) -> None:
        catalog, language = self._picture.catalog, self._picture.language
        labels = []
        for line in lines:
            channel = line.trace.channel
            known = catalog.described(channel.name)
            short = known.short if known is not None and known.short.en else channel.text
            text = short.to(language) or channel.name
            has_text = known is not None and known.unit == channel.unit
            unit = known.unit_text.to(language) if known and has_text else channel.unit_in(language)
            # matplotlib leaves out what begins with “_”.
            labels.append((f"{text}, {unit}" if unit else text).lstrip("_") or channel.name)
        legend = self._ax.legend(
            drawn,
            labels,
            loc="lower left",
            bbox_to_anchor=(0, 1),
            borderaxespad=0.1,
            ncols=max(1, min(4, len(labels))),
            frameon=False,
            fontsize=_SMALL,
            handlelength=1.2,
            columnspacing=1.4,
        )
        for label in legend.get_texts():
            label.set_parse_math(False)

    def _gaps(self) -> None:
        picture = self._picture
        # Many are hatched as one where they touch in the picture.
        many = len(picture.gaps) > _MOST_GAPS
        near = (picture.end - picture.begin) / _MOST_GAPS if many else 0.0
        spans = united((span for span, _ in picture.gaps), near)
        self._ax.broken_barh(
            [(begin, end - begin) for begin, end in spans],
            (0, 1),
            transform=self._ax.get_xaxis_transform(),
            facecolor="none",
            edgecolor=self._palette.hatch,
            hatch="////",
            linewidth=0,
            zorder=0.5,
        )


def _alone(line: PlottedLine) -> list[int]:
    """Return the places of the values that stand alone: a line from there leads nowhere."""
    there = np.isfinite(np.concatenate([[np.nan], line.values, [np.nan]]))
    return np.flatnonzero(there[1:-1] & ~there[:-2] & ~there[2:]).tolist()


def _reasons(foot: Axes, picture: Picture, palette: Palette) -> None:
    """Write the reason of each gap that has room for it, at the foot of the lowest pane."""
    inches = foot.get_window_extent().width / foot.figure.dpi
    for (begin, end), reason in picture.gaps[:_MOST_GAPS]:
        left, right = max(begin, picture.begin), min(end, picture.end)
        room = (right - left) / (picture.end - picture.begin) * inches
        if reason is None or room < _SHORTEST_REASON:
            continue
        words = reason.to(picture.language)
        lines = textwrap.wrap(words, int(room / _LETTER), max_lines=3, placeholder="…")
        foot.annotate(
            "\n".join(lines),
            (left, 0),
            xycoords=("data", "axes fraction"),
            xytext=(3, 3),
            textcoords="offset points",
            size=_SMALL - 1,
            color=palette.text,
            bbox={"facecolor": foot.get_facecolor(), "edgecolor": "none", "pad": 1},
            parse_math=False,
        )


def _flags(panes: Sequence[Axes], picture: Picture, palette: Palette) -> None:
    """Draw markers and alarms: a line through all panes, its text above the first one."""
    colours = {"warning": palette.warning, "danger": palette.danger}
    length = picture.end - picture.begin
    inches = panes[0].get_window_extent().width / panes[0].figure.dpi
    flags = sorted(picture.flags, key=lambda flag: flag.time)
    places = [int((flag.time - picture.begin) / length * inches / _LETTER) for flag in flags]
    last, taken = int(inches / _LETTER), 0
    for flag, place, after in zip(flags, places, [*places[1:], last], strict=False):
        colour = colours.get(flag.kind, palette.text)
        for pane in panes:
            pane.axvline(flag.time, color=colour, linewidth=0.9, linestyle=(0, (4, 3)))
        count = f" ×{flag.count}" if flag.count > 1 else ""
        sign = "⚑" if flag.kind == "marker" else "▲"
        words = f"{sign} {flag.text.to(picture.language)}{count}"
        at_left = after == last and after - place < min(len(words), place - taken)
        room = min((place - taken) if at_left else (after - place), _LONGEST_FLAG)
        taken = place + max(0, min(after - place, len(words)))
        if room < _SHORTEST_FLAG:
            continue
        panes[0].annotate(
            words if len(words) <= room else f"{words[: room - 1]}…",
            (flag.time, 1),
            xycoords=("data", "axes fraction"),
            xytext=(0, 72 * _LEGEND - 2),
            textcoords="offset points",
            ha="right" if at_left else "left",
            size=_SMALL,
            color=colour,
            annotation_clip=True,
            parse_math=False,
        )


class _Values(MaxNLocator):
    """Round values. Below 0 there may be room, but there are no values: nothing is labelled."""

    def __init__(self, *, floor: bool) -> None:
        super().__init__(nbins=4, steps=[1, 2, 2.5, 5, 10])
        self._floor = floor

    def tick_values(self, vmin: float, vmax: float) -> Any:  # noqa: ANN401  (as its base)
        ticks = super().tick_values(vmin, vmax)
        return [tick for tick in ticks if tick >= 0 or not self._floor]


class _RoundTimes(Locator):
    """Round times of the day; on a simulated clock, round seconds from the first row."""

    def __init__(self, zero: float) -> None:
        self._zero = zero

    def __call__(self) -> Any:  # noqa: ANN401  (as its base)
        assert self.axis is not None
        return self.tick_values(*self.axis.get_view_interval())

    def tick_values(self, vmin: float, vmax: float) -> Any:  # noqa: ANN401  (as its base)
        zero = self._zero
        origin = zero if calendar(zero) is None else time_axis.midnight_offset(zero)
        return [time - zero for time in time_axis.round_times(zero + vmin, zero + vmax, origin)]


def _time_label(picture: Picture, seconds: float, _: object = None) -> str:
    """Return the label of a time: of the day, or since the first row."""
    step = time_axis.step_of(picture.begin, picture.end)
    if calendar(picture.zero) is None:
        return time_axis.elapsed(seconds, step, picture.language)
    return time_axis.time_of_day(picture.zero + seconds, step, picture.language)
