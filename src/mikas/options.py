"""Options given by name as text: `?baud=9600&dtr=1` of a URL, the settings of a virtual ECU.

An error names the option, the allowed values and the given value; an unknown name, the nearest one.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Collection, Iterable, Mapping
from contextlib import suppress
from enum import Enum
from math import inf, nan
from typing import TypeVar

from mikas.errors import UsageError, usage_error
from mikas.i18n import Text

E = TypeVar("E", bound=Enum)

_SWITCH = {"1": True, "on": True, "yes": True, "true": True,
          "0": False, "off": False, "no": False, "false": False}  # fmt: skip
_SHORT_LIST = 8  # names; a longer list is left out if one of them is near
_LARGEST = sys.float_info.max
_INTEGER = re.compile("[+-]?[0-9]{1,18}")


def invalid_value(name: str, value: object, allowed: Text | str) -> UsageError:
    """Return the error for an option whose value is not `allowed`."""
    if isinstance(allowed, str):
        allowed = Text(allowed, allowed)
    return usage_error(
        f"“{value}” is not a valid value for {name}; allowed: {allowed.en}",
        f"«{value}» не подходит для {name}; можно: {allowed.ru}",
    )


def check_choice(name: str, value: object, allowed: Collection[str]) -> None:
    """Raise `UsageError` if `value` is not one of `allowed`."""
    if value not in allowed:
        raise invalid_value(name, value, ", ".join(allowed))


def check_number(name: str, value: object, *, lowest: float, whole: bool = False) -> None:
    """Raise `UsageError` if `value` is not a finite number of at least `lowest`."""
    kinds = int if whole else (int, float)
    is_number = isinstance(value, kinds) and not isinstance(value, bool)
    number = value if isinstance(value, kinds) and is_number else nan
    if not lowest <= number <= _LARGEST:  # false for nan
        shown = value if isinstance(value, int | float) else repr(value)  # np.int64(3), '3'
        raise invalid_value(name, shown, _range(lowest, inf, whole=whole))


def check_names(given: Iterable[str], allowed: Collection[str]) -> None:
    """Raise `UsageError` for the first name that is not `allowed`, with the nearest one."""
    for name in given:
        if name not in allowed:
            raise UsageError(problem=_no_option(name, allowed))


def _no_option(name: str, allowed: Collection[str]) -> Text:
    if not allowed:
        return Text("it takes no options", "у него нет настроек")
    problem = Text(f"there is no option “{name}”", f"настройки «{name}» нет")
    if len(allowed) <= _SHORT_LIST or not nearest(name, allowed):
        listed = ", ".join(allowed)
        problem = Text(f"{problem.en}, only: {listed}", f"{problem.ru}, есть: {listed}")
    return with_nearest(problem, name, allowed)


def with_nearest(problem: Text, word: str, known: Iterable[str]) -> Text:
    """Return `problem`, followed by the one of `known` that `word` may be a misspelling of."""
    for name in nearest(word, known):
        return Text(f"{problem.en}. Did you mean {name}?", f"{problem.ru}. Может быть, {name}?")
    return problem


_LOOKALIKES = str.maketrans("АВЕЁІЈКМНОРЅСТУХавеёіјкморѕстух", "ABEEIJKMHOPSCTYXabeeijkmopsctyx")


def in_latin(word: str) -> str:
    """Return `word` with each Cyrillic letter that looks like a Latin one replaced by that."""
    return word.translate(_LOOKALIKES)


def nearest(word: str, known: Iterable[str], most: int = 1) -> tuple[str, ...]:
    """Return the names most like `word`, best first, ignoring case and alphabet (ТWАТ)."""
    from difflib import get_close_matches

    by_key = {name.upper(): name for name in known}
    key = in_latin(word.upper())
    if key in by_key:
        return (by_key[key],)
    return tuple(by_key[match] for match in get_close_matches(key, by_key, most))


class OptionParser:
    """Typed values from `options`, the `default` for a missing one; `UsageError` if invalid."""

    def __init__(self, options: Mapping[str, str]) -> None:
        self._options = options

    def integer(
        self, name: str, default: int, *, lowest: float = -inf, highest: float = inf
    ) -> int:
        """Return a whole number of decimal digits."""
        text = self._options.get(name)
        if text is None:
            return default
        if _INTEGER.fullmatch(text) and lowest <= int(text) <= highest:
            return int(text)
        raise invalid_value(name, text, _range(lowest, highest, whole=True))

    def number(self, name: str, default: float, *, highest: float) -> float:
        """Return a number from 0 to `highest`."""
        text = self._options.get(name)
        if text is None:
            return default
        with suppress(ValueError):
            if 0 <= float(text) <= highest:
                return float(text)
        raise invalid_value(name, text, _range(0, highest))

    def switch(self, name: str, *, default: bool) -> bool:
        """Return True for `1 on yes true`, False for `0 off no false`."""
        text = self._options.get(name)
        if text is None:
            return default
        if text.lower() not in _SWITCH:
            raise invalid_value(name, text, "0, 1")
        return _SWITCH[text.lower()]

    def choice(self, name: str, default: str, allowed: Collection[str]) -> str:
        """Return one of the words `allowed`."""
        text = self._options.get(name, default)
        check_choice(name, text, allowed)
        return text

    def member(self, name: str, default: E) -> E:
        """Return the member of the enum of `default` with this value."""
        kind = type(default)
        return kind(self.choice(name, default.value, [member.value for member in kind]))


def _range(lowest: float, highest: float, *, whole: bool = False) -> Text | str:
    if highest < inf:
        return f"{lowest:.10g} … {highest:.10g}"
    if lowest == -inf:
        return "0, 1, 2 …"
    en, ru = ("a whole number", "целое число") if whole else ("a number", "число")
    return Text(f"{en} from {lowest:g} up", f"{ru} от {lowest:g}")
