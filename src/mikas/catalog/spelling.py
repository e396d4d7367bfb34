"""The nearest names to one that does not exist: a typing slip, or Cyrillic letters (ТWАТ)."""

from __future__ import annotations

from collections.abc import Iterable

_LOOKALIKES = str.maketrans("АВЕЁІЈКМНОРЅСТУХавеёіјкморѕстух", "ABEEIJKMHOPSCTYXabeeijkmopsctyx")


def in_latin(word: str) -> str:
    """The word with each Cyrillic letter that looks like a Latin one replaced by it."""
    return word.translate(_LOOKALIKES)


def nearest(word: str, names: Iterable[str], most: int = 3) -> tuple[str, ...]:
    """The names most like `word`, best first; case and alphabet are overlooked."""
    from difflib import get_close_matches

    by_key = {name.upper(): name for name in names}
    key = in_latin(word.upper())
    if key in by_key:
        return (by_key[key],)
    return tuple(by_key[match] for match in get_close_matches(key, by_key, most))
