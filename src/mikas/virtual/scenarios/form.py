"""The form of the values in a scenario file (docs/reference/scenarios.md).

Each function reads one value of the file, or returns the reader of such values; it raises a
`UsageError` with the expected form.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from decimal import Decimal
from itertools import pairwise
from typing import Any, TypeGuard

from mikas.catalog.loading.fields import Reader, span
from mikas.errors import UsageError, usage_error
from mikas.i18n import Text
from mikas.virtual.scenarios.timeline import Track

PASSPORTS = 8  # three of the program, five of the data; 16 bytes each (§3)


def number(low: float, high: float, *, whole: bool = False) -> Callable[[object], float]:
    """Return a reader of numbers from `low` to `high`."""
    kind = Text("whole number", "целое число") if whole else Text("number", "число")

    def read(value: object) -> float:
        if _is_number(value) and low <= value <= high and not (whole and value % 1):
            return float(value)
        raise usage_error(
            f"must be a {kind.en} from {low:g} to {high:g}",
            f"нужно {kind.ru} от {low:g} до {high:g}",
        )

    return read


def openings(value: object) -> tuple[float, float]:
    """Return two openings of the throttle in %, the smaller first."""
    low, high = span(value)
    if not 0 <= low <= high <= 100:
        raise usage_error(
            "must be two openings from 0 to 100 %, [from, to]",
            "нужны два открытия от 0 до 100 %: [от, до]",
        )
    return low, high


def track(high: float, *, smooth: bool = True) -> Reader:
    """Return a reader of one number up to `high`, or of points `[second, value]`, in order."""
    in_range = number(0, high, whole=not smooth)

    def read(value: object) -> Track:
        points: Any = [[0, value]] if _is_number(value) else value
        if not isinstance(points, list) or not points or not all(map(_is_point, points)):
            raise usage_error(
                "must be a number or points [second, value], as [[0, 1], [30, 0]]",
                "нужно число или точки [секунда, значение], например [[0, 1], [30, 0]]",
            )
        times = tuple(float(time) for time, _ in points)
        if times[0] != 0 or any(a >= b for a, b in pairwise(times)):
            raise usage_error(
                "must have its first point at second 0 and each one later than the one before",
                "первая точка должна быть на секунде 0, каждая следующая позже предыдущей",
            )
        return Track(times, tuple(in_range(v) for _, v in points), smooth)

    return read


def numbers(value: object) -> frozenset[int]:
    """Return fault numbers."""
    fault = number(0, 255, whole=True)
    if isinstance(value, list):
        with suppress(UsageError):
            return frozenset(int(fault(n)) for n in value)
    raise usage_error(
        "must be a list of fault numbers from 0 to 255, as [13, 53]",
        "нужен список номеров ошибок от 0 до 255, например [13, 53]",
    )


def passports(value: object) -> tuple[str, ...]:
    """Return eight texts; missing ones are empty."""
    if isinstance(value, list) and len(value) <= PASSPORTS and all(map(_is_passport, value)):
        return (*value, *[""] * (PASSPORTS - len(value)))
    raise usage_error(
        "must be at most 8 texts (3 of the program, 5 of the data), each at most 16 characters of "
        "code page 866",
        "нужно не больше 8 строк (3 программы, 5 данных), в каждой до 16 знаков кодировки 866",
    )


def hex_bytes(value: object) -> bytes:
    """Return bytes, as "7D" or "12 34"."""
    try:
        data = bytes.fromhex(value) if isinstance(value, str) else b""
    except ValueError:
        data = b""
    if data:
        return data
    raise usage_error('must be bytes in hex, as "7D"', 'нужны байты в шестнадцатеричном виде: "7D"')


def pinned(value: object) -> float | bool:
    """Return a physical value or a flag."""
    if isinstance(value, bool):
        return value
    if _is_number(value):
        return float(value)
    raise usage_error("must be a number, true or false", "нужно число, true или false")


def _is_number(value: object) -> TypeGuard[int | Decimal]:
    if isinstance(value, Decimal):
        return value.is_finite()
    return isinstance(value, int) and not isinstance(value, bool)


def _is_passport(value: object) -> bool:
    try:
        return isinstance(value, str) and len(value.encode("cp866")) <= 16
    except UnicodeEncodeError:
        return False


def _is_point(value: object) -> bool:
    return isinstance(value, list) and len(value) == 2 and all(_is_number(n) for n in value)
