"""The report as one self-contained HTML page with its style and drawings.

It prints on two sides of A4, or three with causes. It has no script, and its
Content-Security-Policy allows only its own style: a recording may contain any text.
"""

from __future__ import annotations

import errno
from base64 import b64encode
from collections.abc import Callable, Iterator
from functools import cache
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from markupsafe import Markup

from mikas.cancellation import check_cancelled
from mikas.catalog import Fault, Parameter
from mikas.catalog.undecided import READING_NAMES, otherwise, values_otherwise
from mikas.errors import ExportError, system_error
from mikas.files import absolute
from mikas.i18n import Language, Text
from mikas.recording.export.exporting import check_free, write_whole
from mikas.recording.export.sheet import program
from mikas.recording.formatting import CONFIDENCE, band, date_of, moment, number, percent, with_unit
from mikas.report.charts import chart
from mikas.report.findings import (
    BandPosition,
    ChannelFinding,
    Findings,
    Unrated,
    is_open,
)
from mikas.report.labels import Labels
from mikas.report.measurements.alarms import Channel
from mikas.report.sections.alarm_texts import alarm_section
from mikas.report.sections.causes import cause_section
from mikas.report.sections.conditions import rows as how_rows
from mikas.report.sections.drive import drive_section
from mikas.report.sections.freeze_frames import frame_section
from mikas.report.sections.guided_tests import section as guided_section
from mikas.report.sections.limitations import unknowns
from mikas.report.sections.mixture import mixture_section
from mikas.report.sections.section import PageSection
from mikas.report.sections.summary import MARKS, headline, summary_sentence
from mikas.report.subject import ClearedFaults

if TYPE_CHECKING:
    from jinja2 import Environment, Template

CHARTS: Final = 3
SUFFIXES: Final = (".html", ".htm")
_FIRST: Final = ("FREQ", "JAIR", "TWAT", "INJ", "UACC", "UOZ", "FREQX", "THR")
"""The charts if all values are normal."""
SECTIONS: Final[tuple[Callable[[Findings, Language], PageSection | None], ...]] = (
    frame_section,
    alarm_section,
    cause_section,
    guided_section,
    drive_section,
    mixture_section,
)
"""The sections with modules of their own, between the faults and the values, in order."""


def policy() -> str:
    """Return the Content-Security-Policy that the page needs and contains."""
    digest = b64encode(sha256(page_style().encode()).digest()).decode()
    return f"default-src 'none'; style-src 'sha256-{digest}'; base-uri 'none'; form-action 'none'"


def render(found: Findings, language: Language) -> str:
    """Return the page in one language."""
    return _template().render(_Page(found, language).context())


