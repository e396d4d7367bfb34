"""Where the work on the files is done: in processes of this computer, or by a Dask cluster.

Both are executors of `concurrent.futures`; a few more jobs than there are workers are under way at
a time. A worker that dies takes only its own file with it, which is tried once more, alone.
"""

from __future__ import annotations

import logging
import os
import re
import signal
import threading
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, CancelledError, Executor, Future, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import suppress
from typing import TYPE_CHECKING, Final, TypeAlias

from mikas.cleaning import public_url
from mikas.errors import FleetError, library, refusal_of, usage_error
from mikas.fleet.job import FileOutcome
from mikas.fleet.places import FoundFile
from mikas.i18n import Text

if TYPE_CHECKING:
    from multiprocessing.connection import Connection

Work: TypeAlias = Callable[[FoundFile], FileOutcome]
_EACH: Final = 2  # jobs under way for each worker
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

    window: int
    _executor: Executor

    @abstractmethod
    def close(self) -> None:
        """End; a job under way is dropped."""

    @abstractmethod
    def failed(
        self, work: Work, files: list[FoundFile], error: BaseException
    ) -> Iterator[FileOutcome]:
        """Yield the outcomes of jobs that failed by `error`; raise it if all would."""

    def outcomes(self, work: Work, files: Iterable[FoundFile]) -> Iterator[FileOutcome]:
        """Yield the outcomes as they come."""
        waiting: dict[Future[FileOutcome], FoundFile] = {}
        for file in files:
            waiting[self._executor.submit(work, file)] = file
            while len(waiting) >= self.window:
                yield from self._some(work, waiting)
        while waiting:
            yield from self._some(work, waiting)

    def _some(
        self, work: Work, waiting: dict[Future[FileOutcome], FoundFile]
    ) -> Iterator[FileOutcome]:
        done, _ = wait(waiting, timeout=_LOOK, return_when=FIRST_COMPLETED)
        for future in done:
            file = waiting.pop(future, None)
            if file is None:  # one of the failed
                continue
            error = None if future.cancelled() else future.exception()
            if error is None and not future.cancelled():
                yield future.result()
                continue
            files = [file]
            if isinstance(error, BrokenProcessPool):
                files += waiting.values()
                waiting.clear()
            yield from self.failed(work, files, error or CancelledError())


class ProcessRunner(Runner):
    """`workers` new processes (spawn). They end with this one, however it ends."""

    def __init__(self, workers: int) -> None:
        self._workers = workers
        self.window = workers * _EACH
        self._executor, self._lifeline = self._start(workers)

    def close(self) -> None:
        self._lifeline.close()
        self._executor.shutdown(wait=True, cancel_futures=True)

    def failed(
        self, work: Work, files: list[FoundFile], error: BaseException
    ) -> Iterator[FileOutcome]:
        """A worker has died, and which of the files was the cause is not known: each alone."""
        if (refusal := refusal_of(error)) is not None and len(files) == 1:
            yield FileOutcome(files[0], bad=refusal)  # as for an answer that has no room
            return
        if not isinstance(error, BrokenProcessPool):
            raise error
        for file in files:
            self.close()
            self._executor, self._lifeline = self._start(1)
            future = self._executor.submit(work, file)
            try:
                while not future.done():
                    wait([future], timeout=_LOOK)
                yield future.result()
            except BrokenProcessPool:
                yield FileOutcome(file, bad=_DIED)
        self.close()
        self._executor, self._lifeline = self._start(self._workers)

    def _start(self, workers: int) -> tuple[Executor, Connection]:
        from concurrent.futures import ProcessPoolExecutor
        from multiprocessing import get_context

        spawn = get_context("spawn")
        far, near = spawn.Pipe(duplex=False)
        pool = ProcessPoolExecutor(workers, spawn, initializer=begin_worker, initargs=(far,))
        return pool, near


def begin_worker(lifeline: Connection) -> None:
    """Prepare a worker: Ctrl-C is its parent's, with which it ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        threading.Thread(target=_end_with, args=(lifeline,), daemon=True).start()
    except RuntimeError:  # no further thread is allowed; the pool would print a traceback
        os._exit(1)


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
            raise FleetError(place, _UNREACHABLE.filled(host=host)) from error
        threads = sum(self._client.nthreads().values())
        if not threads:
            self.close()
            raise FleetError(place, _NO_WORKERS.filled(host=host))
        self.window = threads * _EACH
        self._executor = self._client.get_executor(pure=False)

    def close(self) -> None:
        with suppress(Exception):  # the scheduler may be gone
            self._client.close(timeout=2)

    def failed(
        self, _: Work, files: list[FoundFile], error: BaseException
    ) -> Iterator[FileOutcome]:
        kind = type(error).__name__
        if kind == "KilledWorker":
            for file in files:
                yield FileOutcome(file, bad=_DIED)
            return
        is_lost = isinstance(error, OSError | CancelledError) or "Cancelled" in kind
        raise FleetError(self._place, _LOST if is_lost else _UNFIT) from error


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
