"""The work and memory of one reading, counted, and what it may be for a file of some size.

    calls    of functions, Python's and C's, by cProfile; each turn of a generator is one
    bytes    read from files, by the system's own count (/proc/self/io)
    memory   the process's peak, by the system's count (VmHWM)

These are the same on a fast machine and on a busy one. CPU time is only the last resort, for a loop
without a call: after `SECONDS` of it the process writes the stacks of all threads and ends.
"""

from __future__ import annotations

import cProfile
import faulthandler
import resource
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import CodeType
from typing import Final, TextIO

SECONDS: Final = 20  # of CPU time, of one reader on one file
WAITING: Final = 180  # of real time: it may also wait for ever
ADDRESSES: Final = 3 << 30  # bytes beyond those after the warm-up; more raise a MemoryError
MEMORY: Final = (96 << 20, 1500)  # bytes beyond those before: in any case, and for each byte


@dataclass(frozen=True, slots=True)
class Allowance:
    """What one reader may do: in any case, and for each byte of the file. Linear, by design."""

    calls: tuple[int, int]
    reads: tuple[int, int]


class TooMuch(Exception):
    """A reader's work is out of proportion to its file. `where`: the function called most."""

    def __init__(self, what: str, figures: str, where: str) -> None:
        super().__init__(f"{what}: {figures}; most calls: {where}")
        self.what, self.where = what, where


@dataclass(slots=True)
class Work:
    """The work of one reading."""

    calls: int = 0
    read: int = 0
    memory: int = 0
    busiest: str = ""

    def check(self, size: int, allowed: Allowance) -> None:
        """Raise `TooMuch` for more work than a file of `size` bytes justifies."""
        for name, count, (always, each) in (
            ("calls", self.calls, allowed.calls),
            ("bytes read", self.read, allowed.reads),
            ("bytes of memory", self.memory, MEMORY),
        ):
            most = always + each * size
            if count > most:
                figures = f"{count:,} for a file of {size:,} bytes, at most {most:,}"
                raise TooMuch(f"too many {name}", figures, self.busiest)


@contextmanager
def counted(*, calls: bool = True) -> Iterator[Work]:
    """Count the work until the block ends; `calls` too, which takes as long again."""
    work = Work()
    profile = cProfile.Profile()
    Path("/proc/self/clear_refs").write_text("5", "ascii")
    before, resident = _bytes_read(), _peak()
    signal.setitimer(signal.ITIMER_PROF, SECONDS)
    faulthandler.dump_traceback_later(WAITING, exit=True)
    if calls:
        profile.enable()
    try:
        yield work
    finally:
        profile.disable()
        faulthandler.cancel_dump_traceback_later()
        signal.setitimer(signal.ITIMER_PROF, 0)
        work.read = _bytes_read() - before
        work.memory = _peak() - resident
        entries = profile.getstats()
        work.calls = sum(entry.callcount for entry in entries)
        for entry in sorted(entries, key=lambda entry: entry.callcount):
            if isinstance(entry.code, CodeType) and "/mikas/" in entry.code.co_filename:
                work.busiest = place(entry.code.co_filename, entry.code.co_name)


def place(file: str, function: str) -> str:
    """Return a function of mikas as `recording/summary.py:summarise`."""
    return f"{file.rpartition('/mikas/')[2]}:{function}"


def arm(stacks: TextIO) -> None:
    """Let this process end with the stacks in `stacks` when a reader never does."""
    faulthandler.enable(stacks)
    signal.signal(signal.SIGPROF, signal.SIG_DFL)
    faulthandler.register(signal.SIGPROF, stacks, all_threads=True, chain=True)


def bound_addresses() -> None:
    """Make the system refuse this process much more memory than it has now."""
    now = int(_status("VmSize")) << 10
    resource.setrlimit(resource.RLIMIT_AS, (now + ADDRESSES, resource.RLIM_INFINITY))


def _bytes_read() -> int:
    return int(Path("/proc/self/io").read_text("ascii").split(maxsplit=2)[1])


def _peak() -> int:
    return int(_status("VmHWM")) << 10


def _status(name: str) -> str:
    lines = Path("/proc/self/status").read_text("ascii").splitlines()
    return next(line.split()[1] for line in lines if line.startswith(f"{name}:"))
