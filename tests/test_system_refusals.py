"""What the system refuses is said in words, wherever the error comes from; the rest is a bug."""

from __future__ import annotations

import errno
import os

import pytest

from fleet_rig import make
from mikas.catalog import shipped
from mikas.cli.failures import BUG, USAGE, failure_of
from mikas.errors import refusal_of
from mikas.errors.system import REFUSALS
from mikas.fleet import job
from mikas.fleet.adding import plan
from mikas.fleet.interpreting import InterpretingSettings


def caused(by: BaseException) -> Exception:
    try:
        raise ValueError("in a library") from by
    except ValueError as error:
        return error


REFUSED = [
    MemoryError(), RuntimeError("can't start new thread"), OSError(errno.EMFILE, "x"),
    OSError(errno.ENOSPC, "x"), BlockingIOError(errno.EAGAIN, "x"), OSError(errno.ENOMEM, "x"),
    ImportError("lib.so: failed to map segment from shared object"), caused(MemoryError()),
    OSError(errno.EDQUOT, "x"), OSError(errno.EROFS, "x"), OSError(errno.EFBIG, "x"),
]  # fmt: skip


@pytest.mark.parametrize("error", REFUSED, ids=repr)
def test_a_refusal_of_the_system_is_no_bug_of_ours(error) -> None:
    failure = failure_of(error)
    assert failure.status == USAGE
    assert "bug" not in failure.text


@pytest.mark.parametrize(
    "error",
    [RuntimeError("x"), OSError(errno.EIO, "x"), ValueError("x"), KeyError("Out of Memory")],
)
def test_anything_else_still_is(error) -> None:
    assert refusal_of(error) is None
    assert failure_of(error).status == BUG


@pytest.mark.parametrize("number", [errno.ENOSPC, errno.ENOMEM, errno.EMFILE])
def test_a_file_that_the_system_refuses_is_named_with_the_reason(
    tmp_path, monkeypatch, number
) -> None:
    """It was “a bug in mikas” for nine of nine."""
    file = make(tmp_path / "drive.pcapng")
    found = plan([str(file)], str(tmp_path / "set"), InterpretingSettings(shipped())).files[0]

    def refuse(*_: object) -> None:
        raise MemoryError if number == errno.ENOMEM else OSError(number, os.strerror(number))

    monkeypatch.setattr(job, "digest_of", refuse)
    outcome = job.work(found, str(tmp_path / "set"), InterpretingSettings(shipped()))
    assert outcome.bad == REFUSALS[number]
    assert outcome.ends == (number == errno.ENOSPC)
