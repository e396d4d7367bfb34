"""Streams: what ends one (D12), how their pauses follow the engine (D16), strokes (D15)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise
from statistics import fmean, median
from typing import Any

from mikas import commands as c
from mikas import errors
from mikas.framing import TERMINATOR, encode
from mikas.survey.person import Prompter
from mikas.survey.steps.step import Measured
from mikas.survey.unit import SurveyedUnit, speed_of
from mikas.tester.stream import Stream, StreamItem

_CYCLIC = 2.0  # s of a stream that is timed
_AT_STROKES = 4.0  # s; 28 cycles at 850 rpm
_AT_STROKES_RAISED = 2.0
_BYTES, _REQUESTS = 4, 6  # attempts: the wire is busy, so one byte may collide with a response
_BREAK = 0.05  # s
_ENDED = 1.0  # s without a byte, after which a stream has ended: a late response is no end
_USUAL = 0.8  # of the responses of a stream that is regular


def end_of_stream(unit: SurveyedUnit, measured: Measured, person: Prompter) -> None:
    """End a stream by one byte, else by a whole `01`, else by a line break; note which did it."""
    codes = _codes(unit, measured)
    if not codes or measured["commands"].get("71") is False:
        return
    with unit.tester.stream(c.StreamCyclic(_data(unit, codes))) as stream:
        period = _period(unit, stream)
        measured["stream_end"] = None if period is None else _end(unit, period, person)


def _data(unit: SurveyedUnit, codes: Sequence[int]) -> tuple[c.Datum, ...]:
    return tuple(c.Datum(code, unit.sizes[code]) for code in codes)


def _codes(unit: SurveyedUnit, measured: Measured) -> list[int]:
    """Return the codes of a short stream: the engine's speed if known, two data if they may be."""
    codes = unit.speed_codes
    others = [code for code in unit.one_byte_codes() if code not in codes]
    most = measured.get("lists", {}).get("71", {}).get("limit") or 2
    return (codes + others + codes)[: min(2, most)]


def _period(unit: SurveyedUnit, stream: Stream) -> float | None:
    """Return the seconds between two responses; None: fewer than three came."""
    times: list[float] = []
    while len(times) < 3:
        item = stream.read(unit.now() + 2 * unit.tester.line.timing.response_timeout)
        if item is None:
            return None
        times.append(item.time)
    return (times[-1] - times[0]) / 2


def _end(unit: SurveyedUnit, period: float, person: Prompter) -> str | None:
    link = unit.tester.link
    request = encode(c.Availability().body())
    attempts: list[tuple[str, Callable[[], None]]] = [
        *[("byte", lambda: link.write(bytes([TERMINATOR])))] * _BYTES,
        *[("request", lambda: link.write(request))] * _REQUESTS,
        ("break", lambda: link.send_break(_BREAK)),
    ]
    for done, (name, act) in enumerate(attempts):
        person.progress(done, len(attempts))
        _wait_for_gap(unit)
        act()
        if _is_quiet(unit, period):
            return name
    return None


def _wait_for_gap(unit: SurveyedUnit) -> None:
    """Wait for the end of a response, or for a short silence (D12)."""
    line = unit.tester.line
    deadline = unit.now() + line.timing.max_busy_time
    while unit.now() < deadline:
        chunk = line.read(unit.now() + line.timing.stream_gap)
        if not chunk.data or chunk.data[-1] == TERMINATOR:
            return


def _is_quiet(unit: SurveyedUnit, period: float) -> bool:
    line = unit.tester.line
    seconds = max(line.idle_time, 4 * period)
    try:
        line.wait_for_quiet(seconds, patience=2 * seconds)
    except errors.LineNotQuiet:
        return False
    return not line.read(unit.now() + _ENDED).data


def cyclic(unit: SurveyedUnit, measured: Measured, person: Prompter, state: str) -> None:
    """Time a cyclic stream: the pause between two responses, and the engine's speed meanwhile."""
    codes = _codes(unit, measured)
    if not codes or measured["commands"].get("71") is False:
        return
    items = _items(unit, c.StreamCyclic(_data(unit, codes)), _CYCLIC, person)
    if len(items) > 2:
        measured.setdefault("streams", {})[state] = {
            "gap": _gap(unit, items),
            "bytes": round(fmean(len(encode(item.body)) for item in items), 3),
            "responses": len(items),
            "rpm": _rpm(codes, items),
        }


