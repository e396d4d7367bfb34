"""Texts in English and Russian, used by all layers."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final, Literal, NamedTuple

Language = Literal["en", "ru"]

_SIGNS: Final = "-+\N{MINUS SIGN}"
_ENGLISH: Final = {"steps": "step", "turns": "turn", "times": "time"}
_RUSSIAN: Final = {
    "шаг": ("шаг", "шага", "шагов"),
    "оборот": ("оборот", "оборота", "оборотов"),
    "раз": ("раз", "раза", "раз"),
}
"""Units that are counted, as a table names them, with their forms."""


class Text(NamedTuple):
    """One sentence in English and in Russian; may hold `str.format` fields."""

    en: str
    """In English."""
    ru: str
    """In Russian."""

    def to(self, language: Language) -> str:
        """Return the text in `language`."""
        return self.ru if language == "ru" else self.en

    def filled(self, **fields: object) -> Text:
        """Return the text with its fields filled in; a `Text` field in the same language."""

        def fill(language: Language) -> str:
            words = {n: f.to(language) if isinstance(f, Text) else f for n, f in fields.items()}
            return self.to(language).format(**words)

        return Text(fill("en"), fill("ru"))


def joined(separator: str, texts: Iterable[Text]) -> Text:
    """Return the texts with a separator between them, in each language; at least one text."""
    return Text(*map(separator.join, zip(*texts, strict=True)))


def plural(count: int, one: str, more: str) -> str:
    """Return `1 gap`, `3 gaps`."""
    return f"{count} {one if count == 1 else more}"


def counted(count: int, english: tuple[str, str], russian: tuple[str, str, str]) -> Text:
    """Return `1 fault`, `3 faults`; `1 ошибка`, `3 ошибки`, `5 ошибок`."""
    return Text(plural(count, *english), f"{count} {russian[_russian(count)]}")


def unit_after(shown: Text, unit: Text) -> Text:
    """Return a unit as it stands after a number that is `shown`: 31 шаг, 32 шага, 2,5 шага.

    Most units are symbols and stay as they are: V, об/мин.
    """
    en, ru = unit
    if en in _ENGLISH and shown.en.lstrip(_SIGNS) == "1":
        en = _ENGLISH[en]
    if ru in _RUSSIAN:
        digits = shown.ru.lstrip(_SIGNS)
        ru = _RUSSIAN[ru][_russian(int(digits)) if digits.isdecimal() else 1]
    return Text(en, ru)


def _russian(count: int) -> int:
    """Return which of the forms of 1, 2 and 5 a count has."""
    last = count % 10
    if count % 100 in range(11, 15) or last == 0 or last > 4:
        return 2
    return 0 if last == 1 else 1


def byte_count(count: int) -> Text:
    """Return `1 byte`, `2 bytes`; `1 байт`, `2 байта`, `256 байт`."""
    return counted(count, ("byte", "bytes"), ("байт", "байта", "байт"))
