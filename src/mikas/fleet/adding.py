"""Adding recordings to a dataset: which are new, who does the work, what then counts.

A file that is as it was when it was added is not read. Else its content decides: the same is
skipped; one that has grown, or was changed where it lies, replaces its earlier state; another
version of the catalog or of the program interprets it again. A killed run leaves nothing that
counts but what it had finished; the same command continues. Several runs may add to one dataset.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import partial
from hashlib import sha256
from uuid import uuid4

from mikas.catalog import Catalog
from mikas.errors import FleetError, MikasError, usage_error
from mikas.fleet.executors import Runner
from mikas.fleet.interpreting import Settings
from mikas.fleet.job import HEAD, Outcome, digest_of, work
from mikas.fleet.ledger import Entry, Ledger, begin
from mikas.fleet.places import FoundFile, as_local, as_path, is_url, recordings_in, shown
from mikas.fleet.stores import store
from mikas.fleet.tables import RESERVED
from mikas.i18n import Text


@dataclass(frozen=True, slots=True)
class BadFile:
    """A file that was passed over."""

    file: str
    reason: Text


@dataclass(slots=True)
class Added:
    """The files by what became of them. `replaced`: of those added, new states of known ones;
    `seconds`: of the recordings added; `damaged`: added, with so many places that can't be read.
    """

    added: int = 0
    replaced: int = 0
    skipped: int = 0
    seconds: float = 0.0
    bad: list[BadFile] = field(default_factory=list)
    damaged: list[tuple[str, int]] = field(default_factory=list)


@dataclass(frozen=True, slots=True)
class Plan:
    """The files to look at, and those that are as they were."""

    files: tuple[FoundFile, ...]
    skipped: int
    ledger: Ledger


def check_names(catalog: Catalog) -> None:
    """Raise `UsageError` if a channel has the name of another column."""
    for name in (*(each.name for each in catalog.parameters), *catalog.derived):
        if name.casefold() in RESERVED:
            raise usage_error(
                f"the catalog has a channel called {name}, which is a column of every dataset",
                f"в каталоге есть канал {name}, а так называется столбец любого набора",
            )


def plan(places: Iterable[str], dataset: str, settings: Settings) -> Plan:
    """Return what there is to do. Raises `FleetError`, `MissingExtra`, `UsageError`."""
    check_names(settings.catalog)
    found = {file.url: file for place in places for file in recordings_in(place)}
    ledger = begin(store(dataset))
    files = []
    known = {
        (url, stamp): entry for entry in ledger.entries.values() for url, stamp in
        entry.sources.items()
    }  # fmt: skip
    for file in found.values():
        entry = known.get((shown(file.url), file.stamp)) if file.stamp else None
        if entry is None or not entry.is_current(settings.version, settings.car):
            files.append(file)
    files.sort(key=lambda file: (file.bytes, file.url))  # an earlier state before the later one
    return Plan(tuple(files), len(found) - len(files), ledger)


def add(
    planned: Plan,
    dataset: str,
    settings: Settings,
    runner: Runner,
    on_file: Callable[[Outcome], None] = lambda _: None,
) -> Added:
    """Do it and close the runner; `on_file` is called after each file. Raises `FleetError`."""
    result = Added(skipped=planned.skipped)
    run = uuid4().hex
    lasting = dataset if is_url(dataset) else str(as_path(dataset))  # whatever a worker's folder
    job = partial(work, dataset=lasting, settings=settings, run=run)
    try:
        for outcome in runner.outcomes(job, planned.files):
            _take(outcome, planned.ledger, result)
            on_file(outcome)
    finally:
        runner.close()
        planned.ledger.files.clear(run)
    return result


def _take(outcome: Outcome, ledger: Ledger, result: Added) -> None:
    file, entry = outcome.file, outcome.entry
    if entry is None:
        reason = outcome.bad or Text("", "")
        if outcome.ends:
            raise FleetError(shown(ledger.files.place), reason)
        result.bad.append(BadFile(shown(file.url), reason))
        return
    if not outcome.is_new:
        result.skipped += 1
        ledger.entries.setdefault(entry.key, entry)  # of another run
        ledger.note_source(entry.key, file.url, file.stamp)
        return
    before = ledger.entries.get(entry.key)
    if before is not None and before.is_current(entry.version, entry.given):  # a copy, meanwhile
        result.skipped += 1
        ledger.note_source(entry.key, file.url, file.stamp)
        return
    if (longer := _longer(file, entry, ledger)) is not None:
        result.skipped += 1
        for name in entry.files:
            ledger.files.remove(name)
        ledger.note_source(longer.key, file.url, file.stamp)
        return
    older = list(_earlier(file, entry, outcome.opening, ledger))
    replaces = dict.fromkeys(key for it in older for key in (it.key, *it.replaces))
    sources: dict[str, str] = {}
    for each in (*older, *([before] if before else []), entry):
        sources |= each.sources
    kept = before.replaces if before else ()
    entry = replace(entry, replaces=(*kept, *replaces), sources=sources)
    ledger.commit(entry, older)
    result.added += 1
    result.replaced += bool(older or before)
    result.seconds += entry.seconds
    if entry.damaged:
        result.damaged.append((shown(file.url), entry.damaged))


def _earlier(file: FoundFile, entry: Entry, opening: bytes, ledger: Ledger) -> Iterator[Entry]:
    """Yield the entries of earlier states of this recording: its content begins with theirs, or it
    has the same beginning and lies where they lay.
    """
    for known in ledger.entries.values():
        if known.key == entry.key:
            continue
        if known.bytes < HEAD:
            is_begin = sha256(opening[: known.bytes]).hexdigest() == known.sha256
            if known.bytes < entry.bytes and is_begin:
                yield known
        elif known.head == entry.head and (
            shown(file.url) in known.sources
            or (known.bytes < entry.bytes and _begins(file.url, known))
        ):
            yield known


def _begins(url: str, known: Entry) -> bool:
    with suppress(OSError, MikasError), as_local(url) as path:
        return digest_of(path, known.bytes)[0] == known.sha256
    return False


def _longer(file: FoundFile, entry: Entry, ledger: Ledger) -> Entry | None:
    """Return the recording in the dataset that begins with this one's content."""
    for known in ledger.entries.values():
        if entry.key in known.replaces:
            return known
    for known in ledger.entries.values():
        near = known.head == entry.head and known.bytes > entry.bytes
        elsewhere = near and shown(file.url) not in known.sources
        if elsewhere and any(_begins(url, entry) for url in known.sources):
            return known
    return None
