"""Adding recordings to a dataset: which are new, who does the work, what then counts.

A file that is as it was when it was added is not read. Else its content decides: the same is
skipped; one that has grown, or was changed where it lies, replaces its earlier state; another
version of the catalog or of the program interprets it again. A killed run leaves nothing that
counts but what it had finished; the same command continues. Several runs may add to one dataset.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Final
from uuid import uuid4

from mikas.errors import FleetError, usage_error
from mikas.fleet.cars import plate_key
from mikas.fleet.entries import LedgerEntry
from mikas.fleet.executors import Runner
from mikas.fleet.growing import States
from mikas.fleet.interpreting import InterpretingSettings
from mikas.fleet.job import FileOutcome, work
from mikas.fleet.ledger import Ledger, begin
from mikas.fleet.places import FoundFile, as_path, is_of_file, is_url, recordings_in, shown
from mikas.fleet.stores import store
from mikas.fleet.tables import RESERVED
from mikas.i18n import Text

_LOST: Final = Text(
    "its tables are no longer in the dataset as they were written; it does not count until it is "
    "added again",
    "её таблиц в наборе больше нет, или они изменены; она не считается, пока её не добавят снова",
)


@dataclass(frozen=True, slots=True)
class BadFile:
    """A file that was passed over."""

    file: str
    reason: Text


@dataclass(slots=True)
class Added:
    """The files by what became of them. `replaced`: of those added, new states of known ones;
    `seconds`: of the recordings added; `damaged`: added, with so many places that can't be read;
    `remade`: added, as their tables were gone or changed.
    """

    added: int = 0
    replaced: int = 0
    skipped: int = 0
    seconds: float = 0.0
    bad: list[BadFile] = field(default_factory=list)
    damaged: list[tuple[str, int]] = field(default_factory=list)
    remade: list[str] = field(default_factory=list)


@dataclass(frozen=True, slots=True)
class AddingPlan:
    """The files to look at, the number of those that are as they were, and the entries that do not
    count any more, as their tables can't be used. `found`: all files, by place as shown.
    """

    files: tuple[FoundFile, ...]
    skipped: int
    ledger: Ledger
    found: Mapping[str, FoundFile]
    lost: tuple[LedgerEntry, ...] = ()


def plan(
    places: Iterable[str], dataset: str, settings: InterpretingSettings, *, check: bool = False
) -> AddingPlan:
    """Return what there is to do. `check`: read the tables that are there, whether they are as they
    were written. Raises `FleetError`, `MissingExtra`, `UsageError`."""
    for name in settings.catalog.channels:
        if name.casefold() in RESERVED:
            raise usage_error(
                f"the catalog has a channel called {name}, which is a column of every dataset",
                f"в каталоге есть канал {name}, а так называется столбец любого набора",
            )
    if settings.car and not plate_key(settings.car):
        raise usage_error(
            f"--car: “{settings.car}” has no letter and no digit",
            f"--car: в «{settings.car}» нет ни буквы, ни цифры",
        )
    found = {file.url: file for place in places for file in recordings_in(place)}
    ledger = begin(store(dataset))
    lost = ledger.drop_lost(check=check)
    files = []
    version = settings.version
    known = {
        (url, stamp): entry for entry in ledger.entries.values() for url, stamp in
        entry.sources.items()
    }  # fmt: skip
    for file in found.values():
        entry = known.get((shown(file.url), file.stamp)) if file.stamp else None
        if entry is None or not entry.is_current(version, settings.car):
            files.append(file)
    files.sort(key=lambda file: (file.bytes, file.url))  # an earlier state before the later one
    by_place = {shown(url): file for url, file in found.items()}
    return AddingPlan(tuple(files), len(found) - len(files), ledger, by_place, tuple(lost))


def add(
    planned: AddingPlan,
    dataset: str,
    settings: InterpretingSettings,
    runner: Runner,
    on_file: Callable[[FileOutcome], None] = lambda _: None,
) -> Added:
    """Do it and close the runner; `on_file` is called after each file. Raises `FleetError`."""
    result = Added(skipped=planned.skipped)
    run = uuid4().hex
    lasting = dataset if is_url(dataset) else str(as_path(dataset))  # whatever a worker's folder
    files_of: dict[str, Sequence[FoundFile]] = {settings.car: planned.files}  # by the given car
    states = States(planned.ledger, planned.found, planned.files)
    redo = False  # whatever the dataset has
    try:
        states.settle()
        while files_of:
            car, files = files_of.popitem()
            job = partial(
                work, dataset=lasting, settings=replace(settings, car=car), run=run,
                redo=redo,
            )  # fmt: skip
            again: dict[str, list[FoundFile]] = defaultdict(list)
            for outcome in runner.outcomes(job, files):
                try:
                    known = _take(outcome, planned.ledger, states, result)
                except FleetError as error:
                    if not is_of_file(error):
                        raise
                    result.bad.append(BadFile(shown(outcome.file.url), error.problem))
                    known = None
                if known is not None:
                    again[known].append(outcome.file)
                else:
                    on_file(outcome)
            files_of |= again
            redo = True
        if result.added:
            planned.ledger.refresh()
            states.settle()
        for entry in planned.lost:
            if entry.key in planned.ledger.entries:
                result.remade.append(next(iter(entry.sources), entry.key))
            elif entry.name not in planned.ledger.refused:
                result.bad.append(BadFile(next(iter(entry.sources), entry.key), _LOST))
        for name, reason in planned.ledger.refused.items():
            result.bad.append(BadFile(f"{shown(lasting).rstrip('/')}/{name}", reason))
    finally:
        runner.close()
        planned.ledger.write_noted()
        planned.ledger.files.clear(run)
    return result


def _take(outcome: FileOutcome, ledger: Ledger, states: States, result: Added) -> str | None:
    """Let a recording count. Return the car that was given for an earlier state of it, if its
    tables are to be made again for that car, or at all.
    """
    file, entry = outcome.file, outcome.entry
    if entry is None:
        reason = outcome.bad or Text("", "")
        if outcome.ends:
            raise FleetError(shown(ledger.files.place), reason)
        result.bad.append(BadFile(shown(file.url), reason))
        return None
    if not outcome.is_new and entry.name in ledger.refused:
        return entry.given  # of this recording, but a stranger's, or its tables can't be used
    if not outcome.is_new:
        ledger.entries.setdefault(entry.key, entry)  # of another run
        _skip(file, entry, ledger, result)
        return None
    before = ledger.entries.get(entry.key)
    if before is not None and before.is_current(entry.version, entry.given):
        ledger.refresh()  # a copy was read meanwhile, or another run has replaced it
        if (before := ledger.entries.get(entry.key)) is not None:
            _remove_tables(entry, ledger, but=before.files)
            _skip(file, before, ledger, result)
            return None
    if (whole := states.longer(outcome)) is not None:
        _remove_tables(entry, ledger)
        _skip(file, whole, ledger, result)
        return None
    older = list(states.earlier(outcome))
    given = "" if entry.given else next((it.given for it, _ in older if it.given), "")
    if given:
        _remove_tables(entry, ledger)
        return given
    former = ledger.known(entry.key)
    replaces = [*(former.replaces if former else ())]
    sources: dict[str, str] = {}
    for each, is_beginning in older:
        sources |= each.sources
        replaces += (each.key, *each.replaces) if is_beginning else ()
    sources |= (former.sources if former else {}) | entry.sources
    entry = replace(entry, replaces=tuple(dict.fromkeys(replaces)), sources=sources)
    ledger.commit(entry, [each for each, _ in older])
    states.note(entry)
    result.added += 1
    result.replaced += bool(older or before)
    result.seconds += entry.seconds
    if entry.damaged:
        result.damaged.append((shown(file.url), entry.damaged))
    return None


def _skip(file: FoundFile, entry: LedgerEntry, ledger: Ledger, result: Added) -> None:
    result.skipped += 1
    ledger.note_source(entry.key, file.url, file.stamp)


def _remove_tables(entry: LedgerEntry, ledger: Ledger, but: Sequence[str] = ()) -> None:
    """Remove the tables of an entry that does not come to count, `but` those of another one."""
    for name in entry.files:
        if name not in but:
            ledger.files.remove(name)
