"""A block of commands (```console) is run, and prints what it shows.

    $ mikas read TWAT          a command; what follows, to the next `$`, is its output
    TWAT  86 °C  …             `…` stands for anything in a line; alone, for any lines
    $ tshark -r drive.pcapng   run where it is installed; other programs are not run

As many spaces as one likes stand for the spaces or the tab between two words.

Without `$` a block is a list of commands: they are not run, but each must be one that the program
has, with options that it has. So are those of a block marked `no-run` (```console no-run), and
commands that don't end by themselves.
"""

from __future__ import annotations

import os
import re
import shlex
import shutil
import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass
from io import BytesIO, StringIO, TextIOWrapper
from itertools import takewhile
from pathlib import Path

import click

from mikas.cli.language import set_language
from mikas.cli.main import cli, run
from tools.docs.checking.virtual_unit import as_written, on_virtual_unit
from tools.docs.markdown import Code

NOT_RUN = "no-run"
_ENDLESS = frozenset({"dash", "demo", "publish", "sim"})
_UNBOUNDED = frozenset({"log", "watch"})  # endless, too, unless one of these bounds it
_BOUNDS = frozenset({"--count", "--duration", "--help"})
_OTHERS = frozenset({"tshark"})  # programs that read our files, and need nothing else
_ABSENT = "there is no file"  # only a command that is run needs its files
_VARIABLE = re.compile(r"\w+=\S*")
_ENDS = frozenset({"|", ">", "<", "&&", ";"})  # of the program's own arguments, in a shell


@dataclass(frozen=True, slots=True)
class Step:
    """A command of a block, and the output that the block shows. `line`: in the block, from 0."""

    command: str
    shown: tuple[str, ...]
    line: int
    session: bool

    @property
    def words(self) -> list[str]:
        """The command's words without variables before it; empty if no shell would take it."""
        try:
            words = shlex.split(self.command, comments=True)
        except ValueError:
            return []
        while words and _VARIABLE.fullmatch(words[0]):
            del words[0]
        return words

    @property
    def ours(self) -> bool:
        """Whether it calls the program."""
        return self.words[:1] == ["mikas"]

    @property
    def runs(self) -> bool:
        """Whether it can be run here: ours, or a program that is installed."""
        program = self.words[0] if self.words else ""
        return self.ours or (program in _OTHERS and shutil.which(program) is not None)

    @property
    def for_shell(self) -> bool:
        """Whether there is more than one program, a file for the output, or a variable."""
        parts = shlex.shlex(self.command, posix=True, punctuation_chars=True)
        return not self.command.startswith("mikas") or not _ENDS.isdisjoint(parts)

    @property
    def ends(self) -> bool:
        """Whether it ends by itself."""
        command = self.words[1:4]
        bounded = _UNBOUNDED.isdisjoint(command) or not _BOUNDS.isdisjoint(self.words)
        return bounded and _ENDLESS.isdisjoint(command)


def steps(text: str) -> Iterator[Step]:
    """Yield the commands of a block."""
    lines = text.splitlines()
    session = any(line.startswith("$ ") for line in lines)
    number = 0
    while number < len(lines):
        first, line = number, lines[number]
        number += 1
        while line.endswith("\\") and number < len(lines):
            line = line[:-1] + lines[number].strip()
            number += 1
        if session:
            shown = []
            while number < len(lines) and not lines[number].startswith("$ "):
                shown.append(lines[number].rstrip())
                number += 1
            if line.startswith("$ "):
                yield Step(line[2:].strip(), tuple(shown), first, session)
        elif line.strip() and not line.startswith("#"):
            yield Step(line.strip(), (), first, session)


def commands_of(text: str) -> list[str]:
    """Return the commands of a block without comments, which are translated."""
    return [" ".join(step.words).removesuffix(" --lang ru") or step.command for step in steps(text)]


def problems(code: Code) -> Iterator[tuple[int, str]]:
    """Run a block in the present folder; yield a line and what is wrong there."""
    for step in steps(code.text):
        line = code.line + 1 + step.line
        if step.session and NOT_RUN not in code.info.split() and step.runs and step.ends:
            problem = _not_as_shown(step)
        elif step.ours:
            problem = misused(step.words[1:])
        else:
            continue
        if problem:
            yield line, f"{step.command}: {problem}"


def misused(argv: Sequence[str]) -> str:
    """Return what the program has against these arguments, without running anything."""
    arguments = list(takewhile(lambda word: word not in _ENDS, argv))
    group: click.Command = cli
    context: click.Context | None = None
    set_language("en")  # that of `_ABSENT`
    try:
        while True:
            context = group.make_context(group.name, arguments, parent=context)
            if not isinstance(group, click.Group):
                return ""
            rest = [*context._protected_args, *context.args]  # noqa: SLF001  (as click itself)
            if not rest:
                return ""
            _, following, arguments = group.resolve_command(context, rest)
            assert following
            group = following
    except click.exceptions.Exit:
        return ""  # --help
    except click.UsageError as error:
        problem = error.format_message()
        return "" if _ABSENT in problem else problem


def matches(shown: Sequence[str], printed: Sequence[str]) -> bool:
    """Whether the output is as shown, with `…` for anything."""
    parts = [
        r"(?:[^\n]*\n)*?"
        if line.strip() == "…"
        else re.escape(line).replace("…", r"[^\n]*") + r"\n"
        for line in shown
    ]
    text = "".join(f"{line}\n" for line in printed)
    return re.fullmatch("".join(parts), text) is not None


def without_edges(lines: Sequence[str]) -> list[str]:
    """Return the lines with single spaces, and without empty ones at both ends."""
    return "\n".join(" ".join(line.split()) for line in lines).strip("\n").splitlines()


def _not_as_shown(step: Step) -> str:
    status, printed = _run(step)
    shown = without_edges(step.shown)
    if status and not shown:
        return f"status {status}: " + " / ".join(printed[-3:])
    if shown and not matches(shown, printed):
        return "prints something else:\n    " + "\n    ".join(printed)
    return ""


def _run(step: Step) -> tuple[int, list[str]]:
    """Run a command on the virtual unit, on simulated time; return its status and output."""
    command = on_virtual_unit(step.command)
    if step.for_shell:
        status, text = _run_by_shell(command)
    else:
        status, text = run_here(shlex.split(command, comments=True)[1:])
    return status, without_edges(as_written(text).splitlines())


def run_here(argv: list[str]) -> tuple[int, str]:
    """Run a command line of ours in this process; return its status and all that it printed."""
    written = TextIOWrapper(BytesIO(), "utf-8", write_through=True)
    typed, sys.stdin = sys.stdin, StringIO()  # nobody types here
    with redirect_stdout(written), redirect_stderr(written):
        try:
            status = run(argv)
        finally:
            set_language("en")
            sys.stdin = typed
    buffer = written.buffer
    assert isinstance(buffer, BytesIO)
    return status, buffer.getvalue().decode()


def _run_by_shell(command: str) -> tuple[int, str]:
    folder = Path(".bin").absolute()
    folder.mkdir(exist_ok=True)
    program = folder / "mikas"
    program.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m mikas "$@"\n')
    program.chmod(0o755)
    done = subprocess.run(
        ["bash", "-c", command],
        env=os.environ | {"PATH": f"{folder}{os.pathsep}{os.environ['PATH']}"},
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        encoding="utf-8",
        check=False,
    )
    return done.returncode, done.stdout
