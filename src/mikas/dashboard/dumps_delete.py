"""Deleting a dump: a change in two steps, as every other that can't be undone.

One that is being read is not deleted: it is paused first. What was confirmed is what was there
then; a dump that was gone on with meanwhile is another.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from mikas.client.memory.manifest import manifest_path
from mikas.dashboard.errors import Busy, ConfirmationOutdated, NotFound
from mikas.dashboard.security.confirmations import FOR_GOOD, Prepared
from mikas.errors import UsageError, reason_at
from mikas.i18n import Text

if TYPE_CHECKING:
    from mikas.dashboard.dashboard import Hub
    from mikas.dashboard.session.dump_jobs import Job

_RUNS = Text(
    "this dump is being read; pause it first",
    "этот образ как раз читается; сначала остановите чтение",
)
_GONE = Text("This dump is no longer there", "Этого образа уже нет")
_CHANGED = Text("This dump is no longer as it was shown", "Этот образ уже не тот, что был показан")


def prepared_delete_of_dump(hub: Hub, name: str) -> Prepared:
    """What would be deleted. Raises `NotFound`, `Busy` for the dump that is being read."""
    job = hub.dumping.jobs.get(name)
    if job is None:
        raise NotFound(name=name)
    _check_paused(job)
    before = _told(job)

    async def make() -> dict[str, Any]:
        if hub.dumping.jobs.get(name) is not job:
            raise ConfirmationOutdated(_GONE)
        _check_paused(job)
        if _told(job) != before:
            raise ConfirmationOutdated(_CHANGED)
        _delete(job)
        del hub.dumping.jobs[name]
        return {"before": before, "after": None}

    return Prepared(
        what=Text(f"delete the dump {job.file.name}", f"удалить образ {job.file.name}"),
        before=before,
        after=None,
        lost=(before,),
        meaning=FOR_GOOD,
        make=make,
    )


def _check_paused(job: Job) -> None:
    if job.phase == "running":
        raise Busy(problem=_RUNS)


def _told(job: Job) -> dict[str, Any]:
    return {"id": job.id, "file": job.file.name, "done": job.done, "total": job.total}


def _delete(job: Job) -> None:
    """The manifest last: a dump whose file could not be removed is still known."""
    try:
        for path in (job.file, manifest_path(job.file)):
            path.unlink(missing_ok=True)
    except OSError as error:
        raise UsageError(problem=reason_at(job.file, error)) from error
