"""The freeze frames: of each fault that appeared the moment, and the values then.

13: Air flow sensor: signal low
The unit stored the fault between 12:03:10.2 and 12:03:10.4.
Air flow 3.1 kg/h …
"""

from __future__ import annotations

from typing import Final

from markupsafe import Markup

from mikas.i18n import Language, Text
from mikas.recording.formatting import between, number, with_unit
from mikas.recording.freeze_frames import AppearedFault, FreezeFrame, ValueThen, shown_first
from mikas.report.findings import Findings
from mikas.report.labels import Labels
from mikas.report.measurements.alarms import Channel
from mikas.report.sections.section import PageSection, paragraph, table

_SHARP: Final = 0.5  # s; a shorter time has no range of values
_UNKNOWN: Final = Text(
    "No freeze frame ({codes}): the moment is not known to a minute, or its values are not known.",
    "Стоп-кадра нет ({codes}): момент не известен с точностью до минуты, или неизвестны значения.",
)
_BEFORE: Final = Text(
    "No freeze frame ({codes}): stored before the first reading of the faults.",
    "Стоп-кадра нет ({codes}): в памяти ещё до первого чтения ошибок.",
)


def frame_section(found: Findings, language: Language) -> PageSection | None:
    """Return the section; None if no fault is stored and none appeared."""
    appeared = _latest(found)
    parts = [_frame(frame, found, language) for frame in latest_frames(found)]
    stored = [each.code for each in found.real_faults]
    unknown = [code for code in stored if code in appeared and appeared[code].frame is None]
    before = [code for code in stored if code not in appeared]
    for codes, text in ((unknown, _UNKNOWN), (before, _BEFORE)):
        if codes:
            filled = text.filled(codes=", ".join(map(str, codes)))
            parts.append(paragraph(filled.to(language)))
    if not parts:
        return None
    return PageSection(Labels(language)("frames"), Markup("").join(parts))


def latest_frames(found: Findings) -> list[FreezeFrame]:
    """Return the frame of each fault's latest appearance, if it has one; the latest first."""
    frames = (each.frame for each in _latest(found).values())
    return [frame for frame in frames if frame is not None]


def _latest(found: Findings) -> dict[int, AppearedFault]:
    """Return the latest appearance of each fault, without mere messages."""
    catalog = found.subject.catalog
    latest: dict[int, AppearedFault] = {}
    for each in found.subject.appeared:
        if not catalog.fault(each.code).informational:
            latest.setdefault(each.code, each)
    return latest


def _frame(frame: FreezeFrame, found: Findings, language: Language) -> Markup:
    """Return the moment and a table of the values then."""
    catalog, label = found.subject.catalog, Labels(language)
    fault = catalog.fault(frame.code)
    title = fault.text.to(language) if fault.known else label("no_text")
    when = between(frame.without, frame.seen, found.measured.began)
    parts = [
        Text(f"The unit stored the fault {when.en}.", f"Блок запомнил ошибку {when.ru}.").to(
            language
        )
    ]
    names = shown_first(fault, [name for name in frame.then if name in catalog.channels])
    channels = [catalog.channel(name) for name in names]
    is_sharp = frame.seen - frame.without < _SHARP
    ranges = [
        "" if is_sharp else _range(frame.then[each.name], each, language) for each in channels
    ]
    head = [label("value"), label("then")]
    if any(ranges):
        parts.append(label("then_range"))
        head.append(label("in_between"))
    rows = [
        (
            _name(each, frame.code, found, label),
            _value(frame.then[each.name].value, each, language),
            *([spread] if any(ranges) else ()),
        )
        for each, spread in zip(channels, ranges, strict=True)
    ]
    heading = Markup("<h3>{}: {}</h3>").format(frame.code, title)
    return heading + paragraph(" ".join(parts)) + table(head, rows)


def _name(channel: Channel, code: int, found: Findings, label: Labels) -> str:
    name = f"{channel.text.to(label.language)} {channel.name}"
    is_doubtful = code in found.sensor.get(channel.name, ())
    return f"{name} ({label('substitute')})" if is_doubtful else name


def _value(value: float, channel: Channel, language: Language) -> str:
    if not channel.is_flag:
        return with_unit(value, channel, language)
    if channel.lamp is not None:
        return (channel.lamp.on if value else channel.lamp.off).to(language)
    return number(value, 0, language)


def _range(then: ValueThen, channel: Channel, language: Language) -> str:
    if channel.is_flag or then.low == then.high:
        return ""
    low, high = (number(end, channel.decimals, language) for end in (then.low, then.high))
    return low if low == high else f"{low} … {high}"
