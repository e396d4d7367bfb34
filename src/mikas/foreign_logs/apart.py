"""Read another program's log where a damaged one can do no harm: MDF4 in a process of its own.

asammdf's compiled code reads outside its memory at some damaged files, which ends the process: with
it would end the sampling and the recording of a dashboard. The other formats are read by this
program's own code, in place. A script of a user's calls `mikas.open_log`: it has nothing to lose,
and no main module that a new process may run again.
"""

from __future__ import annotations

import signal
import sys
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Final, TypeVar, cast

from mikas.cancellation import check_cancelled
from mikas.errors import ForeignLogError, MikasError, library
from mikas.foreign_logs.choice import LogChoice, LogPreview
from mikas.foreign_logs.layout import TextSettings
from mikas.foreign_logs.opening import format_of, preview_log, read_log
from mikas.foreign_logs.table import ForeignLog
from mikas.i18n import Text

if TYPE_CHECKING:
    from multiprocessing.connection import Connection

T = TypeVar("T")

LONGEST: Final = 300.0
"""Seconds that the reading may take."""
_LOOK: Final = 0.1  # s from one look at a client that may have gone to the next
_END: Final = 2.0  # s that the end of the process is waited for


def preview_apart(data: bytes, name: str, settings: TextSettings | None = None) -> LogPreview:
    """As `preview_log`."""
    if format_of(data, name) != "mdf":
        return preview_log(data, name, settings)
    return in_own_process(preview_log, data, name, settings)


def read_apart(data: bytes, name: str, choice: LogChoice | None = None) -> ForeignLog:
    """As `read_log`."""
    if format_of(data, name) != "mdf":
        return read_log(data, name, choice)
    return in_own_process(read_log, data, name, choice)


def in_own_process(
    work: Callable[[bytes, str, Any], T], data: bytes, name: str, settings: object
) -> T:
    """Return what `work` returns in a process of its own, or raise what it raises."""
    library("asammdf", feature="MDF4", extra="mdf")
    from multiprocessing import get_context  # a browser has no processes, and no asammdf

    spawn = get_context("spawn")
    near, far = spawn.Pipe()
    process = spawn.Process(target=answer, args=(far,), daemon=True)
    process.start()
    far.close()
    try:
        near.send((work, data, name, settings))
        waited = 0.0
        while not near.poll(_LOOK):
            check_cancelled()
            waited += _LOOK
            if waited > LONGEST:
                raise ForeignLogError(name, _TOO_LONG)
        result, error = near.recv()
    except (EOFError, OSError) as died:  # it has ended without an answer
        raise ForeignLogError(name, _DIED).caused_by(died) from died
    finally:
        near.close()
        process.kill()
        process.join(_END)
    if error is not None:
        raise error
    return cast("T", result)  # a pipe gives anything


def answer(pipe: Connection) -> None:
    """Do the work that comes by `pipe`, and send its result or its error."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is the parent's
    sys.unraisablehook = lambda _: None  # of asammdf's own end, at a file that it can't read
    work, data, name, settings = pipe.recv()
    try:
        pipe.send((work(data, name, settings), None))
    except MikasError as error:
        pipe.send((None, error))


_DIED: Final = Text(
    "damaged so much that its reading broke down: copy it again, or save the log as CSV",
    "повреждён настолько, что чтение оборвалось: скопируйте ещё раз или сохраните лог как CSV",
)
_TOO_LONG: Final = Text(
    f"its reading took more than {LONGEST / 60:.0f} minutes: save a part of the log as CSV",
    f"чтение длилось больше {LONGEST / 60:.0f} минут: сохраните часть лога как CSV",
)