class _Page:
    """The values of the template, as texts in one language."""

    def __init__(self, found: Findings, language: Language) -> None:
        self._found = found
        self._language = language
        self._label = Labels(language)

    def context(self) -> dict[str, Any]:
        found, language, label = self._found, self._language, self._label
        date = found.subject.conditions.date
        model = found.subject.unit.model.text.to(language) if found.subject.unit else ""
        file = found.subject.conditions.file
        is_virtual = found.subject.conditions.port.startswith("sim:")
        about = label("live_virtual" if is_virtual else "live")
        if file:
            virtual = f" ({label('virtual')})" if is_virtual else ""
            about = f"{label('of_recording')} {file}{virtual}"
        return {
            "language": language,
            "label": label,
            "title": " · ".join(filter(None, (label("title"), model, file))),
            "date": date.strftime(label("date")) if date else label("no_date"),
            "about": " · ".join((*found.subject.notes[:3], about)),
            "found": found,
            "headline": headline(found).to(language),
            "verdict": summary_sentence(found).to(language),
            "car": list(self._car()),
            "unit": list(self._unit()),
            "faults": [self._fault(each) for each in found.subject.faults or ()],
            "faults_read": self._faults_read(),
            "gone": [self._gone(each) for each in found.subject.cleared],
            "sections": [it for make in SECTIONS if (it := make(found, language)) is not None],
            "drive_again": any(is_open(found.subject, each) for each in found.cleared),
            "values": [self._judged(value) for value in found.values if _has_row(value)],
            "others": [self._other(value) for value in found.values if not _has_row(value)],
            "others_title": label("others_idle" if found.measured.idle.enough else "others_whole"),
            "charts": list(self._charts()),
            "legend": list(self._legend()),
            "how": list(how_rows(found, language)),
            "unknowns": [text.to(language) for text in unknowns(found)],
        }

    def _car(self) -> Iterator[tuple[str, str]]:
        car, label = self._found.subject.car, self._label
        if car.car:
            yield label("car"), car.car
        if car.plate:
            yield label("plate"), car.plate
        if car.mileage is not None:
            count = f"{car.mileage:,}".replace(",", "\N{NO-BREAK SPACE}")
            yield label("mileage"), label("km", count=count)
        if car.workshop:
            yield label("workshop"), car.workshop

    def _unit(self) -> Iterator[tuple[str, str]]:
        unit, label = self._found.subject.unit, self._label
        if unit is None:
            yield label("model"), label("not_asked")
            return
        yield label("model"), unit.model.text.to(self._language)
        asked = bool(unit.program or unit.data)
        for name, pieces in (("program", unit.program), ("data", unit.data)):
            passport = " · ".join(piece.strip() for piece in pieces if piece and piece.strip())
            yield label(name), passport or label("not_reported" if asked else "not_asked")

    def _faults_read(self) -> str:
        found = self._found
        time = found.subject.faults_read
        if time is None or date_of(time) is None:  # a simulated clock has no date
            return ""
        return self._label("faults_read", when=self._moment(time))

    def _gone(self, gone: ClearedFaults) -> dict[str, Any]:
        title = self._label("erased" if gone.erased else "gone", when=self._moment(gone.time))
        texts = [
            f"{it.code}: {it.text.to(self._language) if it.known else self._label('no_text')}"
            for it in gone.faults
        ]
        return {"title": title, "faults": texts}

    def _moment(self, time: float) -> str:
        return moment(time, self._found.measured.began).to(self._language)

    def _fault(self, fault: Fault) -> dict[str, str | int]:
        language = self._language
        values = ", ".join(map(self._measured, self._found.values_of(fault)))
        message = self._label("message") if fault.informational else ""
        sure = CONFIDENCE[fault.confidence].to(language)
        return {
            "code": fault.code,
            "text": fault.text.to(language) if fault.known else self._label("no_text"),
            "check": fault.check.to(language),
            "sure": "; ".join(filter(None, (message, sure if fault.known else ""))),
            "related": f"{self._label('measured')}: {values}" if values else "",
        }

    def _measured(self, value: ChannelFinding) -> str:
        """Return name and value of a channel in a fault's line."""
        text = f"{value.channel.text.to(self._language)} {self._number(value)}"
        return f"{text} ({self._label('substitute')})" if value.sensor else text

    def _judged(self, value: ChannelFinding) -> dict[str, str | bool]:
        channel, stats, language = value.channel, value.stats, self._language
        ends = [number(end, channel.decimals, language) for end in (stats.low, stats.high)]
        share = (
            "" if value.unrated else self._label("within_band", share=percent(stats.inside or 0.0))
        )
        codes = ", ".join(map(str, value.related))
        related = self._label("related", codes=codes) if codes else ""
        why = [self._unrated(value), value.meaning.to(language), related, self._otherwise(value)]
        return {
            "off": value.mark in (BandPosition.LOW, BandPosition.HIGH),
            "text": channel.text.to(language),
            "name": channel.name,
            "median": with_unit(stats.median, channel, language),
            "spread": ends[0] if ends[0] == ends[1] else " … ".join(ends),
            "band": band(channel, language),
            "kind": value.mark.value,
            "mark": MARKS[value.mark].to(language),
            "share": share,
            "why": " ".join(filter(None, why)),
        }

    def _unrated(self, value: ChannelFinding) -> str:
        if value.unrated is Unrated.SENSOR:
            return self._label("sensor_fault", codes=", ".join(map(str, value.sensor)))
        if value.unrated is Unrated.TOO_FEW:
            return self._label("too_few", count=value.stats.count)
        return ""

    def _other(self, value: ChannelFinding) -> dict[str, str]:
        channel, stats, language = value.channel, value.stats, self._language
        text = self._number(value)
        if not channel.is_flag and stats.low != stats.high:
            low, high = (number(e, channel.decimals, language) for e in (stats.low, stats.high))
            text += f" ({low} … {high})"
        notes = [self._label("substitute") if value.sensor else "", self._otherwise(value)]
        return {
            "text": channel.text.to(language),
            "name": channel.name,
            "number": text,
            "note": "; ".join(filter(None, notes)),
        }

    def _otherwise(self, value: ChannelFinding) -> str:
        """Return the median by the other readings that only a car decides on (E3)."""
        channel, language = value.channel, self._language
        if not isinstance(channel, Parameter) or not otherwise(channel):
            return ""
        others = values_otherwise(channel, channel.encode(value.stats.median))
        return ", ".join(
            f"{READING_NAMES[name].to(language)} {number(each, channel.decimals, language)}"
            for name, each in others.items()
        )

    def _number(self, value: ChannelFinding) -> str:
        if value.channel.is_flag:
            return self._label("set_share", share=percent(value.stats.mean))
        return with_unit(value.stats.median, value.channel, self._language)

    def _charts(self) -> Iterator[dict[str, str]]:
        measured, language = self._found.measured, self._language
        began = measured.began or 0.0
        for channel in _chart_channels(self._found):
            check_cancelled()
            title = f"{channel.text.to(language)}, {channel.unit_text.to(language)}"
            yield {
                "title": title.rstrip(", "),
                "drawing": chart(
                    channel,
                    measured.curves[channel.name],
                    measured.seconds,
                    language,
                    idle=[(a - began, b - began) for a, b in measured.idle.spans],
                    pauses=[
                        (pause.began - began, (pause.ended or measured.ended or began) - began)
                        for pause in self._found.subject.conditions.interruptions or ()
                    ],
                    label=title.rstrip(", "),
                ),
            }

    def _legend(self) -> Iterator[str]:
        """Yield the explanations of those marks that the charts have."""
        measured = self._found.measured
        if any(each.reference for each in _chart_channels(self._found)):
            yield self._label("legend_band")
        if measured.idle.spans:
            yield self._label("legend_idle")
        if self._found.subject.conditions.interruptions:
            yield self._label("legend_gaps")


