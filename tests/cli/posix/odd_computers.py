"""Command lines on odd computers: a program of its own, which `test_odd_computers.py` starts.

Each line of stdin is a computer in JSON, `{"environment", "umask", "folder", "current", "files",
"oddity", "missing", "is_one_process", "lines"}`: `files` are copied into `folder` by their new
names, `current` is a folder in it, the libraries `missing` can't be imported; on one that
`is_one_process`, `fleet add` starts no other.
The computer gets a fork of this process, which has imported the large libraries, and its lines are
run there in order. Each line of stdout is the answer in JSON: `[status, printed]` for each line. A
command that serves until Ctrl-C gets it as soon as it has said so.
"""

from __future__ import annotations

import faulthandler
import gc
import importlib
import json
import os
import shutil
import signal
import sys
import tempfile
import traceback
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from io import TextIOWrapper
from pathlib import Path
from typing import BinaryIO

from mikas.cli.main import main
from mikas.cli.render import terminal
from mikas.fleet import executors
from mikas.fleet.executors import Runner, Work
from mikas.fleet.job import FileOutcome
from mikas.fleet.places import FoundFile

LARGE = ("asammdf", "duckdb", "mikas.dashboard.app", "mikas.dashboard.server")

LONGEST = 300  # s; a command that hangs says where


class Printed(TextIOWrapper):
    """A file that presses Ctrl-C when a command has said that this ends it."""

    def write(self, text: str) -> int:
        length = super().write(text)
        if "Ctrl-C ends it" in text:
            os.kill(os.getpid(), signal.SIGINT)
        return length


class HereRunner(Runner):
    """This process itself: a new one imports for a second."""

    def __init__(self, workers: int) -> None: ...

    def close(self) -> None: ...

    def outcomes(self, work: Work, files: Iterable[FoundFile]) -> Iterator[FileOutcome]:
        return map(work, files)


def empty(folder: Path) -> None:
    """Remove what an earlier computer has left on the disk."""
    for each in folder.iterdir():
        if each.is_dir():
            shutil.rmtree(each)
        else:
            each.unlink()


def fill(folder: Path) -> None:
    """Leave no room on the disk."""
    with (folder / "fill").open("wb", buffering=0) as file, suppress(OSError):
        while file.write(bytes(4096)):
            pass


def close_streams(_: Path) -> None:
    for number in range(3):
        os.close(number)
    sys.stdin = sys.stdout = sys.stderr = None
    terminal.make_writable()  # as `main` does


ODDITIES: dict[str, Callable[[Path], object]] = {
    "": lambda _: None,
    "full": fill,
    "gone": lambda _: Path.cwd().rmdir(),
    "unreadable": lambda _: Path.cwd().chmod(0),
    "closed": close_streams,
}


def native(text: str) -> str:
    """Return `text` as this system gives names to Python."""
    return os.fsdecode(text.encode())


def ran(words: list[str], printed: Printed) -> tuple[int, str]:
    start = printed.buffer.seek(0, os.SEEK_END)
    status: object = 0
    try:
        main([*map(native, words)])
    except SystemExit as ended:
        status = ended.code
    except KeyboardInterrupt:
        status = 130
    printed.flush()
    printed.buffer.seek(start)
    return status, printed.buffer.read().decode("utf-8", "replace")


def on_computer(computer: dict, answer: int, log: BinaryIO) -> None:
    """Run the lines and write the answer."""
    os.environ.clear()
    os.environ.update({name: native(text) for name, text in computer["environment"].items()})
    tempfile.tempdir = None
    os.umask(int(computer["umask"], 8))
    folder = Path(native(computer["folder"]))
    empty(folder)
    for name, file in computer["files"].items():
        shutil.copyfile(file, folder / native(name))
    for name, mode in (("current", 0o777), ("sealed", 0o555)):
        (folder / name).mkdir(mode)
    os.chdir(folder / computer["current"])
    ODDITIES[computer["oddity"]](folder)
    sys.modules.update(dict.fromkeys(computer["missing"]))
    if computer["is_one_process"]:
        executors.ProcessRunner = HereRunner
    if computer["oddity"] != "closed":
        nothing = os.open(os.devnull, os.O_RDONLY)
        for number, descriptor in enumerate((nothing, log.fileno(), log.fileno())):
            os.dup2(descriptor, number)
    printed = Printed(log, sys.__stdout__.encoding, errors="replace", write_through=True)
    sys.stdout = sys.stderr = printed
    signal.signal(signal.SIGINT, signal.default_int_handler)
    results = [ran(words, printed) for words in computer["lines"]]
    with os.fdopen(answer, "w", encoding="utf-8") as pipe:
        json.dump(results, pipe)


def serve() -> None:
    for name in LARGE:  # not by the processes that a command starts
        importlib.import_module(name)
    gc.freeze()  # else each fork copies them
    errors = os.dup(2)
    for line in sys.stdin:
        computer = json.loads(line)
        reading, writing = os.pipe()
        log = tempfile.TemporaryFile()  # noqa: SIM115  (the fork's, too)
        child = os.fork()
        if not child:
            faulthandler.dump_traceback_later(LONGEST, exit=True, file=errors)
            try:
                on_computer(computer, writing, log)
            except BaseException:
                os.write(errors, traceback.format_exc().encode())
            finally:
                os._exit(0)
        os.close(writing)
        log.close()
        with os.fdopen(reading, encoding="utf-8") as pipe:
            sys.stdout.write(f"{pipe.read() or None}\n")
        os.waitpid(child, 0)
        sys.stdout.flush()
    gc.unfreeze()  # some libraries complain about it at the exit


if __name__ == "__main__":
    serve()
