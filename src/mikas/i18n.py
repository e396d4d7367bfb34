"""The two languages that the product speaks.

A `Text` is the same sentence in both; whoever shows it picks one. The lowest layer, because errors,
commands and definitions all carry texts meant for a person.
"""

from __future__ import annotations

from typing import Literal, NamedTuple

Language = Literal["en", "ru"]


class Text(NamedTuple):
    """One sentence in English and in Russian; may hold `str.format` fields."""

    en: str
    ru: str

    def to(self, language: Language) -> str:
        """This text in `language`."""
        return self.ru if language == "ru" else self.en

    def filled(self, **fields: object) -> Text:
        """The same text with its fields filled in (a `Text` field in its own language)."""
        return Text(*(self._filled_in(language, fields) for language in ("en", "ru")))

    def _filled_in(self, language: Language, fields: dict[str, object]) -> str:
        shown = {
            name: value.to(language) if isinstance(value, Text) else value
            for name, value in fields.items()
        }
        return self.to(language).format(**shown)


def counted(count: int, english: tuple[str, str], russian: tuple[str, str, str]) -> Text:
    """`1 fault`, `3 faults`; `1 ошибка`, `3 ошибки`, `5 ошибок`."""
    en = english[0] if count == 1 else english[1]
    last = count % 10
    if count % 100 in _TENS or last == 0 or last > 4:
        ru = russian[2]
    else:
        ru = russian[0] if last == 1 else russian[1]
    return Text(f"{count} {en}", f"{count} {ru}")


_TENS = range(11, 15)


def byte_count(count: int) -> Text:
    """`1 byte`, `2 bytes`; `1 байт`, `2 байта`, `256 байт`."""
    return counted(count, ("byte", "bytes"), ("байт", "байта", "байт"))