def _has_row(value: ChannelFinding) -> bool:
    """Whether the value stands in the table of ratings: it has one, or could have one at idle."""
    return value.unrated in (None, Unrated.SENSOR, Unrated.TOO_FEW)


def _chart_channels(found: Findings) -> list[Channel]:
    """Return the channels to draw: abnormal ones first, those with an alarm, `_FIRST`, then others;
    one speed.
    """
    channels = {each.name: each for each in found.measured.channels if not each.is_flag}
    order = [value.channel.name for value in found.abnormal]
    order += [alarm.limit.name for alarm in found.measured.alarms]
    order += [*_FIRST, *channels]
    chosen = [name for name in dict.fromkeys(order) if name in channels]
    speeds = [name for name in chosen if name in ("FREQ", "FREQX")]
    return [channels[name] for name in chosen if name not in speeds[1:]][:CHARTS]


@cache
def page_style() -> str:
    """Return the style of every report."""
    return (Path(__file__).parent / "page.css").read_text("utf-8")


@cache
def _template() -> Template:
    return templates().get_template("page.html")


def templates(*more: Path) -> Environment:
    """Return the templates here, and those of `more` folders."""
    from jinja2 import Environment, FileSystemLoader, StrictUndefined

    loader = FileSystemLoader([Path(__file__).parent, *more])
    made = Environment(loader=loader, autoescape=True, undefined=StrictUndefined)
    made.globals |= {"policy": policy(), "style": Markup(page_style()), "program": program()}
    return made


def check_output(out: Path, *, overwrite: bool) -> None:
    """Check the name before measuring. Raises `ExportError`."""
    if out.suffix.lower() not in SUFFIXES:
        raise ExportError(
            str(out),
            Text(
                "a report is an .html file (a browser prints it to paper or PDF)",
                "отчёт — это файл .html (напечатать его или сохранить в PDF можно из браузера)",
            ),
        )
    check_free(out, overwrite=overwrite)
    if not absolute(out).parent.is_dir():
        problem = Text("there is no such folder", "такой папки нет")
        raise ExportError(str(out), problem).caused_by(system_error(errno.ENOENT), out)


def write_page(out: Path, page: str, *, overwrite: bool) -> None:
    """Write `page` under a temporary name and rename it. Raises `ExportError`."""
    check_output(out, overwrite=overwrite)
    write_whole(out, lambda part: part.write_bytes(page.encode()), overwrite=overwrite)
