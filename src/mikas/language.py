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
