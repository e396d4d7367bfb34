"""The alarms in words: in the summary, and as a section of the page.

coolant temperature above 100 °C (highest 117 °C)               in the summary, the worst limit
Coolant temperature above 100 °C (warning): 2 times, 45 s in    in the section, each limit
all, first at 12:05; highest 117 °C at 12:06; still on at the end
"""

from __future__ import annotations

from math import isfinite

from mikas.i18n import Language, Text, counted, joined
from mikas.recording.formatting import duration, moment, quantity, short, within
from mikas.report.findings import Findings
from mikas.report.labels import Labels
from mikas.report.measurements.alarms import Alarm, worst
from mikas.report.sections.section import PageSection, items
from mikas.sampling.alarms import BEYOND, LEVEL_TEXTS, Side

NOTED = Text("{name} ({note})", "{name} ({note})")
_PEAK = {Side.LOW: Text("lowest", "наименьшее"), Side.HIGH: Text("highest", "наибольшее")}


def alarm_summary(found: Findings) -> Text:
    """Return the worst alarm of each channel, for the summary. There is an alarm."""
    alarms = worst(found.measured.alarms)
    listed = joined(", ", map(_briefly, alarms))
    if len(alarms) == 1:
        return Text(f"an alarm was on: {listed.en}", f"была тревога: {listed.ru}")
    return Text(f"alarms were on: {listed.en}", f"были тревоги: {listed.ru}")


def alarm_section(found: Findings, language: Language) -> PageSection | None:
    """Return the section; None without an alarm."""
    if not found.measured.alarms:
        return None
    texts = [_in_full(alarm, found).to(language) for alarm in found.measured.alarms]
    return PageSection(Labels(language)("alarms"), items(texts))


def _briefly(alarm: Alarm) -> Text:
    name, limit = within(_crossed(alarm)), _peak(alarm)
    return NOTED.filled(name=name, note=limit) if limit.en else name


def _crossed(alarm: Alarm) -> Text:
    """`Coolant temperature above 100 °C`; a flag by its name."""
    channel, limit = alarm.channel, alarm.limit
    if channel.is_flag:
        return channel.text
    where = BEYOND[limit.side]

    def said(language: Language) -> str:
        unit = channel.unit_text.to(language)
        return f"{short(limit.value, language)}\N{NO-BREAK SPACE}{unit}".rstrip()

    return Text(
        f"{channel.text.en} {where.en} {said('en')}", f"{channel.text.ru} {where.ru} {said('ru')}"
    )


def _peak(alarm: Alarm) -> Text:
    """`highest 117 °C`; empty for a flag, and if the value is not known."""
    if alarm.channel.is_flag or not isfinite(alarm.peak):
        return Text("", "")
    return joined(" ", (_PEAK[alarm.limit.side], quantity(alarm.peak, alarm.channel)))


def _in_full(alarm: Alarm, found: Findings) -> Text:
    crossed, level = _crossed(alarm), LEVEL_TEXTS[alarm.limit.level]
    parts = [_how_long(alarm, found)]
    peak, began = _peak(alarm), found.measured.began
    if peak.en:
        at = moment(alarm.peaked, began)
        parts.append(Text(f"{peak.en} {at.en}", f"{peak.ru} {at.ru}"))
    if alarm.sets > alarm.times:
        times = counted(alarm.sets, ("time", "times"), ("раз", "раза", "раз"))
        parts.append(Text(f"it was set {times.en}", f"флаг появлялся {times.ru}"))
    if alarm.still:
        parts.append(Text("still on at the end", "в конце ещё не прекратилась"))
    if alarm.by_event:
        parts.append(
            Text(
                "by the alarm's event; its values were not kept",
                "по событию тревоги; значения не сохранены",
            )
        )
    if codes := found.sensor.get(alarm.limit.name):
        listed = ", ".join(map(str, codes))
        parts.append(
            Text(
                f"perhaps a substitute value: fault {listed} of its sensor is stored",
                f"возможно, подставленное значение: в памяти ошибка датчика {listed}",
            )
        )
    rest = joined("; ", parts)
    return Text(f"{crossed.en} ({level.en}): {rest.en}.", f"{crossed.ru} ({level.ru}): {rest.ru}.")


def _how_long(alarm: Alarm, found: Findings) -> Text:
    when = moment(alarm.began, found.measured.began)
    lasted = Text("less than 1 s", "меньше 1 с") if alarm.seconds < 0.5 else duration(alarm.seconds)
    if alarm.times == 1:
        return Text(f"once, {lasted.en}, {when.en}", f"один раз, {lasted.ru}, {when.ru}")
    times = counted(alarm.times, ("time", "times"), ("раз", "раза", "раз"))
    return Text(
        f"{times.en}, {lasted.en} in all, first {when.en}",
        f"{times.ru}, всего {lasted.ru}, впервые {when.ru}",
    )
