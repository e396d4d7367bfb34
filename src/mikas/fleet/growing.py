"""States of one recording: it grows, is changed where it lies, and lies about in older copies.

A longer state replaces a shorter one that it begins with. What has the same beginning and another
end replaces it only at the same place. Contents decide, read at the places that an entry notes.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import replace

from mikas.errors import MikasError
from mikas.fleet.job import digest_of
from mikas.fleet.ledger import Ledger, LedgerEntry
from mikas.fleet.places import FoundFile, as_local, shown


def earlier(
    file: FoundFile, entry: LedgerEntry, ledger: Ledger
) -> Iterator[tuple[LedgerEntry, bool]]:
    """Yield the entries that `entry`, of `file`, replaces, each with whether it begins with it."""
    for known in ledger.entries.values():
        if known.key != entry.key and _are_near(known, entry):
            is_beginning = known.bytes < entry.bytes and _begins(file.url, known)
            if is_beginning or shown(file.url) in known.sources:
                yield known, is_beginning


def longer(file: FoundFile, entry: LedgerEntry, ledger: Ledger) -> LedgerEntry | None:
    """Return the recording in the dataset that begins with the content of `entry`, of `file`."""
    for known in ledger.entries.values():
        if entry.key in known.replaces:
            return known
    elsewhere = (known for known in ledger.entries.values() if shown(file.url) not in known.sources)
    return next((known for known in elsewhere if _is_longer(known, entry)), None)


def settle(ledger: Ledger) -> None:
    """Let no two states of a recording count that runs have added at the same time."""
    by_first: dict[str, list[LedgerEntry]] = {}
    for entry in sorted(ledger.entries.values(), key=lambda each: each.bytes):
        by_first.setdefault(entry.heads[0] if entry.heads else "", []).append(entry)
    for alike in by_first.values():
        for at, read in enumerate(alike):
            entry = ledger.entries.get(read.key, read)  # with what it replaces by now
            known = next((it for it in alike[at + 1 :] if _is_longer(it, entry)), None)
            if known is not None and (known := ledger.entries.get(known.key)) is not None:
                replaces = dict.fromkeys((*known.replaces, entry.key, *entry.replaces))
                sources = entry.sources | known.sources
                whole = replace(known, replaces=tuple(replaces), sources=sources)
                ledger.commit(whole, [entry])


def _is_longer(known: LedgerEntry, entry: LedgerEntry) -> bool:
    """Return whether `known` begins with the content of `entry`, as far as it can be read."""
    if known.bytes <= entry.bytes or not _are_near(known, entry):
        return False
    return any(_begins(url, entry) for url in known.sources)


def _are_near(one: LedgerEntry, other: LedgerEntry) -> bool:
    """Return whether their first bytes are the same, as many as both have."""
    if one.heads[:1] != other.heads[:1] and one.heads and other.heads:
        return False  # most are: quickly
    return all(a == b for a, b in zip(one.heads, other.heads, strict=False))


def _begins(url: str, entry: LedgerEntry) -> bool:
    with suppress(OSError, MikasError), as_local(url) as path:
        return digest_of(path, entry.bytes)[0] == entry.sha256
    return False
