"""States of one recording: it grows, is changed where it lies, and lies about in older copies.

A longer state replaces a shorter one that it begins with. What has the same beginning and another
end replaces it only at the same place. Contents decide. They are read at the places that the user
has named, each file once for all its possible beginnings; a place that only the dataset names is
not opened.
"""

from __future__ import annotations

from bisect import bisect_left
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace

from mikas.errors import MikasError
from mikas.fleet.entries import HEADS, STEP, LedgerEntry
from mikas.fleet.job import HEAD, FileOutcome, beginnings, beginnings_of
from mikas.fleet.ledger import Ledger
from mikas.fleet.places import FoundFile, as_local, shown

_Level = tuple[int, str]
"""How many steps of the first bytes a recording has, and the digest of all of them."""


class States:
    """The recordings of a ledger by their beginnings. `found`: the files that the user named, by
    place as shown; `planned`: those of them that are added in this run.
    """

    def __init__(
        self, ledger: Ledger, found: Mapping[str, FoundFile], planned: Sequence[FoundFile]
    ) -> None:
        self._ledger, self._found = ledger, found
        self._planned = sorted({file.bytes for file in planned})
        self._longer: dict[_Level, dict[str, str]] = {}  # by digest of a beginning, the whole's key
        self._read = -1
        self._index()

    def _index(self) -> None:
        """Index the entries, again if they were read again."""
        if self._read == self._ledger.readings:
            return
        self._read = self._ledger.readings
        self._short: set[int] = set()  # lengths
        self._long: dict[str, set[int]] = defaultdict(set)  # by the last head
        self._at: dict[str, list[str]] = defaultdict(list)  # keys by place
        self._of: dict[_Level, list[str]] = defaultdict(list)  # keys by their level …
        self._beginning_as: dict[_Level, list[str]] = defaultdict(list)  # … and those below it
        self._whole: dict[str, str] = {}
        for entry in (*self._ledger.entries.values(), *self._ledger.away.values()):
            self.note(entry)

    def note(self, entry: LedgerEntry) -> None:
        """Note an entry that counts now."""
        if entry.bytes <= HEAD:
            self._short.add(entry.bytes)
        else:
            self._long[entry.heads[-1]].add(entry.bytes)
        for url in entry.sources:
            self._at[url].append(entry.key)
        self._of[_level(entry)].append(entry.key)
        for count, head in enumerate(entry.heads, 1):
            self._beginning_as[count, head].append(entry.key)
        if not entry.heads:
            self._beginning_as[0, ""].append(entry.key)
        self._whole |= dict.fromkeys(entry.replaces, entry.key)

    def earlier(self, outcome: FileOutcome) -> Iterator[tuple[LedgerEntry, bool]]:
        """Yield the entries that a new one replaces, each with whether it begins with it."""
        self._index()
        entry, url = outcome.entry, outcome.file.url
        assert entry is not None  # it is new
        short = sorted(length for length in self._short if length < entry.bytes)
        digests = beginnings(iter((outcome.opening,)), short)
        if len(entry.heads) == HEADS:
            long = sorted(it for it in self._long.get(entry.heads[-1], ()) if it < entry.bytes)
            digests |= _beginnings_at(url, long)
        seen = {entry.key}
        for known in self._with(digests):
            if entry.goes_on(known):  # else a stranger's entry has other heads than its recording
                seen.add(known.key)
                yield known, True
        for key in dict.fromkeys(self._at.get(shown(url), ())):
            known_there = self._ledger.known(key)
            if known_there is not None and key not in seen and entry.may_replace(known_there):
                yield known_there, False

    def longer(self, outcome: FileOutcome) -> LedgerEntry | None:
        """Return the recording in the dataset that begins with the content of a new entry."""
        self._index()
        entry, entries = outcome.entry, self._ledger.entries
        assert entry is not None  # it is new
        whole = entries.get(self._whole.get(entry.key, ""))
        if whole is not None and whole.goes_on(entry):
            return whole
        level = _level(entry)
        if level not in self._longer:
            self._longer[level] = self._read_longer(level)
        whole = entries.get(self._longer[level].get(entry.sha256, ""))
        is_elsewhere = whole is not None and shown(outcome.file.url) not in whole.sources
        return whole if is_elsewhere else None

    def settle(self) -> None:
        """Let no two states of a recording count that runs have added at the same time."""
        self._index()
        for level, keys in list(self._of.items()):
            lengths = sorted({it.bytes for key in keys if (it := self._ledger.entries.get(key))})
            for known in self._candidates(self._beginning_as[level], lengths):
                whole = self._ledger.entries.get(known.key)
                if whole is None:
                    continue
                older = [*filter(whole.goes_on, self._with(self._digests(known, lengths)))]
                if not older:
                    continue
                replaces, sources = list(whole.replaces), dict(whole.sources)
                for each in older:
                    replaces += (each.key, *each.replaces)
                    sources = each.sources | sources
                whole = replace(whole, replaces=tuple(dict.fromkeys(replaces)), sources=sources)
                self._ledger.commit(whole, older)
                self.note(self._ledger.entries[whole.key])

    def _read_longer(self, level: _Level) -> dict[str, str]:
        """Return the digests of the possible beginnings, of a level, of the entries there are."""
        first, last = level[0] * STEP, (level[0] + 1) * STEP if level[0] < HEADS else None
        end = len(self._planned) if last is None else bisect_left(self._planned, last)
        lengths = self._planned[bisect_left(self._planned, first) : end]
        keys = self._beginning_as[level] if level[0] else list(self._ledger.entries)
        found: dict[str, str] = {}
        for known in self._candidates(keys, lengths):
            for _, digest in self._digests(known, lengths):
                found.setdefault(digest, known.key)
        return found

    def _candidates(self, keys: Sequence[str], lengths: Sequence[int]) -> list[LedgerEntry]:
        """Return those entries, the shorter first, that may begin with one of such a length."""
        entries = (self._ledger.entries.get(key) for key in dict.fromkeys(keys))
        longer = (entry for entry in entries if entry and lengths and entry.bytes > lengths[0])
        return sorted(longer, key=lambda entry: entry.bytes)

    def _digests(self, known: LedgerEntry, lengths: Sequence[int]) -> set[tuple[int, str]]:
        """Return the digests of the beginnings of a recording, read where the user has it: what
        lies there now must still be, or begin with, that recording.
        """
        whole = (known.bytes, known.sha256)
        shorter = lengths[: bisect_left(lengths, known.bytes)]
        for place in known.sources:
            file = self._found.get(place)
            if file is not None and file.bytes >= known.bytes:
                digests = _beginnings_at(file.url, [*shorter, known.bytes])
                if whole in digests:
                    return digests - {whole}
        return set()

    def _with(self, digests: set[tuple[int, str]]) -> Iterator[LedgerEntry]:
        for length, digest in sorted(digests):
            known = self._ledger.known(digest[:32])
            if known is not None and (known.bytes, known.sha256) == (length, digest):
                yield known


def _level(entry: LedgerEntry) -> _Level:
    return len(entry.heads), entry.heads[-1] if entry.heads else ""


def _beginnings_at(url: str, lengths: Sequence[int]) -> set[tuple[int, str]]:
    if lengths:
        with suppress(OSError, MikasError), as_local(url) as path:
            return beginnings_of(path, lengths)
    return set()