def strokes(unit: SurveyedUnit, measured: Measured, person: Prompter) -> None:
    """Count the responses of each stream by strokes, the engine idling."""
    found = measured.setdefault("strokes", {})
    for done, code in enumerate(c.StreamAtStroke.CODES):
        person.progress(done, len(c.StreamAtStroke.CODES))
        _stroke(unit, measured, found, code, _AT_STROKES)


def strokes_raised(unit: SurveyedUnit, measured: Measured, _: Prompter) -> None:
    """Count those of 7F at the raised speed."""
    found = measured.setdefault("strokes_raised", {})
    _stroke(unit, measured, found, c.StreamAtStroke.CODES[0], _AT_STROKES_RAISED)


def _stroke(
    unit: SurveyedUnit, measured: Measured, found: dict[str, Any], code: int, seconds: float
) -> None:
    """Count the responses of one stream by strokes, unless that was done."""
    codes = _codes(unit, measured)
    if not codes or f"{code:02X}" in found:
        return
    stroke = c.StreamAtStroke.CODES.index(code)
    items = _items(unit, c.StreamAtStroke(_data(unit, codes), stroke), seconds)
    if not items and len(codes) > 1:  # a unit may take one code only
        codes = codes[:1]
        items = _items(unit, c.StreamAtStroke(_data(unit, codes), stroke), seconds)
    found[f"{code:02X}"] = {
        "rate": rate_of([item.time for item in items], unit.tester.link.granularity),
        "rpm": _rpm(codes, items),
    }


def _items(
    unit: SurveyedUnit,
    command: c.StreamCyclic | c.StreamAtStroke,
    seconds: float,
    person: Prompter | None = None,
) -> list[StreamItem]:
    """Return the responses of so many seconds, from the second one on; none: it is not known."""
    items: list[StreamItem] = []
    with unit.tester.stream(command) as stream:
        began = unit.now()
        while (now := unit.now()) < began + seconds:
            try:
                item = stream.read(began + seconds)
            except errors.NotSupported:
                return []
            except errors.ReadingSuspended:
                return []
            if item is not None:
                items.append(item)
            if person is not None:
                person.progress(round(10 * (now - began)), round(10 * seconds))
    return items[1:]


def _gap(unit: SurveyedUnit, items: Sequence[StreamItem]) -> float:
    """Return the mean pause between the responses, their own bytes left out.

    A mean, for a link that hands bytes over together shows no single pause.
    """
    byte_time = unit.tester.link.byte_time
    periods = _periods([item.time for item in items])
    gaps = [
        period - len(encode(item.body)) * byte_time
        for item, period in zip(items, periods, strict=False)
    ]
    return round(max(0.0, _mean(gaps, periods, unit.tester.link.granularity)), 7)


def rate_of(times: Sequence[float], granularity: float) -> float | None:
    """Return the responses in a second, by their times; None: too few, or all at once."""
    periods = _periods(times)
    mean = _mean(periods, periods, granularity) if len(periods) > 1 else 0.0
    return round(1 / mean, 4) if mean > 0 else None


def _periods(times: Sequence[float]) -> list[float]:
    return [following - time for time, following in pairwise(times)]


def _mean(times: Sequence[float], periods: Sequence[float], granularity: float) -> float:
    """Return the mean of `times` of a stream with these `periods`.

    Those beside a response that the line has lost or doubled are left out, as far as they are
    few: many are the unit's own.
    """
    usual, apart = median(times), median(periods) / 4 + granularity
    near = [time for time in times if abs(time - usual) <= apart]
    return fmean(near if len(near) >= _USUAL * len(times) else times)


def _rpm(codes: Sequence[int], items: Sequence[StreamItem]) -> float | None:
    speeds = [speed_of(dict(zip(codes, item.data, strict=True))) for item in items]
    known = [speed for speed in speeds if speed is not None]
    return round(fmean(known), 1) if known else None
