"""An overview as HTML, which a notebook puts between its own: all styles are in it, and no script.

Nothing has a ground of its own, and lines and texts have the notebook's colour, so that it is
legible in light and in dark ones. Every text is escaped: a stranger's file may hold anything.
"""

from __future__ import annotations

from collections.abc import Iterable
from itertools import groupby
from math import isfinite
from typing import Final

from markupsafe import Markup, escape

from mikas.cleaning import clean_line
from mikas.i18n import Language
from mikas.notebook.overview import Curve
from mikas.notebook.wording import COURSE, ChannelLine, List, Wording

_NUMBERS: Final = 3  # the first column of numbers
_WIDTH, _HEIGHT = 120, 18

_STYLE: Final = Markup("""<style>
.mikas-recording { color: inherit; line-height: 1.4; max-width: 72em; }
.mikas-recording .title { font-size: 1.15em; font-weight: 600; margin: 0 0 0.3em; }
.mikas-recording .list { margin: 0.4em 0 0; }
.mikas-recording ul { margin: 0; padding-left: 1.4em; }
.mikas-recording.mikas-recording table { border-collapse: collapse; margin: 0.4em 0 0; font-size: inherit; }
.mikas-recording.mikas-recording table th, .mikas-recording.mikas-recording table td { text-align: left; padding: 0.1em 0.9em 0.1em 0; vertical-align: top; border: 0; background: none; white-space: normal; max-width: 34em; overflow-wrap: anywhere; }
.mikas-recording.mikas-recording table tr { background: none; }
.mikas-recording.mikas-recording table.facts th { font-weight: normal; opacity: 0.75; white-space: nowrap; }
.mikas-recording.mikas-recording table.channels th { border-bottom: 1px solid; }
.mikas-recording.mikas-recording table.channels .number { text-align: right; white-space: nowrap; font-variant-numeric: tabular-nums; }
.mikas-recording svg { display: block; width: 120px; height: 18px; }
.mikas-recording svg path { fill: none; stroke: currentColor; stroke-width: 1.2; }
</style>""")  # noqa: E501  (a rule a line)


def html_of(wording: Wording) -> str:
    """Return the overview as a piece of HTML that is also well-formed XML."""
    parts = [
        _STYLE,
        _element("p", wording.title, "title"),
        _table("facts", (_facts(*fact) for fact in wording.facts)),
        *(_list(each) for each in wording.lists),
        _channels(wording),
    ]
    return _whole(parts, wording.language)


def html_of_error(title: str, words: str, language: Language) -> str:
    """Return why there is nothing to show."""
    return _whole([_STYLE, _element("p", title, "title"), _element("p", words)], language)


def _whole(parts: Iterable[Markup], language: Language) -> str:
    shown = Markup('<div class="mikas-recording" lang="{}">{}</div>')
    return str(shown.format(language, Markup("\n").join(parts)))


def _element(tag: str, text: str, cls: str = "") -> Markup:
    attribute = Markup(' class="{}"').format(cls) if cls else Markup("")
    return Markup("<{0}{1}>{2}</{0}>").format(Markup(tag), attribute, escape(clean_line(text)))


def _table(cls: str, rows: Iterable[Markup]) -> Markup:
    return Markup('<table class="{}">{}</table>').format(cls, Markup("\n").join(rows))


def _facts(title: str, text: str) -> Markup:
    return Markup("<tr>{}{}</tr>").format(_element("th", title), _element("td", text))


def _list(each: List) -> Markup:
    lines = [*each.lines, *([each.more] if each.more else [])]
    items = Markup("").join(_element("li", line) for line in lines)
    return _element("p", each.title, "list") + Markup("<ul>{}</ul>").format(items)


def _channels(wording: Wording) -> Markup:
    if not wording.rows:
        return Markup("")
    headings = [*wording.headings, COURSE.to(wording.language)]
    head = Markup("").join(
        _element("th", text, "number" if _NUMBERS <= at < len(wording.headings) else "")
        for at, text in enumerate(headings)
    )
    times = [time for row in wording.rows for time, _ in row.curve]
    span = (min(times), max(times)) if times else (0.0, 1.0)
    rows = (_row(row, span) for row in wording.rows)
    return _table("channels", [Markup("<tr>{}</tr>").format(head), *rows])


def _row(row: ChannelLine, span: tuple[float, float]) -> Markup:
    cells = Markup("").join(
        _element("td", text, "number" if at >= _NUMBERS else "")
        for at, text in enumerate(row.cells)
    )
    return Markup("<tr>{}<td>{}</td></tr>").format(cells, _curve(row.curve, span))


def _curve(curve: Curve, span: tuple[float, float]) -> Markup:
    """Draw a channel's course from its least to its most, along the time of all channels."""
    values = [value for _, value in curve if isfinite(value)]
    if not values:
        return Markup("")
    low, high = min(values), max(values)
    extent = (high - low) or 1.0
    across = (_WIDTH - 2) / ((span[1] - span[0]) or 1.0)
    pieces = []
    for is_there, piece in groupby(curve, key=lambda point: isfinite(point[1])):
        if is_there:
            points = [
                f"{1 + (time - span[0]) * across:.1f} "
                f"{_HEIGHT - 2 - (value - low) / extent * (_HEIGHT - 4):.1f}"
                for time, value in piece
            ]
            pieces.append(f"M{points[0]}" + ("L" + " ".join(points[1:]) if points[1:] else "h1"))
    drawing = Markup('<svg viewBox="0 0 {} {}" role="presentation"><path d="{}"/></svg>')
    return drawing.format(_WIDTH, _HEIGHT, "".join(pieces))
