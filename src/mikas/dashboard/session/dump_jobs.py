"""Dumps as jobs: read piece by piece between samples into files, resumable after any interruption.

A piece takes 0.4 s on the line, then sampling has its turn. A lost line, a reload or the end of the
program loses no byte that was read: the file and its manifest (`mikas.client.memory.dumps`) hold
the progress, and reading resumes there. A second pass (verify) works alike; its result is kept as
well.
"""

from __future__ import annotations

import asyncio
import os
import re
import threading
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Literal

from mikas.client import Ecu
from mikas.client.memory.dumps import Dump, Manifest, manifest_path, read_manifest
from mikas.dashboard.errors import Busy, NotConnected, NotFound
from mikas.dashboard.library.folder import LeftOut, files_in
from mikas.dashboard.security.control import DumpShown, PendingChange
from mikas.dashboard.session.changes import DUMP, Found, deletion
from mikas.dashboard.session.connection import Connection
from mikas.dashboard.session.port_threads import logged
from mikas.dashboard.settings import ensure_folder
from mikas.errors import (
    LineError,
    MikasError,
    NoConnection,
    naming_file,
    unusable_file,
)
from mikas.files.locks import writer_of
from mikas.i18n import Text

SUFFIX = ".bin"
_MOST_DUMPS = 200  # listed; the latest
PIECE = 384  # bytes: 0.4 s on the line
TURN = 0.2  # s for sampling between two pieces
_RETRY = 1.0  # s until a lost line is tried again
_WAIT = 60.0
_PIECE_END = 10.0  # s to wait for a piece in progress; it takes longer only on a bad line
_TRIES = 5  # failed pieces in a row; the tester has repeated each request by then
_SPEED_OVER = 10.0  # s
CELLS = 256
_MIN_CELL = 64
_STAMP = re.compile(r"-(\d{8}-\d{6})(?:-(\d+))?$")  # of an id; the number: in the same second

_RUNS = Text("the dump {id} is running", "идёт чтение дампа {id}")

Phase = Literal["running", "paused", "done", "failed"]


class _PieceRead(Exception):
    """The piece is full."""


