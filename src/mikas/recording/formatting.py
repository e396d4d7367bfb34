"""Numbers, durations and times as texts in the two languages."""

from __future__ import annotations

from datetime import datetime
from math import ceil, floor, isfinite

from mikas.catalog import Confidence, Derived, InstrumentChannel, Parameter
from mikas.i18n import Language, Text, unit_after
from mikas.recording.table.channels import calendar


def number(value: float, decimals: int, language: Language) -> str:
    """Return the number with the language's decimal sign and a real minus; `–` if not finite."""
    if not isfinite(value):
        return "–"
    digits = f"{value:.{decimals}f}"
    if float(digits) == 0:
        digits = digits.lstrip("-")
    digits = digits.replace("-", "−")
    return digits.replace(".", ",") if language == "ru" else digits


def with_unit(value: float, channel: Parameter | Derived, language: Language) -> str:
    """Return the number with the channel's decimals and unit."""
    return quantity(value, channel).to(language)


def digits(value: float, decimals: int) -> Text:
    """Return the number in both languages."""
    return Text(number(value, decimals, "en"), number(value, decimals, "ru"))


def quantity(value: float, channel: Parameter | Derived | InstrumentChannel) -> Text:
    """Return the number with the channel's decimals and unit, in both languages."""
    return joined_unit(digits(value, channel.decimals), channel.unit_text)


def joined_unit(shown: Text, unit: Text) -> Text:
    """Return a shown number with its unit, in both languages."""
    units = unit_after(shown, unit)
    return Text(
        *(f"{n}\N{NO-BREAK SPACE}{u}" if u else n for n, u in zip(shown, units, strict=True))
    )


def band(channel: Parameter | Derived, language: Language) -> str:
    """Return the catalog's reference, `13 … 16`; empty without one."""
    if channel.reference is None:
        return ""
    low, high = (short(end, language) for end in channel.reference)
    return low if low == high else f"{low} … {high}"


def short(value: float, language: Language) -> str:
    """Return the number with as many digits as it has, at most six."""
    digits = f"{value:g}".replace("-", "−")
    return digits.replace(".", ",") if language == "ru" else digits


def within(text: Text) -> Text:
    """Return the text without its capital, for use inside a sentence; short names (CO) keep it."""
    return Text(*(_uncapital(each) for each in text))


def _uncapital(text: str) -> str:
    return text if text[1:2].isupper() else text[:1].lower() + text[1:]


def percent(share: float) -> str:
    """Return a share in whole percents; 0 % and 100 % only if exact."""
    whole = min(99, max(1, round(100 * share))) if 0 < share < 1 else round(100 * share)
    return f"{whole}\N{NO-BREAK SPACE}%"


def clock(seconds: float) -> str:
    """Return a time since the start: `7:05`, or `1:07:05`."""
    hours, rest = divmod(round(max(0.0, seconds)), 3600)
    minutes, left = divmod(rest, 60)
    return f"{hours}:{minutes:02}:{left:02}" if hours else f"{minutes}:{left:02}"


def date_of(time: float | None) -> datetime | None:
    """Return the date of a time of the link's clock; None without one: a simulated clock."""
    date = None if time is None else calendar(time)
    return None if date is None else date.astimezone()


def moment(time: float, began: float | None) -> Text:
    """Return `at 12:05`; on another day than `began` `on 08.05 at 12:05`; for a simulated clock
    `at 0:45 of the measurement`.
    """
    date, first = date_of(time), date_of(began)
    if date is not None:
        if first is not None and first.date() != date.date():
            return Text(f"on {date:%d.%m at %H:%M}", f"{date:%d.%m в %H:%M}")
        return Text(f"at {date:%H:%M}", f"в {date:%H:%M}")
    since = clock(time - (began or 0.0))
    return Text(f"at {since} of the measurement", f"на {since} измерения")


def between(first: float, last: float, began: float | None) -> Text:
    """Return `between 12:03:10 and 12:03:12`, tenths if they are less than a second apart; of a
    simulated clock `between 0:45 and 0:47 of the measurement`. Never narrower than the two times.
    """
    parts = 10 if last - first < 1 else 1
    date, day = date_of(first), date_of(began)
    since = 0.0 if date is not None else began or 0.0
    ends = floor((first - since) * parts), ceil((last - since) * parts)
    en, ru = (
        [_of_day(end, parts, point, is_date=date is not None) for end in ends] for point in ".,"
    )
    if date is None:
        return Text(
            f"between {en[0]} and {en[1]} of the measurement",
            f"между {ru[0]} и {ru[1]} измерения",
        )
    if day is not None and day.date() != date.date():
        on = f"{date:%d.%m}"
        return Text(f"on {on} between {en[0]} and {en[1]}", f"{on} между {ru[0]} и {ru[1]}")
    return Text(f"between {en[0]} and {en[1]}", f"между {ru[0]} и {ru[1]}")


def _of_day(count: int, parts: int, point: str, *, is_date: bool) -> str:
    """Return `12:03:10.4`. `count`: of the parts of a second, 1 or 10."""
    seconds, rest = divmod(abs(count) if not is_date else count, parts)
    date = date_of(seconds) if is_date else None
    sign = "−" if count < 0 else ""
    digits = f"{date:%H:%M:%S}" if date is not None else sign + clock(seconds)
    return f"{digits}{point}{rest}" if parts > 1 else digits


def duration(seconds: float) -> Text:
    """Return `45 s`, `7 min 5 s`, `2 h 10 min`."""
    whole = round(max(0.0, seconds))
    if whole < 60:
        return Text(f"{whole} s", f"{whole} с")
    minutes, left = divmod(whole, 60)
    if minutes < 60:
        tail = (f" {left} s", f" {left} с") if left else ("", "")
        return Text(f"{minutes} min{tail[0]}", f"{minutes} мин{tail[1]}")
    hours, minutes = divmod(minutes, 60)
    tail = (f" {minutes} min", f" {minutes} мин") if minutes else ("", "")
    return Text(f"{hours} h{tail[0]}", f"{hours} ч{tail[1]}")


CONFIDENCE = {
    Confidence.CONFIRMED: Text(
        "the text is confirmed by two sources", "расшифровка подтверждена двумя источниками"
    ),
    Confidence.REPORTED: Text("the text is from one source", "расшифровка из одного источника"),
    Confidence.UNCONFIRMED: Text(
        "text unconfirmed: commonly printed, no source known",
        "расшифровка не подтверждена: распространена, но источник неизвестен",
    ),
    Confidence.UNKNOWN: Text("unknown fault number", "неизвестный номер ошибки"),
}
"""The confidence in a fault's text."""
