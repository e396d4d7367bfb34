"""The form of `unit.json`: a reader for each kind of value, and the key of one that is wrong.

A reader raises `UsageError` with what belongs there, or `WrongKey` for a key below its own.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from enum import Enum
from typing import Any, Final

from mikas.catalog.loading.fields import Reader, choice, integer
from mikas.cleaning import clean_line
from mikas.commands.unit import ReadProgramPassport, passport_text
from mikas.errors import UsageError, usage_error
from mikas.i18n import Text
from mikas.options import with_nearest

LONGEST_DATUM: Final = 255
"""The most bytes of one datum, and of the response to an unknown command."""
SILENT: Final = "silent"
PASSPORTS: Final = 8  # 51–53, 54–58
_LONGEST_PATH: Final = 80  # characters of a key that an error shows

_NO_OBJECT: Final = Text(
    "must be a JSON object, as a survey writes it", "нужен объект JSON, как его пишет обследование"
)
_NO_KEY: Final = Text("is no key of a unit's profile", "такого ключа в профиле блока нет")


class WrongKey(Exception):
    """A value that does not belong at `path`; an empty one is the file itself."""

    def __init__(self, path: str, problem: Text) -> None:
        super().__init__(path)
        self.path = path
        self.problem = problem

    def at(self, place: str) -> UsageError:
        """Return the error for a person, who knows the file as `place`."""
        path, problem = clean_line(self.path, _LONGEST_PATH), self.problem
        en, ru = (f" {path}", f" {path}:") if path else ("", "")
        return usage_error(
            f"{place}:{en} {problem.en}. Correct that file, or survey the unit again",
            f"{place}:{ru} {problem.ru}. Исправьте этот файл или обследуйте блок заново",
        )


def read_key(path: str, value: object, read: Reader) -> Any:  # noqa: ANN401  (a field of any type)
    """Return what `read` makes of `value`. Raises `WrongKey` with `path` before its own."""
    try:
        return read(value)
    except UsageError as error:
        raise WrongKey(path, error.reason) from None
    except WrongKey as error:
        raise WrongKey(f"{path}.{error.path}" if error.path else path, error.problem) from None


def object_of(value: object) -> Mapping[str, object]:
    """Return `value`, a JSON object. Raises `WrongKey`."""
    if isinstance(value, Mapping) and all(isinstance(key, str) for key in value):
        return value
    raise WrongKey("", _NO_OBJECT)


def read_keys(value: object, readers: Mapping[str, Reader]) -> dict[str, Any]:
    """Return the keys of a JSON object as their `readers` read them; a null is left out.

    Raises `WrongKey`, also for a key without a reader.
    """
    found = {}
    for key, item in object_of(value).items():
        if key not in readers:
            raise WrongKey(key, with_nearest(_NO_KEY, key, readers))
        if item is not None:
            found[key] = read_key(key, item, readers[key])
    return found


def table_of(key: Reader, read: Reader) -> Reader:
    """Return the reader of an object with keys that `key` reads; a null in it is left out."""

    def table(value: object) -> dict[Any, Any]:
        return {
            read_key(name, name, key): read_key(name, item, read)
            for name, item in object_of(value).items()
            if item is not None
        }

    return table


def list_of(read: Reader, most: int) -> Callable[[object], tuple[Any, ...]]:
    """Return the reader of a list with at most `most` entries, as a tuple."""

    def listed(value: object) -> tuple[Any, ...]:
        if isinstance(value, list | tuple) and len(value) <= most:
            return tuple(read_key(str(at), item, read) for at, item in enumerate(value))
        raise usage_error(
            f"must be a list with at most {most} entries", f"нужен список, записей не больше {most}"
        )

    return listed


def seconds(highest: float) -> Reader:
    """Return the reader of a number from 0 to `highest`."""

    def read(value: object) -> float:
        if isinstance(value, int | float) and not isinstance(value, bool) and 0 <= value <= highest:
            return float(value)
        raise usage_error(
            f"must be a number from 0 to {highest:g}", f"нужно число от 0 до {highest:g}"
        )

    return read


def code(value: object) -> int:
    """Read a code in hex, as `1A`."""
    if isinstance(value, str) and re.fullmatch("[0-9A-Fa-f]{2}", value):
        return int(value, 16)
    raise usage_error('must be a code in hex, as "1A"', 'нужен код в hex, например "1A"')


def code_among(known: Iterable[int]) -> Reader:
    """Return the reader of one of the codes `known`, in hex."""
    words = [code_text(each) for each in known]
    return lambda value: code(choice(str, *words)(value))


def word_among(known: Iterable[str]) -> Reader:
    """Return the reader of one of the words `known`."""
    return choice(str, *known)


def codes(value: object) -> frozenset[int]:
    """Read a list of codes in hex."""
    return frozenset(list_of(code, 0x100)(value))


def hex_bytes(value: object) -> bytes:
    """Read bytes in hex."""
    if isinstance(value, str) and re.fullmatch(f"(?:[0-9A-Fa-f]{{2}}){{1,{LONGEST_DATUM}}}", value):
        return bytes.fromhex(value)
    raise usage_error(
        f'must be 1 to {LONGEST_DATUM} bytes in hex, as "0A1B"',
        f'нужны байты в hex, от 1 до {LONGEST_DATUM}, например "0A1B"',
    )


def silence_or_bytes(value: object) -> str:
    """Read `silent`, or a response's body in hex."""
    if value == SILENT:
        return SILENT
    try:
        return hex_bytes(value).hex().upper()
    except UsageError as error:
        raise usage_error(
            f'must be "{SILENT}", or {error.reason.en.removeprefix("must be ")}',
            f'нужно "{SILENT}" или {error.reason.ru.removeprefix("нужны ")}',
        ) from None


def one_of(kind: type[Enum], *members: Enum) -> Reader:
    """Return the reader of the value of one of `members`; without any, of each."""
    return choice(kind, *(each.value for each in members or kind))


def passports(value: object) -> tuple[str | None, ...]:
    """Read the texts of 51–58, each of which may be null."""
    items: tuple[str | None, ...] = list_of(_passport, PASSPORTS)(value)
    if len(items) != PASSPORTS:
        raise usage_error(f"must have {PASSPORTS} entries", f"нужно записей: {PASSPORTS}")
    return items


def _passport(value: object) -> str | None:
    if value is None:
        return None
    if isinstance(value, str):
        sent = ReadProgramPassport(1).respond(value)
        if passport_text(sent.rstrip(b"\0")) == value:
            return value
    raise usage_error(
        "must be a text of at most 16 characters of code page 866",
        "нужен текст не длиннее 16 знаков, все из кодировки 866",
    )


faults: Final = list_of(integer(0, 0xFF), 0xFF)


def code_text(number: int) -> str:
    """Return a code as it stands in the file, `1A`."""
    return f"{number:02X}"


def code_texts(numbers: Iterable[int]) -> list[str]:
    """Return codes as they stand in the file."""
    return [code_text(each) for each in sorted(numbers)]
