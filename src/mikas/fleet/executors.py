"""Where the work on the files is done: in processes of this computer, or by a Dask cluster.

A worker that dies takes only its own file with it; a process of this computer is tried once more,
alone.
"""

from __future__ import annotations

import logging
import os
import re
import signal
import threading
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, CancelledError, Future, wait
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from pickle import PicklingError
from typing import TYPE_CHECKING, Final, TypeAlias

from mikas.cleaning import public_url
from mikas.errors import FleetError, library, refusal_of, usage_error
from mikas.fleet.job import FileOutcome
from mikas.fleet.places import FoundFile
from mikas.i18n import Text

if TYPE_CHECKING:
    from multiprocessing.connection import Connection
    from multiprocessing.process import BaseProcess

Work: TypeAlias = Callable[[FoundFile], FileOutcome]
_EACH: Final = 2  # jobs under way for each worker of a cluster
_LAST: Final = 1.0  # s for a worker to end by itself
_PORT: Final = 8786  # of a Dask scheduler, if none is named
_LOOK: Final = 0.5  # s; a wait without an end can't be interrupted everywhere
_DIED: Final = Text(
    "the process that read it was ended by the system, twice (too little memory?)",
    "процесс, читавший файл, дважды был завершён системой (не хватило памяти?)",
)
_UNREACHABLE: Final = Text(
    "no Dask scheduler answers there; start one with `dask scheduler`, and on each computer "
    "`dask worker {host}`",
    "планировщик Dask там не отвечает; запустите его командой `dask scheduler`, а на каждом "
    "компьютере `dask worker {host}`",
)
_NO_WORKERS: Final = Text(
    "the Dask scheduler has no workers; start them with `dask worker {host}`",
    "у планировщика Dask нет исполнителей; запустите их командой `dask worker {host}`",
)
_LOST: Final = Text(
    "the Dask scheduler is gone; what was finished is in the dataset, and the same command "
    "continues",
    "планировщик Dask пропал; всё законченное уже в наборе, та же команда продолжит работу",
)
_UNFIT: Final = Text(
    "the Dask scheduler or a worker can't do the work; is the same mikas installed there? "
    'pip install "mikas[dask]"',
    "планировщик Dask или исполнитель не может выполнить работу; стоит ли там та же версия mikas? "
    'pip install "mikas[dask]"',
)


class Runner(ABC):
    """Does the jobs; `close` ends it, at once unless all is done."""

    @abstractmethod
    def close(self) -> None:
        """End; a job under way is dropped."""

    @abstractmethod
    def outcomes(self, work: Work, files: Iterable[FoundFile]) -> Iterator[FileOutcome]:
        """Yield the outcomes as they come."""


@dataclass(slots=True)
class _Worker:
    """A process, and our ends of its pipes: jobs and answers; what it ends with."""

    process: BaseProcess
    pipe: Connection
    lifeline: Connection

    def end(self) -> None:
        self.pipe.close()
        self.lifeline.close()
        self.process.join(_LAST)
        if self.process.is_alive():
            self.process.kill()
            self.process.join()


class ProcessRunner(Runner):
    """Up to `workers` new processes (spawn). They end with this one, however it ends.

    Nothing of it needs a thread of this process: where the system allows no further one, or no
    further process, the work goes on with those that there are.
    """

    def __init__(self, workers: int) -> None:
        self._limit = workers
        self._idle: list[_Worker] = []
        self._busy: dict[Connection, tuple[_Worker, FoundFile]] = {}

    def close(self) -> None:
        for worker in [*self._idle, *(worker for worker, _ in self._busy.values())]:
            worker.end()
        self._idle.clear()
        self._busy.clear()

    def outcomes(self, work: Work, files: Iterable[FoundFile]) -> Iterator[FileOutcome]:
        """Yield the outcomes as they come. Raise `OSError` if no process can be started."""
        died: list[FoundFile] = []
        for file in files:
            while not self._give(work, file):
                yield from self._some(died)
        while self._busy:
            yield from self._some(died)
        for file in died:  # alone, with all of the memory
            while self._idle:
                self._idle.pop().end()
            self._give(work, file)
            again: list[FoundFile] = []
            while self._busy:
                yield from self._some(again)
            yield from (FileOutcome(each, bad=_DIED) for each in again)

    def _give(self, work: Work, file: FoundFile) -> bool:
        """Give a worker a job; return False if all have one."""
        if not self._idle:
            if len(self._busy) >= self._limit:
                return False
            try:
                self._idle.append(_started())
            except (OSError, RuntimeError, MemoryError) as error:
                if not self._busy or refusal_of(error) is None:
                    raise
                self._limit = len(self._busy)
                return False
        worker = self._idle.pop()
        with suppress(OSError):  # it has died: its end is read as that of its job
            worker.pipe.send((work, file))
        self._busy[worker.pipe] = worker, file
        return True

    def _some(self, died: list[FoundFile]) -> Iterator[FileOutcome]:
        """Yield what has come; add the files whose worker has died to `died`."""
        from multiprocessing.connection import wait

        # A wait without an end can't be interrupted everywhere.
        ready = wait([*self._busy], timeout=_LOOK)
        for pipe in [pipe for pipe in self._busy if pipe in ready]:
            worker, file = self._busy.pop(pipe)
            try:
                outcome, error = worker.pipe.recv()
            except (EOFError, OSError):
                worker.end()
                died.append(file)
                continue
            self._idle.append(worker)
            if error is None:
                yield outcome
            elif (refusal := refusal_of(error)) is not None:
                yield FileOutcome(file, bad=refusal)  # as for an answer that has no room
            else:
                raise error


