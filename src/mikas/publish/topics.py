"""The topics, below one base, and the names that other programs get from it.

A name may come from a user's catalog: a character that is a wildcard, a level or not ASCII is
written as `%2F`, so that two names never share a topic.
"""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from typing import Final
from urllib.parse import quote

from mikas.cleaning import clean_line
from mikas.errors import usage_error

DEFAULT_BASE: Final = "mikas/car"
_LONGEST: Final = 200  # bytes


@dataclass(frozen=True, slots=True)
class Topics:
    """All topics below `base`. Raises `UsageError` for a base that no topic can begin with."""

    base: str = DEFAULT_BASE
    availability: str = field(init=False)
    """`online`; `offline` after the end, or as the last will."""
    state: str = field(init=False)
    """The state of the line to the unit."""
    channels: str = field(init=False)
    """Name, unit and text of each published channel."""
    unit: str = field(init=False)
    """Model and passports of the unit."""
    values: str = field(init=False)
    """The latest values."""
    samples: str = field(init=False)
    """Every sample, several in a message."""
    faults: str = field(init=False)
    """The stored faults."""
    alarms: str = field(init=False)
    """The present alarms."""
    event: str = field(init=False)
    """What happened, one message each."""

    def __post_init__(self) -> None:
        check_topic(self.base)
        for topic in fields(self)[1:]:
            object.__setattr__(self, topic.name, f"{self.base}/{topic.name}")

    @property
    def retained(self) -> tuple[str, ...]:
        """The topics whose latest message the broker keeps."""
        return (self.channels, self.unit, self.faults, self.alarms, self.state, self.availability)

    def value(self, name: str) -> str:
        """Return the topic of one channel."""
        return f"{self.base}/value/{quote(name, safe=':')}"

    @property
    def identifier(self) -> str:
        """A name for this base of letters, digits, `_` and `-`; each base has its own."""
        return identifier(self.base)


def identifier(text: str) -> str:
    """Return `text` in letters, digits, `_` and `-`: `/` is `--`, another character `-XX`.

    Different texts have different identifiers.
    """
    return "".join(map(_plain, text))


def _plain(character: str) -> str:
    if character == "/":
        return "--"
    if character == "_" or (character.isascii() and character.isalnum()):
        return character
    return "".join(f"-{byte:02X}" for byte in character.encode())


def check_topic(topic: str) -> None:
    """Raise `UsageError` for a topic with wildcards, empty levels, control characters, or `$`."""
    if any(sign in topic for sign in "+#"):
        raise usage_error(
            f"“{topic}” is no topic to publish to: + and # are wildcards",
            f"«{topic}» — не тема для публикации: + и # — знаки подстановки",
        )
    if topic.startswith("$"):
        raise usage_error(
            f"“{topic}”: topics that begin with $ are the broker's own",
            f"«{topic}»: темы на $ — собственные темы брокера",
        )
    if not all(topic.split("/")):
        raise usage_error(
            f"“{topic}”: a topic has words between its slashes, like {DEFAULT_BASE}",
            f"«{topic}»: в теме между косыми чертами должны быть слова, например {DEFAULT_BASE}",
        )
    is_text = clean_line(topic) == topic and not any(map(_is_none, topic))
    if not is_text or len(topic.encode(errors="replace")) > _LONGEST:
        raise usage_error(
            f"a topic has up to {_LONGEST} bytes of text, without control characters",
            f"тема — это до {_LONGEST} байт текста без управляющих символов",
        )


def _is_none(character: str) -> bool:
    """Return whether Unicode has kept this place empty: Mosquitto ends the connection for it."""
    code = ord(character)
    return code & 0xFFFE == 0xFFFE or 0xFDD0 <= code <= 0xFDEF
