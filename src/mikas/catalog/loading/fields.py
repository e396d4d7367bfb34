"""The tables and keys of a catalog file, and the values of each key.

A reader converts one TOML value into the catalog's own, or raises `UsageError` with the
expectation; `read_value` and `read_table` add file and line. `build` checks several keys together.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from decimal import Decimal
from fractions import Fraction
from functools import cache
from typing import Any, Final, TypeAlias, TypeVar, get_type_hints

from mikas.catalog.limits import LIMITS, Confidence, Level
from mikas.catalog.loading.source import CatalogFile, KeyPath
from mikas.catalog.model import INTERPRETATIONS
from mikas.cleaning import clean_text
from mikas.errors import CatalogError, UsageError, usage_error
from mikas.i18n import Text
from mikas.options import nearest

T = TypeVar("T")
Reader: TypeAlias = Callable[[object], object]
Schema: TypeAlias = "Mapping[str, Reader | Schema]"

ANY = "*"
"""In a schema: the rule for every other key."""

LONGEST_TEXT = 4000  # characters; the shipped texts have up to 200

_RATIO = re.compile(r"\s*([+-]?\d{1,15})\s*(?:/\s*(\d{1,15})\s*)?", re.ASCII)
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*")
_CONSTANT = re.compile(r"[a-z][a-z0-9_]*")
_NUMBER_KEY = re.compile(r"0x[0-9a-f]{1,2}|0|[1-9]\d{0,2}", re.IGNORECASE | re.ASCII)


def string(value: object) -> str:
    """Read a text of at most `LONGEST_TEXT` characters; `mikas.cleaning` cleans it."""
    if isinstance(value, str):
        if len(value) > LONGEST_TEXT:
            raise usage_error(
                f"is longer than {LONGEST_TEXT} characters; shorten it",
                f"длиннее {LONGEST_TEXT} знаков; сократите",
            )
        return clean_text(value)
    raise usage_error("must be a text in quotes", "нужен текст в кавычках")


def boolean(value: object) -> bool:
    """Read `true` or `false`."""
    if isinstance(value, bool):
        return value
    raise usage_error("must be true or false", "нужно true или false")


def strings(value: object) -> tuple[str, ...]:
    """Read a list of texts."""
    if isinstance(value, list) and all(isinstance(item, str) for item in value):
        return tuple(map(string, value))
    raise usage_error('must be a list of texts, as ["E1"]', 'нужен список текстов, например ["E1"]')


def integer(low: int, high: int) -> Reader:
    """Return the reader of a whole number from `low` to `high`."""

    def read(value: object) -> int:
        if isinstance(value, int) and not isinstance(value, bool) and low <= value <= high:
            return value
        raise usage_error(
            f"must be a whole number from {low} to {high}", f"нужно целое число от {low} до {high}"
        )

    return read


def choice(make: Callable[[str], object], *allowed: str) -> Reader:
    """Return the reader of one of the words `allowed`."""

    def read(value: object) -> object:
        if isinstance(value, str) and value in allowed:
            return make(value)
        words = ", ".join(f'"{word}"' for word in allowed)
        raise usage_error(f"must be one of {words}", f"нужно одно из: {words}")

    return read


def rational(value: object) -> Fraction:
    """Read an exact number: whole, decimal, or a fraction in quotes."""
    if isinstance(value, str) and (match := _RATIO.fullmatch(value)):
        over, under = int(match[1]), int(match[2] or 1)
        if under:
            return Fraction(over, under)
    elif (number := _number(value)) is not None:
        return number
    raise usage_error(
        'must be a number, as 0.5, or a fraction in quotes, as "1/125"',
        'нужно число, например 0.5, или дробь в кавычках, например "1/125"',
    )


def number(value: object) -> float:
    """Read any number."""
    if (exact := _number(value)) is not None:
        return _plain(exact)
    raise usage_error("must be a number", "нужно число")


def limit(value: object) -> float | None:
    """Read a number, or `false` for none."""
    if value is False:
        return None
    if (exact := _number(value)) is not None:
        return _plain(exact)
    raise usage_error(
        "must be a number, or false for no limit", "нужно число, либо false, если предела нет"
    )


def span(value: object) -> tuple[float, float]:
    """Read `[low, high]`."""
    ends = [_number(item) for item in value] if isinstance(value, list) else []
    match ends:
        case [Fraction() as first, Fraction() as last]:
            low, high = _plain(first), _plain(last)
        case _:
            raise usage_error("must be two numbers, [low, high]", "нужны два числа: [низ, верх]")
    if low > high:
        raise usage_error(
            f"has its low end {low:g} above its high end {high:g}",
            f"нижний предел {low:g} выше верхнего {high:g}",
        )
    return low, high


def checked(read: Callable[[object], T], fits: Callable[[T], bool], en: str, ru: str) -> Reader:
    """Return the reader of what `read` reads, if that `fits`."""

    def read_and_check(value: object) -> T:
        if fits(found := read(value)):
            return found
        raise usage_error(en, ru)

    return read_and_check


def between(low: float, high: float) -> Reader:
    """Return the reader of a number from `low` to `high`."""
    return checked(
        lambda value: float(number(value)),
        lambda found: low <= found <= high,
        f"must be a number from {low:g} to {high:g}",
        f"нужно число от {low:g} до {high:g}",
    )


nonzero: Final = checked(rational, bool, "must not be 0", "не может быть 0")
positive: Final = checked(number, lambda it: it > 0, "must be above 0", "должно быть больше 0")
scale_ends: Final = checked(
    span, lambda it: it[0] != it[1], "must have two different ends", "концы должны различаться"
)


def _number(value: object) -> Fraction | None:
    """Return a number exactly; None if it is none, or outside 1e-30 to 1e15."""
    if isinstance(value, Decimal) and (
        not value or (value.is_finite() and -30 <= value.adjusted() < 15)
    ):
        return Fraction(value)
    if isinstance(value, int) and not isinstance(value, bool) and abs(value) < 10**15:
        return Fraction(value)
    return None


def _plain(number: Fraction) -> float:
    return int(number) if number.denominator == 1 else float(number)


def mnemonic(key: object) -> str:
    """Read a name as `TWAT` in any case."""
    if isinstance(key, str) and _NAME.fullmatch(key):
        return key.upper()
    raise usage_error(
        "is no name of Latin letters, digits and _ that begins with a letter",
        "имя должно состоять из латинских букв, цифр и _ и начинаться с буквы",
    )


def constant(key: object) -> str:
    """Read a constant's name: small letters, unlike a channel's."""
    if isinstance(key, str) and _CONSTANT.fullmatch(key):
        return key
    raise usage_error(
        "is no name of small Latin letters, digits and _ that begins with a letter",
        "имя должно состоять из строчных латинских букв, цифр и _ и начинаться с буквы",
    )


def byte_key(key: object) -> int:
    """Read a number as `13` or `0x0D`."""
    number = int(key, 0) if isinstance(key, str) and _NUMBER_KEY.fullmatch(key) else -1
    if 0 <= number <= 0xFF:
        return number
    raise usage_error(
        "is not named by a number from 0 to 255, as 13 or 0x0D",
        "имя должно быть числом от 0 до 255, например 13 или 0x0D",
    )


@dataclass(frozen=True, slots=True)
class Family:
    """A kind of entry: the reader of its name, and its keys."""

    key: Reader
    schema: Schema


TEXT: Schema = {"en": string, "ru": string}
CONFIDENCE = choice(Confidence, "confirmed", "reported", "unconfirmed")
CONVERSION: Schema = {
    "signed": boolean,
    "mask": integer(0, 0xFFFF),
    "bias": integer(-0xFFFF, 0xFFFF),
    "scale": nonzero,
    "offset": rational,
    "unit": string,
}
_ALARMS: Schema = {
    **dict.fromkeys(LIMITS, limit),
    "hysteresis": number,
    "source": string,
    "confidence": CONFIDENCE,
}
_SCALES: Schema = {"gauge": scale_ends, "span_least": positive}
FAMILIES: Mapping[str, Family] = {
    "parameter": Family(
        mnemonic,
        {
            "code": integer(0, 0xFF),
            "size": integer(1, 2),
            "text": TEXT,
            "short": TEXT,
            **CONVERSION,
            "literal": CONVERSION,
            "alternative": CONVERSION,
            "family": CONVERSION,
            "decimals": integer(0, 6),
            "range": span,
            "reference": span,
            "reference_confidence": CONFIDENCE,
            **_SCALES,
            "source": string,
            "confidence": CONFIDENCE,
            "errata": strings,
            "limits": {**_ALARMS, "when_true": choice(Level, *Level)},
            "lamp": {"on": TEXT, "off": TEXT, "trouble": choice(Level, *Level)},
            "meaning": {"low": TEXT, "high": TEXT, "source": string, "confidence": CONFIDENCE},
        },
    ),
    "derived": Family(
        mnemonic,
        {
            "text": TEXT,
            "short": TEXT,
            "formula": string,
            "constants": {ANY: number},
            "accumulates": boolean,
            "unit": string,
            "decimals": integer(0, 6),
            **_SCALES,
            "limits": _ALARMS,
            "source": string,
            "confidence": CONFIDENCE,
        },
    ),
    "instrument": Family(
        mnemonic,
        {
            "text": TEXT,
            "short": TEXT,
            "unit": string,
            "decimals": integer(0, 8),
            "range": span,
            **_SCALES,
            "limits": _ALARMS,
            "source": string,
            "confidence": CONFIDENCE,
        },
    ),
    "fault": Family(
        byte_key,
        {
            "text": TEXT,
            "check": TEXT,
            "check_confidence": CONFIDENCE,
            "parameters": strings,
            "sensor": strings,
            "confidence": CONFIDENCE,
            "sources": strings,
            "informational": boolean,
        },
    ),
    "model": Family(byte_key, {"text": TEXT, "source": string, "confidence": CONFIDENCE}),
    "erratum": Family(
        mnemonic,
        {
            "title": TEXT,
            "reason": TEXT,
            "default": TEXT,
            "alternative": TEXT,
            "family": TEXT,
            "selected_by": choice(str, "", *INTERPRETATIONS[1:]),
            "source": string,
        },
    ),
    "unit": Family(string, {"text": TEXT}),
}


@cache
def schema_of(kind: type) -> dict[str, Reader | Schema]:
    """Return the keys of a table for a dataclass: of each field with a rule in its annotation.

    `hold: Annotated[float, between(0, 3600)]` is the key `hold`; a text after the rule is the key
    of a field with another name.
    """
    hints = get_type_hints(kind, include_extras=True)
    rules = {name: getattr(hint, "__metadata__", None) for name, hint in hints.items()}
    return {[name, *rule[1:]][-1]: rule[0] for name, rule in rules.items() if rule}


def made(kind: type[T], keys: Mapping[str, Any], **given: object) -> T:
    """Create a dataclass from `given`, and for other fields from the keys of the name."""
    own = {key: value for key, value in keys.items() if key in kind.__annotations__}
    return kind(**own | given)


def read_value(source: CatalogFile, path: KeyPath, reader: Reader, value: object) -> object:
    """Return the value as `reader` converts it. CatalogError: it does not fit."""
    try:
        return reader(value)
    except UsageError as error:
        raise source.wrong(path, error.reason) from None


def read_table(source: CatalogFile, path: KeyPath, value: object, schema: Schema) -> dict[str, Any]:
    """Return the table at `path` with all its values converted. CatalogError: an invalid one."""
    if schema is TEXT and isinstance(value, str):
        value = {"en": value, "ru": value}
    table = {}
    for key, item in as_table(source, path, value, ".".join(path)).items():
        here = (*path, key)
        rule = schema.get(key) or schema.get(ANY)
        if rule is None:
            raise unknown_key(source, here, schema)
        if callable(rule):
            table[key] = read_value(source, here, rule, item)
        else:
            table[key] = read_table(source, here, item, rule)
    return table


def as_table(source: CatalogFile, path: KeyPath, value: object, header: str) -> dict[str, Any]:
    """Return `value` if it is a table, which `header` begins. CatalogError: it is none."""
    if isinstance(value, dict):
        return value
    problem = Text(f"must be a table, as [{header}]", f"нужна таблица, например [{header}]")
    raise source.wrong(path, problem)


def unknown_key(source: CatalogFile, path: KeyPath, known: Iterable[str]) -> CatalogError:
    """Return the error for a key that is not `known`."""
    key, names = path[-1], list(known)
    if close := nearest(key, names):
        known_ones = Text(f"the nearest is `{close[0]}`", f"ближайший — `{close[0]}`")
    else:
        known_ones = Text("known are " + ", ".join(names), "есть: " + ", ".join(names))
    return source.error(
        path,
        f"unknown key `{key}`; {known_ones.en}",
        f"неизвестный ключ `{key}`; {known_ones.ru}",
    )
