"""The ledger of a dataset: for each recording its content, what interpreted it, and its files.

    DATASET/mikas-fleet.json      that this is a dataset, and of which form
    DATASET/_ledger/KEY.json      one entry for each recording; KEY: of its content
    DATASET/samples/car=…/day=…/KEY-VERSION.parquet      and the other tables

A file of a table counts once an entry names it. So an entry, written at once, makes all files of a
recording count together, and what a killed program has left never does. An entry that replaces
others names their files and entries as `obsolete`: from then on they do not count, and are removed,
by the next program if this one is killed.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterable
from dataclasses import asdict, dataclass, field, replace
from typing import Any, Final

from mikas.cleaning import clean_json
from mikas.errors import FleetError
from mikas.fleet.places import PARTS, shown
from mikas.fleet.stores import Store
from mikas.fleet.tables import TABLES
from mikas.i18n import Text

MARKER: Final = "mikas-fleet.json"
FOLDER: Final = "_ledger"
FORM: Final = 1
_DATA: Final = re.compile(
    rf"(?:{'|'.join(TABLES)})/car=[^/\\]+/day=[^/\\]+/[0-9a-f]+-[0-9a-f]+\.parquet"
)
_ENTRY: Final = re.compile(rf"{FOLDER}/[0-9a-f]+\.json")
_KEY: Final = re.compile("[0-9a-f]{32}")
_NO_DATASET: Final = Text(
    "this is no dataset of recordings (it has no {marker}); `mikas fleet add FOLDER --to DATASET` "
    "makes one",
    "это не набор записей (в нём нет {marker}); его создаёт `mikas fleet add ПАПКА --to НАБОР`",
).filled(marker=MARKER)
_OTHER_FILES: Final = Text(
    "this folder has other files in it; name a new or an empty folder for the dataset",
    "в этой папке лежат другие файлы; назовите для набора новую или пустую папку",
)
_LATER: Final = Text(
    "this dataset was made by a later version of mikas; update this one",
    "этот набор создан более новой версией mikas; обновите эту",
)


@dataclass(frozen=True, slots=True)
class LedgerEntry:
    """One recording. `heads`: digests of its beginning; `version`: of what interpreted it; `given`:
    the car given for it; `sources`: where it was found, each with its stamp then; `replaces`: its
    beginnings, which count no more, whoever writes them.
    """

    key: str
    sha256: str
    bytes: int
    heads: tuple[str, ...]
    version: str
    given: str = ""
    car: str | None = None
    drives: int = 0
    rows: int = 0
    seconds: float = 0.0
    damaged: int = 0
    files: tuple[str, ...] = ()
    sources: dict[str, str] = field(default_factory=dict)
    replaces: tuple[str, ...] = ()
    obsolete: tuple[str, ...] = ()

    @property
    def name(self) -> str:
        """The entry's own name in the dataset."""
        return f"{FOLDER}/{self.key}.json"

    def is_current(self, version: str, given: str) -> bool:
        """Return whether it needs no new interpretation."""
        return self.version == version and given in ("", self.given)


def read_entry(data: bytes) -> LedgerEntry | None:
    """Return an entry; None for a damaged one: its recording is added again."""
    try:
        value = clean_json(json.loads(data))
        known = {name: value[name] for name in LedgerEntry.__dataclass_fields__ if name in value}
        for name in ("heads", "files", "replaces", "obsolete"):
            known[name] = tuple(map(str, known.get(name, ())))
        entry = LedgerEntry(**known)
    except (ValueError, TypeError, RecursionError):
        return None
    return entry if _is_sound(entry) else None


def _is_sound(entry: LedgerEntry) -> bool:
    """Return whether its names are those of a dataset: they are read and removed."""
    gone = (_DATA.fullmatch(name) or _ENTRY.fullmatch(name) for name in entry.obsolete)
    if not isinstance(entry.sources, dict):
        return False
    texts: tuple[Any, ...] = (entry.key, entry.sha256, entry.version, entry.given)
    return (
        all(isinstance(text, str) for text in (*texts, *entry.sources.values()))
        and bool(_KEY.fullmatch(entry.key))
        and entry.key not in entry.replaces
        and isinstance(entry.bytes, int)
        and all(map(_DATA.fullmatch, entry.files))
        and all(gone)
    )


