"""Names that people use of the channels: «Обороты» and “rpm” for FREQ.

A table of data (`names.toml`) has names and the columns of logs; the channels' own texts are names
too, without their brackets, and so are the abbreviations inside these, unless two channels have
them. A name stands for a channel only where no channel, constant or function has it itself.
"""

from __future__ import annotations

import re
from collections.abc import Container, Iterable, Mapping
from functools import cache
from pathlib import Path
from typing import NamedTuple

from mikas import toml
from mikas.i18n import Text

_WORD = re.compile(r"[^\W_]+")
_BRACKETS = re.compile(r"\(([^()]*)\)")


class Names(NamedTuple):
    """Of a channel. `log`: its column in a log for MegaLogViewer; empty: its own name."""

    log: str = ""
    others: tuple[str, ...] = ()


_NONE = Names()


class Named(NamedTuple):
    """A channel with its texts."""

    name: str
    text: Text
    short: Text


def normal(name: str) -> str:
    """Return the name as it is compared: `Batt V` and `batt_v` are one."""
    return "_".join(_WORD.findall(name.casefold().replace("ё", "е")))


def names_of(channel: str) -> Names:
    """Return the table's names of a channel."""
    return _table().get(channel, _NONE)


@cache
def _table() -> Mapping[str, Names]:
    text = (Path(__file__).parent / "names.toml").read_text("utf-8")
    return {
        channel: Names(keys.get("log", ""), tuple(keys.get("names", ())))
        for channel, keys in toml.parse(text, bounded=False).items()
    }


def synonyms_of(channels: Iterable[Named]) -> dict[str, str]:
    """Return the channel of each name, the names as `normal` returns them."""
    channels = tuple(channels)
    of_texts: dict[str, set[str]] = {}
    of_table: dict[str, str] = {}
    for channel, text, short in channels:
        for words in (*text, *short):
            for name in (_BRACKETS.sub(" ", words), *_abbreviations(words)):
                of_texts.setdefault(normal(name), set()).add(channel)
        log, others = names_of(channel)
        of_table |= dict.fromkeys(map(normal, (*others, *([log] if log else []))), channel)
    found = {name: next(iter(of)) for name, of in of_texts.items() if len(of) == 1} | of_table
    for each in channels:
        found.pop(normal(each.name), None)  # its own name needs none
    found.pop("", None)
    return found


def named(word: str, channels: Container[str], synonyms: Mapping[str, str]) -> str:
    """Return the channel that `word` means in any case; the word in capitals if it means none."""
    name = word.upper()
    return name if name in channels else synonyms.get(normal(word), name)


def _abbreviations(words: str) -> Iterable[str]:
    for inside in _BRACKETS.findall(words):
        yield from inside.split(",")