@dataclass(slots=True)
class DumpJob:
    """One dump. `retried`: cells of the map in which a request was repeated.

    `pace`: times and bytes done, for the speed; cleared by a pause, which is left out of it.
    """

    id: str
    file: Path
    manifest: Manifest
    block: int | None
    phase: Phase = "paused"
    error: MikasError | None = None
    retried: set[int] = field(default_factory=set)
    task: asyncio.Task[None] | None = None
    pace: deque[tuple[float, int]] = field(default_factory=deque)
    piece: threading.Lock = field(default_factory=threading.Lock)
    """Held while a piece is read: the file is open, and its manifest will be written."""

    @property
    def started(self) -> tuple[str, int]:
        """The start by the id; a file with another name counts as the oldest."""
        stamp = _STAMP.search(self.id)
        return (stamp[1], int(stamp[2] or 1)) if stamp else ("", 0)

    @property
    def done(self) -> int:
        """Bytes read, of both passes."""
        manifest = self.manifest
        return manifest.bytes_read + manifest.checked

    @property
    def total(self) -> int:
        """Bytes to read, in both passes."""
        return self.manifest.size * (2 if self.manifest.verify else 1)

    @property
    def cell(self) -> int:
        """Bytes in one cell of the map."""
        return max(_MIN_CELL, -(-self.manifest.size // CELLS))

    def count_progress(self, now: float) -> None:
        """Note the progress, for the speed."""
        self.pace.append((now, self.done))
        while self.pace[0][0] < now - _SPEED_OVER and len(self.pace) > 2:
            self.pace.popleft()

    @property
    def speed(self) -> float:
        """Bytes per second over the last 10 s."""
        pace = tuple(self.pace)  # at once: the list of dumps is made in another thread
        if self.phase != "running" or len(pace) < 2:
            return 0.0
        (began, before), (ended, after) = pace[0], pace[-1]
        return (after - before) / (ended - began) if ended > began else 0.0


class DumpJobs:
    """All dumps in `folder`; one of them may be running. `clock`: seconds that never run back."""

    def __init__(self, connection: Connection, folder: Path, clock: Callable[[], float]) -> None:
        self._connection, self._clock = connection, clock
        self.folder = folder
        self.jobs: dict[str, DumpJob] = {}
        self.left_out: list[LeftOut] = []

    def find(self) -> None:
        """Find the dumps of earlier runs; a file that is none of them stops nothing."""
        found = files_in(self.folder, SUFFIX, _MOST_DUMPS)
        self.left_out = found.left_out
        for kept in found.files:
            file = kept.path
            try:
                manifest = read_manifest(file)
            except MikasError as error:
                at, why = manifest_path(file), error.reason
                short = Text(why.en.removeprefix(f"{at}: "), why.ru.removeprefix(f"{at}: "))
                self.left_out.append(LeftOut(at.name, short))
                continue
            if manifest is not None and file.stem not in self.jobs:
                manifest.set_bytes_read(kept.bytes)
                phase: Phase = "done" if manifest.finished else "paused"
                self.jobs[file.stem] = DumpJob(file.stem, file, manifest, None, phase)

    def start(self, job: DumpJob) -> None:
        """Start or resume `job`. Raises `Busy` while another one runs."""
        other = next((it for it in self.jobs.values() if it.phase == "running"), None)
        if other is not None and other is not job:
            raise Busy(problem=_RUNS.filled(id=other.id))
        self.jobs[job.id] = job
        if job.phase != "running":
            job.phase, job.error = "running", None
            job.pace.clear()
            job.task = asyncio.create_task(self._run(job))

    async def pause(self, job: DumpJob) -> None:
        """Pause `job`; the piece in progress is waited for, and kept."""
        if job.task is not None:
            job.task.cancel()
            with suppress(asyncio.CancelledError):
                await job.task
            job.task = None
            if await asyncio.to_thread(job.piece.acquire, timeout=_PIECE_END):
                job.piece.release()
        if job.phase == "running":
            job.phase = "paused"

    def one(self, name: str) -> DumpJob:
        """Return the dump of that id. Raises `NotFound`."""
        job = self.jobs.get(name)
        if job is None:
            raise NotFound(name=name)
        return job

    def new_file(self, name: str) -> Path:
        """Return the file for a new dump: of `name`, with a number if that is taken."""
        stem, number = name, 2
        while stem in self.jobs or os.path.lexists(self.folder / f"{stem}{SUFFIX}"):
            stem, number = f"{name}-{number}", number + 1
        return self.folder / f"{stem}{SUFFIX}"

    async def deletion(self, name: str) -> PendingChange:
        """Return the deletion of that dump, file and manifest. Raises `NotFound`, `Busy`."""

        def find() -> Found:
            job = self.one(name)
            if job.phase != "running" and (held := writer_of(job.file)):  # `mikas dump`
                raise Busy(problem=held)
            shown = DumpShown(name, job.file.name, job.done, job.total)
            return Found(
                shown, (id(job), shown), job.phase == "running", partial(self._delete, job)
            )

        return await deletion(DUMP, f"{name}.bin", find, blocking=False)

    def _delete(self, job: DumpJob) -> None:
        """Delete the manifest last: a dump whose file could not be removed is still known."""
        with naming_file(job.file):
            for path in (job.file, manifest_path(job.file)):
                path.unlink(missing_ok=True)
        del self.jobs[job.id]

    async def close(self) -> None:
        """Pause all at the end of the program."""
        for job in list(self.jobs.values()):
            await self.pause(job)

    async def _run(self, job: DumpJob) -> None:
        """Read until done; any exception becomes the job's error, and another job can start."""
        try:
            await self._read_all(job)
            job.phase = "done"
        except MikasError as error:
            job.error, job.phase = error, "failed"
        except OSError as error:
            job.error, job.phase = unusable_file(job.file, error), "failed"
        except Exception as bug:  # any: the dump shows it and can be resumed
            port = self._connection.port
            job.error = logged(f"a bug in the dump {job.id}", bug, port.url if port else "")
            job.phase = "failed"

    async def _read_all(self, job: DumpJob) -> None:
        failures = 0
        while True:
            try:
                more = await self._connection.ask(lambda ecu: self._piece(ecu, job), seconds=_WAIT)
            except (NotConnected, NoConnection, Busy) as error:
                job.error = error
                job.pace.clear()
                await asyncio.sleep(_RETRY)
                continue
            except LineError as error:
                job.error = error
                failures += 1
                job.retried.add(job.manifest.bytes_read // job.cell)
                if failures == _TRIES:
                    raise
                continue
            failures, job.error = 0, None
            job.count_progress(self._clock())
            if not more:
                return
            await asyncio.sleep(TURN)

    def _piece(self, ecu: Ecu, job: DumpJob) -> bool:
        """Read one piece, in the sampling thread; return whether there is more to read."""
        with job.piece:
            return self._read_piece(ecu, job)

    def _read_piece(self, ecu: Ecu, job: DumpJob) -> bool:
        wanted, failed = job.manifest, ecu.tester.statistics.failed
        if wanted.finished:
            return False
        ensure_folder(job.file.parent)
        first, last, space = wanted.first, wanted.last, ecu.memory[wanted.space]
        dump = Dump(ecu, space, job.file, first=first, last=last, resume=True)
        now = dump.manifest
        now.verify |= wanted.verify
        began = now.bytes_read

        def progress(_: int) -> None:
            if now.bytes_read - began >= PIECE:
                raise _PieceRead

        try:
            if not wanted.complete:
                with suppress(_PieceRead):
                    dump.advance(block=job.block, progress=progress)
                if ecu.tester.statistics.failed > failed:
                    job.retried |= {*range(began // job.cell, now.bytes_read // job.cell + 1)}
            elif now.complete:  # else the file was cut: the missing part is read in the next turn
                dump.check(PIECE, block=job.block, progress=lambda _: None)
        finally:
            job.manifest = now
        return not now.finished
