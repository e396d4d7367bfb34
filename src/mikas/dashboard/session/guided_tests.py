"""The guided test that runs on the connection, and the kept results of each unit.

The sampling thread gives every sample to the running test. Its channels are sampled as fast as the
others while it runs; what the plan lacked is added, and taken away again at its end. A result is
kept in the state folder, and is a note in the recording that runs. Units with empty passports can't
be distinguished: results of such a unit are in memory only, until another unit answers.
"""

from __future__ import annotations

import threading
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

from mikas import unkept
from mikas.cleaning import clean_line
from mikas.client.limits import unit_file
from mikas.client.parameters.derived import number_of
from mikas.conditions.waiting import waiting_for
from mikas.dashboard.errors import Busy, NotFound
from mikas.dashboard.session.catalog_in_use import CatalogInUse
from mikas.dashboard.session.connection import Connection, SamplingPlanner
from mikas.dashboard.settings import PlanSettings, Settings
from mikas.errors import UsageError
from mikas.i18n import Text, joined
from mikas.recording.capture.notes import Kind, Note
from mikas.recording.recorder import Recorder
from mikas.sampling.events import Sampled, UnitFound
from mikas.saving import KeptFile
from mikas.virtual import VIRTUAL_PASSPORT

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from mikas.catalog import Catalog
    from mikas.guided.engine import Progress, TestEngine
    from mikas.guided.loading import LoadedTests
    from mikas.guided.result import TestResult

_MOST_KEPT: Final = 50  # results of a unit
_MOST_BYTES: Final = 4 << 20
_LONGEST_ID: Final = 80
_RUNNING: Final = Text("a test is running", "проверка уже идёт")
_UNKEPT: Final = Text(
    "Results of guided tests can't be saved in {place} ({why}): they stay until this program ends; "
    "a recording that runs has them, too.",
    "Результаты проверок не сохраняются в {place} ({why}): они останутся до завершения программы и "
    "в идущей записи.",
)
_NOT_RUNNING: Final = Text("no test is running", "проверка не идёт")


@dataclass(frozen=True, slots=True)
class KeptResult:
    """A result. `identity` names it; `in_report`: the user wants it there.

    `later`: by how many seconds the date was set when its times became dates; None: before this
    program began.
    """

    identity: str
    result: TestResult
    in_report: bool = False
    later: float | None = None

    def dated(self, later: float) -> KeptResult:
        """Return the result with its dates, now that the date was set by `later` in all."""
        if self.later is None or self.later == later:
            return self
        return replace(self, result=self.result.moved(later - self.later), later=later)


@dataclass(slots=True)
class _Run:
    engine: TestEngine
    before: PlanSettings | None  # the plan to go back to
    during: PlanSettings | None
    identity: str = ""  # of the result