def _started() -> _Worker:
    from multiprocessing import get_context

    spawn = get_context("spawn")
    near, far = spawn.Pipe()
    far_end, lifeline = spawn.Pipe(duplex=False)
    try:
        process = spawn.Process(target=serve_jobs, args=(far, far_end), daemon=True)
        with _somewhere():
            process.start()
    except BaseException:
        near.close()
        lifeline.close()
        raise
    finally:
        far.close()
        far_end.close()
    return _Worker(process, near, lifeline)


@contextmanager
def _somewhere() -> Iterator[None]:
    """Stand in a folder that is there: a new process begins in that of this one."""
    try:
        Path.cwd()
    except FileNotFoundError:
        before = os.open(".", os.O_RDONLY)
        os.chdir("/")
        try:
            yield
        finally:
            os.fchdir(before)
            os.close(before)
    else:
        yield


def serve_jobs(pipe: Connection, lifeline: Connection) -> None:
    """Do the jobs that come by `pipe`, until its other end is closed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is the parent's
    with suppress(RuntimeError):  # no further thread is allowed: it ends with its job
        threading.Thread(target=_end_with, args=(lifeline,), daemon=True).start()
    with suppress(EOFError, OSError):
        while True:
            work, file = pipe.recv()
            answer = _answer(work, file)
            try:
                pipe.send(answer)
            except (TypeError, AttributeError, PicklingError):
                pipe.send((None, RuntimeError(f"{answer[1]!r}")))


def _answer(work: Work, file: FoundFile) -> tuple[FileOutcome | None, BaseException | None]:
    try:
        return work(file), None
    except Exception as error:  # any: the parent raises it, or says it in words
        return None, error


def _end_with(lifeline: Connection) -> None:
    with suppress(EOFError, OSError):
        lifeline.recv_bytes()
    os._exit(1)


class DaskRunner(Runner):
    """The workers of a Dask cluster; `place`: of its scheduler, `dask://host` or `dask://host:port`."""

    def __init__(self, place: str, timeout: float = 10.0) -> None:
        dask = library("distributed", feature="Dask", extra="dask")
        for name in ("distributed", *logging.root.manager.loggerDict):
            if name.split(".")[0] == "distributed":  # each has a level of its own
                logging.getLogger(name).setLevel(logging.CRITICAL)
        self._place = place
        host = place.removeprefix("dask://")
        if not re.search(r":\w+$", host):
            host = f"{host}:{_PORT}"
        try:
            self._client = dask.Client(f"tcp://{host}", timeout=timeout, set_as_default=False)
        except (OSError, ValueError, TimeoutError) as error:
            unreachable = FleetError(place, _UNREACHABLE.filled(host=host))
            raise unreachable.caused_by(error) from error
        threads = sum(self._client.nthreads().values())
        if not threads:
            self.close()
            raise FleetError(place, _NO_WORKERS.filled(host=host))
        self._window = threads * _EACH
        self._executor = self._client.get_executor(pure=False)

    def close(self) -> None:
        with suppress(Exception):  # the scheduler may be gone
            self._client.close(timeout=2)

    def outcomes(self, work: Work, files: Iterable[FoundFile]) -> Iterator[FileOutcome]:
        """Yield the outcomes as they come. Raise `FleetError` if the scheduler is lost."""
        waiting: dict[Future[FileOutcome], FoundFile] = {}
        for file in files:
            waiting[self._executor.submit(work, file)] = file
            while len(waiting) >= self._window:
                yield from self._some(waiting)
        while waiting:
            yield from self._some(waiting)

    def _some(self, waiting: dict[Future[FileOutcome], FoundFile]) -> Iterator[FileOutcome]:
        done, _ = wait(waiting, timeout=_LOOK, return_when=FIRST_COMPLETED)
        for future in done:
            file = waiting.pop(future)
            error = CancelledError() if future.cancelled() else future.exception()
            yield future.result() if error is None else self._failed(file, error)

    def _failed(self, file: FoundFile, error: BaseException) -> FileOutcome:
        kind = type(error).__name__
        if kind == "KilledWorker":
            return FileOutcome(file, bad=_DIED)
        is_lost = isinstance(error, OSError | CancelledError) or "Cancelled" in kind
        lost = FleetError(self._place, _LOST if is_lost else _UNFIT)
        raise lost.caused_by(error) from error


def runner_of(executor: str, workers: int) -> Runner:
    """Return the runner that `--executor` names. Raises `UsageError`."""
    if executor == "processes":
        return ProcessRunner(workers)
    if executor.startswith("dask://") and len(executor) > len("dask://"):
        return DaskRunner(executor)
    public = public_url(executor)
    raise usage_error(
        f"There is no executor “{public}”; there is processes, and dask://HOST[:PORT]",
        f"Исполнителя «{public}» нет; есть processes и dask://HOST[:PORT]",
    )
