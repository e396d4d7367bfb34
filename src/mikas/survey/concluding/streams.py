"""Conclusions on streams: their end, their pauses, strokes (D12, D15, D16)."""

from __future__ import annotations

from typing import Any

from mikas.survey.concluding.commands import support
from mikas.survey.concluding.conclusion import (
    Conclusion,
    found,
    is_open,
    milliseconds,
    ru,
    unmeasured,
)
from mikas.survey.concluding.line import inter_byte
from mikas.survey.steps.step import CarState, Measured

_SPAN = 500.0  # rpm between the slowest and the fastest, at least
_ENDS = {
    "byte": ("any byte ends it", "заканчивает любой байт"),
    "request": (
        "a whole request ends it, one byte does not",
        "заканчивает целый запрос, но не байт",
    ),
    "break": ("only a line break ends it", "заканчивает только обрыв линии (break)"),
}


def stream_end(measured: Measured) -> Conclusion:
    """Conclude on D12."""
    if "stream_end" not in measured:
        return _no_stream(measured)
    end = measured["stream_end"]
    if end is None:
        return is_open(
            "neither a byte nor requests nor a line break ended it at once, or it never began",
            "ни байт, ни запросы, ни обрыв линии сразу его не закончили, или он не начался",
        )
    return found(end, *_ENDS[end])


def _no_stream(measured: Measured) -> Conclusion:
    if support(measured).get("71") is False:
        return is_open("the unit lacks 71", "команды 71 у блока нет")
    return unmeasured(measured, CarState.STANDING)


def stream_gap(measured: Measured) -> Conclusion:
    """Conclude on the pause between two responses, the engine standing (§5, D16)."""
    run = measured.get("streams", {}).get(CarState.STANDING.value)
    if run is None:
        return _no_stream(measured)
    gap = _pause_after(measured, run)
    en, russian = milliseconds(gap)
    if "inter_byte" in measured and (within := inter_byte(measured)).value is None:
        return is_open(
            f"{en} at most between responses; pauses inside a response are not known: "
            f"{within.text.en}",
            f"не больше {russian} между ответами; паузы внутри ответа неизвестны: {within.text.ru}",
        )
    number = run["responses"]
    return found(
        gap,
        f"{en} between responses ({number} of them timed)",
        f"{russian} между ответами (измерено ответов: {number})",
    )


def _pause_after(measured: Measured, run: dict[str, Any]) -> float:
    """Return the pause between two responses, without those between the bytes of one."""
    between = inter_byte(measured).value or 0.0
    pause: float = run["gap"] - between * (run["bytes"] - 1)
    return round(max(0.0, pause), 6)


def stream_load(measured: Measured) -> Conclusion:
    """Conclude on D16: how many ms more between responses for each 1,000 rpm."""
    runs: dict[str, dict[str, Any]] = measured.get("streams", {})
    points = [
        (run["rpm"], _pause_after(measured, run)) for run in runs.values() if run["rpm"] is not None
    ]
    if not runs and support(measured).get("71") is False:
        return _no_stream(measured)
    if len(points) < 2 or max(points)[0] - min(points)[0] < _SPAN:
        return unmeasured(measured, CarState.IDLE)
    slope = slope_of(points) * 1e6  # ms per 1,000 rpm
    fewest = min(run["responses"] for run in runs.values())
    span = max(points)[0] - min(points)[0]
    doubt = (2 * measured["granularity"] / fewest + 2e-5) / span * 1e6
    at = ", ".join(f"{rpm:.0f}" for rpm, _ in sorted(points))
    texts = (
        f"{slope:.3f} ± {doubt:.3f} ms for each 1,000 rpm (at {at} rpm)",
        f"{ru(f'{slope:.3f} ± {doubt:.3f}')} мс на каждые 1000 об/мин (при {at} об/мин)",
    )
    value = {"load": round(max(0.0, slope), 4), "doubt": round(doubt, 4)}
    if doubt > max(0.05, abs(slope) / 2):
        return is_open(f"not known closer than {texts[0]}", f"точнее не узнать: {texts[1]}", value)
    return found(value, *texts)


def slope_of(points: list[tuple[float, float]]) -> float:
    """Return the slope of the straight line nearest to the points."""
    mean_x = sum(x for x, _ in points) / len(points)
    mean_y = sum(y for _, y in points) / len(points)
    spread = sum((x - mean_x) ** 2 for x, _ in points)
    return sum((x - mean_x) * (y - mean_y) for x, y in points) / spread


def per_turn(run: dict[str, Any]) -> float | None:
    """Return the responses of a stream by strokes in one turn of the engine."""
    if run["rate"] is None or not run["rpm"]:
        return None
    rate: float = run["rate"] / (run["rpm"] / 60)
    return round(rate, 3)


def strokes(measured: Measured) -> Conclusion:
    """Conclude on D15."""
    runs = measured.get("strokes")
    if not runs:
        return unmeasured(measured, CarState.IDLE)
    rates = {code: per_turn(run) for code, run in runs.items()}
    known = {code: rate for code, rate in rates.items() if rate is not None}
    if not known:
        return is_open(
            "no response to any stream by strokes, or no engine speed beside it",
            "ни на один поток по тактам нет ответа, либо нет оборотов рядом с ним",
            rates,
        )
    listed = ", ".join(f"{code}: {rate:.2f}" for code, rate in known.items())
    silent = " ".join(code for code, rate in rates.items() if rate is None)
    en, russian = f"responses in a turn: {listed}", f"ответов за оборот: {ru(listed)}"
    raised = measured.get("strokes_raised", {}).get("7F")
    if raised is not None and (rate := per_turn(raised)) is not None:
        en += f"; 7F at {raised['rpm']:.0f} rpm: {rate:.2f}"
        russian += f"; 7F при {raised['rpm']:.0f} об/мин: {ru(f'{rate:.2f}')}"
    if silent:
        en, russian = f"{en}; silent: {silent}", f"{russian}; молчат: {silent}"
    return found(rates, en, russian)
