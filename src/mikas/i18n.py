"""Texts in English and Russian, used by all layers."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Literal, NamedTuple

Language = Literal["en", "ru"]


class Text(NamedTuple):
    """One sentence in English and in Russian; may hold `str.format` fields."""

    en: str
    ru: str

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
    last = count % 10
    if count % 100 in range(11, 15) or last == 0 or last > 4:
        ru = russian[2]
    else:
        ru = russian[0] if last == 1 else russian[1]
    return Text(plural(count, *english), f"{count} {ru}")


def byte_count(count: int) -> Text:
    """Return `1 byte`, `2 bytes`; `1 байт`, `2 байта`, `256 байт`."""
    return counted(count, ("byte", "bytes"), ("байт", "байта", "байт"))
