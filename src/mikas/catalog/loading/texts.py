"""The texts of an entry that it may have: a flag's lamp, what an odd value means, what to check."""

from __future__ import annotations

from pathlib import PurePath
from typing import Any

from mikas.catalog.conversion import NO_TEXT
from mikas.catalog.loading.entries import Entry
from mikas.catalog.loading.limits import NOT_FOR_FLAGS, ONLY_FOR_FLAGS
from mikas.catalog.model import Lamp, Meaning
from mikas.i18n import Text


def optional(entry: Entry, *path: str) -> Text:
    """The text at `path`, in both languages; empty if it is not there."""
    return entry.text(*path) if path in entry.places else NO_TEXT


def lamp(entry: Entry, *, is_flag: bool) -> Lamp | None:
    """Both texts of a flag's lamp; None if it has none."""
    if not _fits(entry, "lamp", ONLY_FOR_FLAGS, fits=is_flag):
        return None
    return Lamp(on=entry.text("lamp", "on"), off=entry.text("lamp", "off"))


def meaning(entry: Entry, *, is_flag: bool) -> Meaning | None:
    """What its table `meaning` says; None if it says nothing."""
    if not _fits(entry, "meaning", NOT_FOR_FLAGS, fits=not is_flag):
        return None
    said: dict[str, Any] = {"source": PurePath(entry.source.name).name}
    said |= entry.values["meaning"]
    said |= {side: optional(entry, "meaning", side) for side in ("low", "high")}
    return Meaning(**said)


def _fits(entry: Entry, key: str, problem: Text, *, fits: bool) -> bool:
    """Whether the key is there and makes sense; what an earlier file said no longer has to."""
    if key not in entry.values:
        return False
    if not fits and entry.order((key,)) >= entry.order(("mask",)):
        raise entry.wrong((key,), problem)
    return fits