class Ledger:
    """The entries of a dataset, all in memory. Raises `FleetError`."""

    def __init__(self, files: Store) -> None:
        self.files = files
        self.entries: dict[str, LedgerEntry] = {}
        self.refresh()

    def refresh(self) -> None:
        """Read the entries again: other runs may have changed them."""
        read = map(read_entry, self.files.contents(FOLDER).values())
        found = {entry.key: entry for entry in read if entry is not None}
        gone = {name for entry in found.values() for name in entry.obsolete}
        # Another run may write an entry back, with a source of it, that was just replaced.
        gone |= {f"{FOLDER}/{key}.json" for entry in found.values() for key in entry.replaces}
        self.entries = {key: entry for key, entry in found.items() if entry.name not in gone}

    def commit(self, entry: LedgerEntry, older: Iterable[LedgerEntry] = ()) -> None:
        """Let an entry count, and its former self and `older` ones no more."""
        gone: list[str] = []
        before = self.entries.get(entry.key)
        for each in (*([before] if before else []), *older):
            gone += [name for name in each.files if name not in entry.files]
            gone += [each.name] if each.key != entry.key else []
        entry = replace(entry, obsolete=tuple(gone))
        self._write(entry)
        for each in older:
            self.entries.pop(each.key, None)
        self.entries[entry.key] = entry
        self.clear(entry)

    def clear(self, entry: LedgerEntry) -> None:
        """Remove what an entry has made obsolete."""
        if entry.obsolete:
            for name in entry.obsolete:
                self.files.remove(name)
            self._change(replace(entry, obsolete=()))

    def drop_lost(self) -> list[LedgerEntry]:
        """Let no entry count whose files are gone; return those entries."""
        lost = self._lost()
        if lost:  # or replaced by another run, while they were looked for
            self.refresh()
            lost = self._lost()
        for entry in lost:
            self.files.remove(entry.name)
            del self.entries[entry.key]
        return lost

    def _lost(self) -> list[LedgerEntry]:
        every = self.entries.values()
        gone = self.files.missing(name for entry in every for name in entry.files)
        return [entry for entry in every if not gone.isdisjoint(entry.files)]

    def note_source(self, key: str, url: str, stamp: str) -> None:
        """Note another place of a recording, so that it need not be read there again."""
        entry = self.entries[key]
        if stamp and entry.sources.get(shown(url)) != stamp:
            sources = {**entry.sources, shown(url): stamp}
            self._change(replace(entry, sources=sources))

    def _change(self, entry: LedgerEntry) -> None:
        """Write an entry that is there, unless another run has replaced it meanwhile."""
        if self.files.read(entry.name) is None:
            del self.entries[entry.key]
        else:
            self.entries[entry.key] = entry
            self._write(entry)

    def _write(self, entry: LedgerEntry) -> None:
        text = json.dumps(asdict(entry), ensure_ascii=False, indent=1)
        self.files.write(entry.name, text.encode())


def begin(files: Store) -> Ledger:
    """Return the ledger of a dataset, a new one in an empty place."""
    if files.read(MARKER) is None:
        names = files.names("")
        if MARKER not in names:  # else another run has begun the dataset meanwhile
            if any(name not in (FOLDER, PARTS, *TABLES) for name in names):
                raise FleetError(shown(files.place), _OTHER_FILES)
            files.write(MARKER, json.dumps({"form": FORM, "tables": list(TABLES)}).encode())
    ledger = open_ledger(files)
    files.tidy()
    for entry in list(ledger.entries.values()):
        ledger.clear(entry)
    return ledger


def open_ledger(files: Store) -> Ledger:
    """Return the ledger of a dataset. Raises `FleetError` if there is none."""
    marker = files.read(MARKER)
    if marker is None:
        raise FleetError(shown(files.place), _NO_DATASET)
    try:
        form = json.loads(marker)["form"]
    except (ValueError, TypeError, KeyError, RecursionError):
        raise FleetError(shown(files.place), _NO_DATASET) from None
    if form != FORM:
        raise FleetError(shown(files.place), _LATER)
    return Ledger(files)
