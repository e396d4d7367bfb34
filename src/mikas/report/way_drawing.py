"""The way of the car as an SVG drawing on a grid of its own: no map, nothing from elsewhere.

North is above. The colour is the speed, in five classes. The number of points is bounded: those
that fall on the same place of the drawing are one.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import floor, log10
from typing import Final

from markupsafe import Markup

from mikas.drives.way_lines import SPEEDS, way_lines
from mikas.drives.ways import WayStretch
from mikas.i18n import Language, Text
from mikas.recording.formatting import number
from mikas.report.charts import svg

WIDTH: Final = 640
LEAST_HEIGHT: Final = 150.0
MOST_HEIGHT: Final = 420.0
_EDGE: Final = 14.0
_FOOT: Final = 26.0  # for the scale
_NEAR: Final = 1.2  # of the drawing, within which two places are one
_LEAST: Final = 50.0  # m that it shows at least
_CELLS: Final = 5  # from left to right, at least; at most thirteen


def way_drawing(way: Sequence[WayStretch], language: Language, label: str) -> Markup:
    """Return the drawing. `way`: at least one stretch."""
    scale = _Scale(way)
    parts = [svg("title", label), *_grid(scale, language)]
    for line in way_lines(way, SPEEDS, _NEAR * scale.metres):
        name = "unknown" if line.level is None else f"speed{line.level}"
        places = [(scale.x(east), scale.y(north)) for east, north in line.points]
        parts.append(svg("path", cls=f"way {name}", d=_path(places)))
    first, last = way[0], way[-1]
    parts.append(_mark(scale, float(first.east[0]), float(first.north[0]), "begin"))
    parts.append(_mark(scale, float(last.east[-1]), float(last.north[-1]), "end"))
    drawn = Markup("").join(parts)
    return Markup(
        '<svg class="track" viewBox="0 0 {} {:.0f}" role="img" aria-label="{}">{}</svg>'
    ).format(WIDTH, scale.height, label, drawn)


class _Scale:
    """Converts metres to places of the drawing."""

    def __init__(self, way: Sequence[WayStretch]) -> None:
        west, east = _ends([(float(it.east.min()), float(it.east.max())) for it in way])
        south, north = _ends([(float(it.north.min()), float(it.north.max())) for it in way])
        width = WIDTH - 2 * _EDGE
        height = min(MOST_HEIGHT, max(LEAST_HEIGHT, width * (north - south) / (east - west)))
        self.metres: float = max((east - west) / width, (north - south) / height)
        """Of a unit of the drawing."""
        self.height: float = height + _EDGE + _FOOT
        """That of the drawing."""
        self._left = (west + east) / 2 - self.metres * WIDTH / 2
        self._top = (south + north) / 2 + self.metres * (_EDGE + height / 2)

    def x(self, east: float) -> float:
        return (east - self._left) / self.metres

    def y(self, north: float) -> float:
        return (self._top - north) / self.metres

    @property
    def step(self) -> float:
        """The distance of two lines of the grid, a round number of metres."""
        most = self.metres * WIDTH / _CELLS
        power = 10.0 ** floor(log10(most))
        return power * next(each for each in (5, 2, 1) if each == 1 or each * power <= most)


def _ends(ends: Sequence[tuple[float, float]]) -> tuple[float, float]:
    low, high = min(each[0] for each in ends), max(each[1] for each in ends)
    lacking = max(0.0, _LEAST - (high - low)) / 2
    return low - lacking, high + lacking


def _grid(scale: _Scale, language: Language) -> Iterator[Markup]:
    step = scale.step / scale.metres
    count = 1
    while count * step < WIDTH:
        yield svg("line", cls="grid", x1=count * step, x2=count * step, y1=0, y2=scale.height)
        count += 1
    count = 1
    while count * step < scale.height:
        yield svg("line", cls="grid", x1=0, x2=WIDTH, y1=count * step, y2=count * step)
        count += 1
    y = scale.height - 8.0
    yield svg("line", cls="scale", x1=step, x2=2 * step, y1=y, y2=y)
    yield svg("text", _metres(scale.step).to(language), cls="scale", x=1.5 * step, y=y - 5)
    yield svg("text", Text("N ↑", "С ↑").to(language), cls="north", x=WIDTH - 8.0, y=18)


def _metres(metres: float) -> Text:
    if metres < 1000:
        return Text(f"{metres:.0f} m", f"{metres:.0f} м")
    kilometres = metres / 1000
    return Text(f"{number(kilometres, 0, 'en')} km", f"{number(kilometres, 0, 'ru')} км")


def _path(points: Sequence[tuple[float, float]]) -> str:
    return "M" + "L".join(f"{x:.1f} {y:.1f}" for x, y in points)


def _mark(scale: _Scale, east: float, north: float, cls: str) -> Markup:
    return svg("circle", cls=cls, cx=scale.x(east), cy=scale.y(north), r=5)
