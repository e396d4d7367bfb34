"""Dumps as jobs: piece by piece between samples, kept in files, gone on with after anything.

A piece is half a second of the wire, then the sampling has its turn. A lost line, a reload, even
the end of the program cost nothing that was read: what a dump is stands in its file and manifest
(`mikas.client.memory.dump`), and it goes on behind that. A second pass (verify) is done alike,
and what it found is kept there too.
"""

from __future__ import annotations

import asyncio
import logging
import re
from collections import deque
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from mikas.client import Ecu
from mikas.client.memory.dump import Dump
from mikas.client.memory.manifest import Manifest, read_manifest
from mikas.dashboard.errors import Busy, InternalError, NotConnected
from mikas.dashboard.settings import ensure_folder
from mikas.errors import LineError, MikasError, NoConnection, UsageError, reason_at
from mikas.i18n import Text

if TYPE_CHECKING:
    from mikas.dashboard.dashboard import Hub

_log = logging.getLogger("mikas.dashboard")

PIECE = 384  # bytes: 0.4 s of the wire
TURN = 0.2  # s that the sampling has between two pieces
_AGAIN = 1.0  # s until a line that was lost is asked again
_PATIENCE = 60.0
_TRIES = 5  # spoilt pieces in a row; the tester has repeated each request by then
_SPEED_OVER = 10.0
CELLS = 256
_SMALLEST_CELL = 64
_STAMP = re.compile(r"-(\d{8}-\d{6})(?:-(\d+))?$")  # of an id; the number: in the same second

_RUNS = Text("the dump {id} is running", "идёт чтение образа {id}")

Phase = Literal["running", "paused", "done", "failed"]


class _Enough(Exception):
    """The piece is full."""


