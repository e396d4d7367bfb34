"""The section on guided tests: for each its verdict, numbers, rule, doubt, and a drawing."""

from __future__ import annotations

from typing import Final

from markupsafe import Markup

from mikas.guided.definition import VerdictKind
from mikas.guided.result import CHECK, MISSING, OUTCOMES, Curve, Finding, TestResult
from mikas.i18n import Language, Text
from mikas.recording.formatting import moment, number
from mikas.report.charts import axis_ends
from mikas.report.findings import Findings
from mikas.report.measurements.alarms import Channel
from mikas.report.sections.section import PageSection, items, paragraph, table

_TITLE: Final = Text("Guided tests", "Проверки по шагам")
_HEAD: Final = (
    Text("Measured", "Измерено"),
    Text("Value", "Значение"),
    Text("Readings", "Замеров"),
)
_WIDTH, _HEIGHT, _CURVES = 320, 120, 3


def section(found: Findings, language: Language) -> PageSection | None:
    """Return the section of the tests that belong to this report; None without one."""
    results = found.subject.tests
    if not results:
        return None
    bodies = (_test(result, found, language) for result in results)
    return PageSection(_TITLE.to(language), Markup("").join(bodies))


def _test(result: TestResult, found: Findings, language: Language) -> Markup:
    when = moment(result.ended, found.measured.began).to(language)
    parts = [
        Markup("<h3>{}: {} <span class='quiet small'>{}</span></h3>").format(
            result.title.to(language), OUTCOMES[result.outcome].to(language), when
        )
    ]
    if result.outcome is VerdictKind.UNKNOWN:
        parts.append(paragraph(result.verdict.to(language)))
    parts += [_finding(finding, language) for finding in result.findings]
    if result.missing:
        parts.append(paragraph(MISSING.to(language)))
        parts.append(items(text.to(language) for text in result.missing))
    rows = (
        (
            it.text.to(language),
            it.shown.to(language) if it.value is not None else it.why.to(language),
            str(it.count or "—"),
        )
        for it in result.numbers
    )
    parts.append(table((text.to(language) for text in _HEAD), rows))
    channels = found.subject.catalog.channels
    # A constant value is among the numbers.
    moving = [it for it in result.curves if it.times and max(it.highs) > min(it.lows)]
    drawings = (_drawing(it, channels.get(it.name), language) for it in moving[:_CURVES])
    parts.append(Markup("<div class='charts'>{}</div>").format(Markup("").join(drawings)))
    return Markup("").join(parts)


def _finding(finding: Finding, language: Language) -> Markup:
    parts = [Markup("<p><strong>{}</strong></p>").format(finding.text.to(language))]
    if finding.check.en:
        parts.append(paragraph(f"{CHECK.to(language)} {finding.check.to(language)}"))
    grounds = finding.grounds.to(language)
    parts.append(Markup("<p class='small quiet'>{}</p>").format(grounds))
    return Markup("").join(parts)


def _drawing(curve: Curve, channel: Channel | None, language: Language) -> Markup:
    """Return the curve as a line with its lowest and highest value written beside it.

    `channel`: None if the catalog in use does not have it.
    """
    low, high = min(curve.lows), max(curve.highs)
    foot, top_end = axis_ends(low, high, channel) if channel else (low, high)
    began, ended = curve.times[0], max(curve.times[-1], curve.times[0] + 1e-3)
    span = max(top_end - foot, 1e-9)

    def point(time: float, value: float) -> str:
        across = (time - began) / (ended - began) * _WIDTH
        return f"{across:.1f},{_HEIGHT - 4 - (value - foot) / span * (_HEIGHT - 8):.1f}"

    points = " ".join(
        f"{point(time, bottom)} {point(time, top)}"
        for time, bottom, top in zip(curve.times, curve.lows, curve.highs, strict=True)
    )
    title = curve.text.to(language)
    ends = " … ".join(number(value, 1, language) for value in (low, high))
    unit = curve.unit.to(language)
    return Markup(
        "<figure><figcaption>{}: {} {}</figcaption>"
        "<svg class='chart' viewBox='0 0 {} {}' role='img' aria-label='{}'>"
        "<polyline class='course' points='{}'/></svg></figure>"
    ).format(title, ends, unit, _WIDTH, _HEIGHT, title, points)
