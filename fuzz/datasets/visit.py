"""What a user does with a dataset of a stranger, within limits: add, ask, report.

Nothing here may reach the network. CPU time, memory and real time are limited by the system, as
what hangs in a library can't be stopped otherwise.
"""

from __future__ import annotations

import faulthandler
import io
import json
import os
import resource
import signal
import socket
import sys
import traceback
from collections.abc import Iterable, Iterator
from contextlib import redirect_stderr, redirect_stdout
from importlib import import_module
from pathlib import Path
from typing import Any, Final, NoReturn

from mikas.catalog import shipped
from mikas.cleaning import terminal_text
from mikas.cli.main import run
from mikas.fleet import executors
from mikas.fleet.executors import Runner, Work
from mikas.fleet.job import FileOutcome
from mikas.fleet.places import FoundFile

_SECONDS: Final = 20  # of CPU time
_WAITING: Final = 120  # s of real time: it may wait for ever
_MEMORY: Final = 600 << 10  # KiB of a process; that of a sound dataset has 250
_BEFORE: Final = (
    *(
        "adding",
        "query.database",
        "interpreting",
        "ledger",
        "query.memory",
        "report.figures",
        "report.findings",
    ),
    "report.page",
)
"""Modules of `mikas.fleet` that are loaded before the fork."""
_BUGS: Final = ("bug in mikas", "Traceback (most recent")


class Finding(Exception):
    """What must not be."""


class _HereRunner(Runner):
    """This process: a case shall take half a second."""

    def close(self) -> None: ...

    def outcomes(self, work: Work, files: Iterable[FoundFile]) -> Iterator[FileOutcome]:
        return map(work, files)


def prepare() -> None:
    """Load what every case needs; no thread is started."""
    for name in _BEFORE:
        import_module(f"mikas.fleet.{name}")
    shipped()


def apart(world: Path, out: int) -> NoReturn:
    """Be the process that may die; what it says goes to `out`."""
    status = 1
    try:
        os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
        os.dup2(out, 1)
        os.dup2(out, 2)
        faulthandler.enable()
        faulthandler.dump_traceback_later(_WAITING, exit=True)
        signal.signal(signal.SIGXCPU, signal.SIG_DFL)
        faulthandler.register(signal.SIGXCPU, all_threads=True, chain=True)
        resource.setrlimit(resource.RLIMIT_CPU, (_SECONDS, _SECONDS + 1))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        visit(world)
        status = 0
    except BaseException:
        os.write(out, traceback.format_exc(limit=-5).encode("utf-8", "replace"))
    finally:
        os._exit(status)


def visit(world: Path) -> None:
    """Use the dataset as a user does. Raises on a finding."""
    for name in ("connect", "connect_ex", "sendto"):
        setattr(socket.socket, name, _refused)
    socket.getaddrinfo = _refused
    executors.runner_of = lambda *_: _HereRunner()
    home = str(world / "set")
    _command("fleet", "add", str(world / "in"), "--to", home)
    for question in ("FROM drives", "FROM faults", "SELECT count(*), max(TWAT) FROM samples"):
        _command("fleet", "sql", home, question)
    _command("fleet", "sql", home, "FROM statistics", "--json")
    _command("fleet", "report", home, "-o", str(world / "page.html"), "--overwrite")
    _command("fleet", "report", home, "--json", "--lang", "ru")
    _command("fleet", "add", str(world / "in"), "--to", home, "--check", "--json")
    used = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    if used > _MEMORY:
        raise Finding(f"{used >> 10} MiB of memory")


def _command(*words: str) -> None:
    """Run a command line. Raises on a finding in what it prints, or for a status of a bug."""
    out, errors = io.StringIO(), io.StringIO()
    with redirect_stdout(out), redirect_stderr(errors):
        run([*words])
    said = out.getvalue(), errors.getvalue()
    for text in said:
        if any(bug in text for bug in _BUGS):
            raise Finding(f"{words}: {text[-1500:]}")
        for line in text.split("\n"):
            if line != terminal_text(line):
                raise Finding(f"{words}: a control character in {line[:300]!r}")
    if "--json" in words and out.getvalue():
        json.loads(out.getvalue(), parse_constant=_no_constant)


def _no_constant(name: str) -> NoReturn:
    raise Finding(f"{name} is no JSON")


def _refused(*_: Any, **__: Any) -> NoReturn:
    print("the network was asked", file=sys.__stderr__, flush=True)
    os._exit(3)