@dataclass(slots=True)
class Job:
    """One dump. `retried`: cells of the map in which something had to be repeated."""

    id: str
    file: Path
    manifest: Manifest
    block: int | None
    phase: Phase = "paused"
    error: MikasError | None = None
    retried: set[int] = field(default_factory=set)
    task: asyncio.Task[None] | None = None
    _pace: deque[tuple[float, int]] = field(default_factory=deque)

    @property
    def begun(self) -> tuple[str, int]:
        """When, as its id says; one that was put there under another name counts as the oldest."""
        stamp = _STAMP.search(self.id)
        return (stamp[1], int(stamp[2] or 1)) if stamp else ("", 0)

    @property
    def done(self) -> int:
        """Bytes read; those of a second pass count as well."""
        manifest = self.manifest
        return manifest.bytes_read + manifest.checked

    @property
    def total(self) -> int:
        """Bytes to be read, both passes."""
        return self.manifest.size * (2 if self.manifest.verify else 1)

    @property
    def cell(self) -> int:
        """Bytes that one cell of the map stands for."""
        return max(_SMALLEST_CELL, -(-self.manifest.size // CELLS))

    def went_on(self, now: float) -> None:
        """For the speed."""
        self._pace.append((now, self.done))
        while self._pace[0][0] < now - _SPEED_OVER and len(self._pace) > 2:
            self._pace.popleft()

    def rested(self) -> None:
        """A pause is no slowness."""
        self._pace.clear()

    @property
    def speed(self) -> float:
        """Bytes a second, lately."""
        if self.phase != "running" or len(self._pace) < 2:
            return 0.0
        (began, before), (ended, after) = self._pace[0], self._pace[-1]
        return (after - before) / (ended - began) if ended > began else 0.0


class Dumping:
    """All dumps in the folder; one of them may be running."""

    def __init__(self, hub: Hub) -> None:
        self._hub = hub
        self.jobs: dict[str, Job] = {}

    def find(self) -> None:
        """Those of earlier runs, to be gone on with or looked at."""
        for file in sorted(self._hub.settings.dumps.glob("*.bin")):
            manifest = None
            with suppress(MikasError):
                manifest = read_manifest(file)
            if manifest is not None and file.stem not in self.jobs:
                manifest.holds(file.stat().st_size)
                job = Job(file.stem, file, manifest, None)
                if manifest.finished:
                    job.phase = "done"
                self.jobs[job.id] = job

    def start(self, job: Job) -> None:
        """Begins it, or goes on with it. Raises `Busy` while another one runs."""
        other = next((it for it in self.jobs.values() if it.phase == "running"), None)
        if other is not None and other is not job:
            raise Busy(problem=_RUNS.filled(id=other.id))
        self.jobs[job.id] = job
        if job.phase != "running":
            job.phase, job.error = "running", None
            job.rested()
            job.task = asyncio.create_task(self._run(job))

    async def pause(self, job: Job) -> None:
        """Ends it for now; the piece that is under way is still kept."""
        if job.task is not None:
            job.task.cancel()
            with suppress(asyncio.CancelledError):
                await job.task
            job.task = None
        if job.phase == "running":
            job.phase = "paused"

    async def close(self) -> None:
        """The program ends."""
        for job in list(self.jobs.values()):
            await self.pause(job)

    async def _run(self, job: Job) -> None:
        """Until it is done, or fails: whatever ends it is told, and another one can begin."""
        try:
            await self._read_all(job)
            job.phase = "done"
        except MikasError as error:
            job.phase, job.error = "failed", error
        except OSError as error:
            job.phase, job.error = "failed", UsageError(problem=reason_at(job.file, error))
        except Exception as bug:  # whatever it is: the dump says so and can be resumed
            _log.error("a bug in the dump %s", job.id, exc_info=bug)
            job.phase, job.error = "failed", InternalError(kind=f"{type(bug).__name__}: {bug}")

    async def _read_all(self, job: Job) -> None:
        spoilt = 0
        while True:
            try:
                going_on = await self._hub.ask(lambda ecu: self._piece(ecu, job), seconds=_PATIENCE)
            except (NotConnected, NoConnection, Busy) as error:
                job.error = error
                job.rested()
                await asyncio.sleep(_AGAIN)
                continue
            except LineError as error:
                job.error = error
                spoilt += 1
                job.retried.add(job.manifest.bytes_read // job.cell)
                if spoilt == _TRIES:
                    raise
                continue
            spoilt, job.error = 0, None
            job.went_on(self._hub.clock())
            if not going_on:
                return
            await asyncio.sleep(TURN)

    def _piece(self, ecu: Ecu, job: Job) -> bool:
        """In the sampling thread. Whether there is more to do."""
        failed = ecu.tester.statistics.failed
        before = job.manifest.bytes_read
        if not job.manifest.complete:
            self._read(ecu, job)
            if ecu.tester.statistics.failed > failed:
                job.retried |= set(
                    range(before // job.cell, job.manifest.bytes_read // job.cell + 1)
                )
        elif not job.manifest.finished:
            self._check(ecu, job)
        return not job.manifest.finished

    def _open(self, ecu: Ecu, job: Job) -> Dump:
        ensure_folder(job.file.parent)
        wanted = job.manifest
        dump = Dump(
            ecu,
            ecu.memory[wanted.space],
            job.file,
            first=wanted.first,
            last=wanted.last,
            resume=True,
        )
        dump.manifest.verify |= wanted.verify
        return dump

    def _read(self, ecu: Ecu, job: Job) -> None:
        dump = self._open(ecu, job)
        got = 0

        def progress(count: int) -> None:
            nonlocal got
            got += count
            if got >= PIECE:
                raise _Enough

        try:
            with suppress(_Enough):
                dump.advance(block=job.block, progress=progress)
        finally:
            job.manifest = dump.manifest

    def _check(self, ecu: Ecu, job: Job) -> None:
        dump = self._open(ecu, job)
        job.manifest = dump.manifest
        if dump.manifest.complete:  # else the file was cut: first read what is missing now
            dump.check(PIECE, block=job.block, progress=lambda _: None)