@dataclass(eq=False)
class GuidedTests:
    """Runs one test at a time. Any thread may call."""

    _settings: Settings
    _connection: Connection
    _plan: SamplingPlanner
    _recorder: Recorder
    _catalogs: CatalogInUse
    _formula_catalog: Callable[[], Catalog]

    def __post_init__(self) -> None:
        self._lock = threading.RLock()
        self._saving = threading.Lock()  # before `_lock`
        self._run: _Run | None = None
        self._kept: dict[Path, list[KeptResult]] = {}

    def available(self) -> LoadedTests:
        """Return all tests; reads the user's files again."""
        from mikas.guided.loading import load

        return load(self._catalogs.catalog, self._settings.tests, self._formula_catalog())

    def start(self, name: str) -> None:
        """Start a test; a finished one is put away. Raises `NotFound`, `Busy`, and `UsageError` if
        no instrument gives what it needs.
        """
        from mikas.guided.engine import TestEngine

        test = self.available().tests.get(name)
        if test is None:
            raise NotFound(name=name)
        catalog = self._formula_catalog()
        if (waits := waiting_for(test.beside, catalog)) is not None:
            raise UsageError(problem=joined(": ", [test.title, waits]))
        with self._lock:
            if self._run is not None and self._run.engine.result is None:
                raise Busy(problem=_RUNNING)
            self._run = run = _Run(TestEngine(test, catalog), None, None)
            before = self._plan.request
            every = before.every | dict.fromkeys(test.channels, 1)
            most = max((step.rate for step in test.steps), default=0)
            rate = before.rate if before.rate is None or before.rate > most else None
            if (every, rate) != (before.every, before.rate):
                run.before, run.during = before, replace(before, every=every, rate=rate)
                self._plan.sample(run.during)

    @property
    def progress(self) -> tuple[TestEngine, Progress, KeptResult | None] | None:
        """The running or finished test, its state now and its result; None without one."""
        now = self._connection.now()
        with self._lock:
            if (run := self._run) is None:
                return None
            kept = next((it for it in self.results if it.identity == run.identity), None)
            return run.engine, run.engine.progress(now), kept

    def skip(self) -> None:
        """Skip the present step. Raises `Busy` if no test runs."""
        with self._lock:
            run = self._run
            if run is None or run.engine.result is not None:
                raise Busy(problem=_NOT_RUNNING)
            run.engine.skip()
            self._check(run)

    def cancel(self) -> None:
        """End the test without a result, or put a finished one away."""
        with self._lock:
            if (run := self._run) is not None:
                self._restore_plan(run)
            self._run = None

    def add_event(self, event: Sampled | UnitFound) -> None:
        """Take a sample, or end the test because another unit answers; in the sampling thread."""
        if isinstance(event, UnitFound):
            if event.another:
                self.cancel()
                with self._lock:
                    if not any(self._unit[1]):
                        self._kept.pop(self.file.path, None)
            return
        if self._run is None:
            return
        values = {name: number_of(reading) for name, reading in event.fresh.items()}
        values |= {name: reading.value for name, reading in event.instruments.items()}
        with self._lock:
            run = self._run
            if run is not None and run.engine.result is None:
                run.engine.add_row(event.time, values)
                self._check(run)

    @property
    def results(self) -> list[KeptResult]:
        """The results of this unit, the latest first."""
        file = self.file
        with self._lock:
            if file.path not in self._kept:
                self._kept[file.path] = (file.load() or []) if self._is_saved else []
            later = self._connection.later
            return [it.dated(later) for it in self._kept[file.path]]

    def follow_date(self) -> None:
        """Save the results of this program again with their dates: the computer's date was set."""
        later = self._connection.later
        with self._lock:
            for path, results in self._kept.items():
                dated = [it.dated(later) for it in results]
                if dated != results:
                    self._kept[path] = dated
                    if path.exists():
                        self._save_soon(self._file(path))

    def put_in_report(self, identity: str, *, wanted: bool) -> KeptResult:
        """Put a result into the live report, or take it out. Raises `NotFound`."""
        with self._lock:
            results = self.results
            for number, kept in enumerate(results):
                if kept.identity == identity:
                    results[number] = replace(kept, in_report=wanted)
                    self._keep(results)
                    return results[number]
        raise NotFound(name=identity)

    def _check(self, run: _Run) -> None:
        result = run.engine.result
        if result is None:
            return
        self._restore_plan(run)
        later = self._connection.later
        dated = result.moved(later)
        run.identity = f"{result.test}-{round(dated.ended * 1000)}"
        new = KeptResult(run.identity, dated, later=later)
        self._keep([new, *self.results][:_MOST_KEPT])
        with suppress(ValueError):  # too long a note, by a test with many long texts
            self._recorder.note(Note(Kind.TEST, result.ended, result.as_json()))

    def _restore_plan(self, run: _Run) -> None:
        """Go back to the plan before, unless another one was requested meanwhile."""
        now, during = self._plan.request, run.during
        if run.before is None or during is None:
            return
        if (now.every, now.rate, now.method) == (during.every, during.rate, during.method):
            self._plan.sample(run.before)
        run.before = run.during = None

    @property
    def _unit(self) -> tuple[int, tuple[str, ...]]:
        unit = self._connection.monitor.unit
        version = unit.version_code if unit and unit.version_code is not None else 0
        return version, unit.passport.pieces if unit and unit.passport else ()

    @property
    def _is_saved(self) -> bool:
        """Whether results of this unit are kept in a file."""
        pieces = self._unit[1]
        return any(pieces) and (self._settings.virtual_units or VIRTUAL_PASSPORT not in pieces)

    @property
    def file(self) -> KeptFile[list[KeptResult]]:
        """The file of this unit's results."""
        return self._file(unit_file(self._settings.in_state("tests"), *self._unit))

    def _file(self, path: Path) -> KeptFile[list[KeptResult]]:
        return KeptFile(path, _MOST_BYTES, _read)

    def _keep(self, results: list[KeptResult]) -> None:
        file = self.file
        self._kept[file.path] = results
        if self._is_saved:
            self._save_soon(file)

    def _save_soon(self, file: KeptFile[list[KeptResult]]) -> None:
        """Save the results, not in the sampling thread: the disk may take a second."""
        threading.Thread(target=self._save, args=(file,), name="mikas test result").start()

    def _save(self, file: KeptFile[list[KeptResult]]) -> None:
        """Save the present results; a thread that comes late does not bring older ones back."""
        with self._saving:
            with self._lock:
                results = self._kept[file.path]
            content = [
                {"id": it.identity, "in_report": it.in_report} | it.result.as_json()
                for it in results
            ]
            with unkept.saying_once(_UNKEPT, file.path.parent):
                file.save(content)


def _read(stored: object) -> list[KeptResult]:
    """Return the results in the file, without those that are none. Raises `TypeError`."""
    from mikas.guided.result import read

    if not isinstance(stored, list):
        raise TypeError("no list of results")
    kept = []
    for data in stored[:_MOST_KEPT]:
        result = read(data)
        if result is not None and isinstance(identity := data.get("id"), str):
            name = clean_line(identity, _LONGEST_ID)
            kept.append(KeptResult(name, result, data.get("in_report") is True))
    return kept
