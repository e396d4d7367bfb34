"""The ledger of a dataset: for each recording its content, what interpreted it, and its files.

    DATASET/mikas-fleet.json      that this is a dataset, and of which form
    DATASET/_ledger/KEY.json      one entry for each recording; KEY: of its content
    DATASET/samples/car=…/day=…/KEY-VERSION.parquet      and the other tables

A file of a table counts once an entry names it. So an entry, written at once, makes all files of a
recording count together, and what a killed program has left never does. An entry that replaces
others names their files and entries as `obsolete`: from then on they do not count, and are removed,
by the next program if this one is killed. It may replace other states of its own recording only.

A dataset may be a stranger's. An entry that is not sound (`fleet/entries.py`), that would replace
another recording, or whose tables can't be used, does not count and is named in `refused`; the
others do. Where an entry says its
recording was found is only compared with the places that the user names: it opens none.

An entry has size and SHA-256 of its tables. The sizes come with the list of the files, so they are
always compared; the contents, which have to be read, if the user asks for it (`--check`).
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from hashlib import sha256
from typing import Final

from mikas.errors import FleetError
from mikas.fleet.entries import (
    FOLDER,
    LARGEST_TABLE,
    LONGEST,
    NOT_ITS_OWN,
    SUFFIX,
    LedgerEntry,
    json_of,
    key_in,
    parse_entry,
    reason_not_sound,
    size_in,
    stamp_of,
)
from mikas.fleet.places import PARTS, is_of_file, shown
from mikas.fleet.stores import Store
from mikas.fleet.tables import TABLES
from mikas.i18n import Text

MARKER: Final = "mikas-fleet.json"
FORM: Final = 1
_AT_ONCE: Final = 200  # entries that one write replaces: it names all their files
_NO_DATASET: Final = Text(
    "this is no dataset of recordings (it has no {marker}); `mikas fleet add FOLDER --to DATASET` "
    "makes one",
    "это не набор записей (в нём нет {marker}); его создаёт `mikas fleet add ПАПКА --to НАБОР`",
).filled(marker=MARKER)
_OTHER_FILES: Final = Text(
    "this folder has other files in it; name a new or an empty folder for the dataset",
    "в этой папке лежат другие файлы; назовите для набора новую или пустую папку",
)
_CHANGED: Final = Text(
    "{name}: the file is not as it was written; `mikas fleet add` makes it anew from its recording",
    "{name}: файл не такой, каким был записан; `mikas fleet add` создаст его заново из записи",
)
_AWAY: Final = Text(
    "{reason}; its recording ({recording}) does not count until this is mended or it is added "
    "again",
    "{reason}; её запись ({recording}) не считается, пока это не исправлено или её не добавили "
    "снова",
)
_LATER: Final = Text(
    "this dataset was made by a later version of mikas; update this one",
    "этот набор создан более новой версией mikas; обновите эту",
)


class Ledger:
    """The entries of a dataset, all in memory. Raises `FleetError`.

    `refused`: by name of their file, the entries that do not count, and why; `away`: those of them
    that are sound, but whose tables can't be used now; `readings`: how many times the entries were
    read.
    """

    def __init__(self, files: Store) -> None:
        self.files = files
        self.entries: dict[str, LedgerEntry] = {}
        self.refused: dict[str, Text] = {}
        self.away: dict[str, LedgerEntry] = {}
        self.readings: int = 0
        self._written: set[str] = set()  # names of own files, which a store may list late
        self._noted: set[str] = set()
        self._replaced: set[str] = set()  # keys of sound entries that others replace
        self.sizes: dict[str, int] = {}  # of the files, as last looked at
        self.refresh()

    def refresh(self) -> None:
        """Read the entries again: other runs may have changed them."""
        self.write_noted()
        self.readings += 1
        read = self.files.contents(FOLDER, SUFFIX, LONGEST)
        for name in sorted(self._written - read.files.keys() - read.unfit.keys()):
            read.add(name, self.files.read(f"{FOLDER}/{name}", LONGEST))
        reasons = self.refused
        self.refused = {f"{FOLDER}/{name}": reason for name, reason in read.unfit.items()}
        found = {}
        for name, data in read.files.items():
            try:
                entry = parse_entry(data, name)
            except ValueError as error:
                self.refused[f"{FOLDER}/{name}"] = reason_not_sound(error)
            else:
                found[entry.key] = entry
        self._settle(found)
        self.entries = {
            key: entry
            for key, entry in found.items()
            if key not in self._replaced and entry.name not in self.refused
        }
        away, self.away = self.away, {}
        for key in away.keys() & self.entries.keys():
            self.refuse(self.entries[key], reasons[away[key].name])

    def _settle(self, found: Mapping[str, LedgerEntry]) -> None:
        """Find the entries that others replace, and refuse those that would replace another
        recording. One that is replaced replaces none: so no two do it to each other.

        `replaces` counts as long as the entry does: another run may write an entry back, with a
        source of it, that was just replaced.
        """
        self._replaced = set()
        for entry in sorted(found.values(), key=lambda it: it.bytes, reverse=True):
            if entry.key not in self._replaced:
                others = [found[key] for key in sorted(entry.replaced & found.keys())]
                foreign = next((it for it in others if not entry.may_replace(it)), None)
                if foreign is not None:
                    self.refused[entry.name] = NOT_ITS_OWN.filled(name=foreign.name)
                else:
                    self._replaced.update(other.key for other in others)

    def commit(self, entry: LedgerEntry, older: Sequence[LedgerEntry] = ()) -> None:
        """Let an entry count, and its former self and `older` ones no more."""
        for at in range(0, max(1, len(older)), _AT_ONCE):
            self._commit(entry, older[at : at + _AT_ONCE])

    def _commit(self, entry: LedgerEntry, older: Sequence[LedgerEntry]) -> None:
        gone: list[str] = []
        before = self.known(entry.key)
        for each in (*([before] if before else []), *older):
            gone += [name for name in each.files if name not in entry.files]
            gone += [each.name] if each.key != entry.key else []
        entry = replace(entry, obsolete=tuple(gone))
        self._write(entry)
        for each in older:
            self._forget(each)
            self._replaced.add(each.key)
        self._forget(entry)
        self.entries[entry.key] = entry
        self.clear(entry)

    def known(self, key: str) -> LedgerEntry | None:
        """Return an entry that counts, or would if its tables could be used."""
        return self.entries.get(key) or self.away.get(key)

    def _forget(self, entry: LedgerEntry) -> None:
        self.entries.pop(entry.key, None)
        self.away.pop(entry.key, None)
        self.refused.pop(entry.name, None)

    def clear(self, entry: LedgerEntry) -> None:
        """Remove what an entry has made obsolete. Of another recording that has no sound entry
        nothing is removed: it may be none of this one's states.
        """
        if entry.obsolete:
            for name in entry.obsolete:
                if (key := key_in(name)) == entry.key or key in self._replaced:
                    self._remove(name)
            self._change(replace(entry, obsolete=()))

    def _remove(self, name: str) -> None:
        """Remove a file; what no program of ours has put there may stay: it does not count."""
        try:
            self.files.remove(name)
        except FleetError as error:
            if not is_of_file(error):
                raise

    def drop_lost(self, *, check: bool = False) -> list[LedgerEntry]:
        """Let no entry count whose files can't be used; return those entries. `check`: read all.

        An entry is removed if its files are changed or surely gone. Others may be back, as those
        on a disk that is away: such an entry stays and is named in `refused`.
        """
        lost = self._surely_lost()
        lost |= self._changed() if check else {}
        for entry, reason in lost.items():
            if all(map(self._is_there_or_gone, entry.files)):
                self.files.remove(entry.name)
                del self.entries[entry.key]
            else:
                recording = next(iter(entry.sources), entry.key)
                self.refuse(entry, _AWAY.filled(reason=reason, recording=recording))
        return [*lost]

    def _is_there_or_gone(self, name: str) -> bool:
        """Return whether a file can be used, or its folder is there without it."""
        if name in self.sizes:
            return True
        folder, _, own = name.rpartition("/")
        above, _, last = folder.rpartition("/")
        try:
            return last in self.files.names(above) and own not in self.files.names(folder)
        except FleetError as error:
            if not is_of_file(error):
                raise
            return False

    def refuse_lost(self) -> None:
        """Let no entry count whose files can't be used, and change nothing: `refused` names it."""
        for entry, reason in self._surely_lost().items():
            self.refuse(entry, reason)

    def refuse(self, entry: LedgerEntry, reason: Text) -> None:
        """Let an entry not count, for this reason."""
        self.refused[entry.name] = reason
        self.away[entry.key] = self.entries.pop(entry.key)

    def _surely_lost(self) -> dict[LedgerEntry, Text]:
        lost = self._lost()
        if lost:  # or replaced by another run, while they were looked for
            self.refresh()
            lost = self._lost()
        return lost

    def _lost(self) -> dict[LedgerEntry, Text]:
        every = self.entries.values()
        sizes = self.files.sizes((name for entry in every for name in entry.files), LARGEST_TABLE)
        self.sizes = {name: size for name, size in sizes.items() if isinstance(size, int)}
        lost = {}
        for entry in every:
            reasons = (sizes[name] for name in entry.files if name not in self.sizes)
            if isinstance(reason := next(reasons, None), Text):
                lost[entry] = reason
                continue
            for name, stamp in entry.tables.items():
                if self.sizes[name] != size_in(stamp):
                    lost[entry] = _CHANGED.filled(name=name)
        return lost

    def _changed(self) -> dict[LedgerEntry, Text]:
        """Return the entries with a file that has other bytes than were written."""
        changed = {}
        for entry in self.entries.values():
            for name, stamp in entry.tables.items():
                data = self.files.read(name, LARGEST_TABLE)
                if data is not None and stamp_of(len(data), sha256(data).hexdigest()) != stamp:
                    changed[entry] = _CHANGED.filled(name=name)
                    break
        return changed

    def note_source(self, key: str, url: str, stamp: str) -> None:
        """Note another place of a recording, so that it need not be read there again.

        `write_noted` writes it: a recording may have thousands of copies.
        """
        entry = self.entries[key]
        if stamp and entry.sources.get(shown(url)) != stamp:
            entry.sources[shown(url)] = stamp
            self._noted.add(key)

    def write_noted(self) -> None:
        """Write the entries with new places."""
        while self._noted:
            if (entry := self.entries.get(self._noted.pop())) is not None:
                self._change(entry)

    def _change(self, entry: LedgerEntry) -> None:
        """Write an entry that is there, unless another run has replaced it meanwhile."""
        if self.files.read(entry.name, LONGEST) is None:
            del self.entries[entry.key]
        else:
            self.entries[entry.key] = entry
            self._write(entry)

    def _write(self, entry: LedgerEntry) -> None:
        self.files.write(entry.name, entry.as_json())
        self._written.add(entry.name.removeprefix(f"{FOLDER}/"))


def begin(files: Store) -> Ledger:
    """Return the ledger of a dataset, a new one in an empty place."""
    if files.read(MARKER, LONGEST) is None:
        names = files.names("")
        if MARKER not in names:  # else another run has begun the dataset meanwhile
            if any(name not in (FOLDER, PARTS, *TABLES) for name in names):
                raise FleetError(shown(files.place), _OTHER_FILES)
            files.write(MARKER, json.dumps({"form": FORM, "tables": list(TABLES)}).encode())
    ledger = _opened(files)
    files.tidy()
    for entry in list(ledger.entries.values()):
        ledger.clear(entry)
    return ledger


def open_ledger(files: Store) -> Ledger:
    """Return the ledger of a dataset, to be read. Raises `FleetError` if there is none.

    An entry whose files can't be used does not count.
    """
    ledger = _opened(files)
    ledger.refuse_lost()
    return ledger


def _opened(files: Store) -> Ledger:
    marker = files.read(MARKER, LONGEST)
    if marker is None:
        raise FleetError(shown(files.place), _NO_DATASET)
    try:
        form = json_of(marker)["form"]
    except (ValueError, TypeError, KeyError):
        raise FleetError(shown(files.place), _NO_DATASET) from None
    if form != FORM:
        raise FleetError(shown(files.place), _LATER)
    return Ledger(files)
