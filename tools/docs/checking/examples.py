"""All blocks of code of a document, one after another in an empty folder.

    console            sessions.py
    python             run, against the virtual unit; `no-run` behind it: compiled only
    toml, json         parsed; JSON with `…` in it is not
    sql                run by `mikas fleet sql dataset` if the page has made one, or by DuckDB

Commands in a block without a language are a finding: they would not be checked. A document that
reads a recording without having made it finds drive.pcapng, a minute of a drive.
"""

from __future__ import annotations

import ast
import json
import os
import shutil
import signal
import tempfile
import tomllib
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from io import StringIO
from pathlib import Path, PurePosixPath
from types import FrameType

from mikas.cli.main import run
from tools.docs.checking import sessions, virtual_unit
from tools.docs.checking.finding import Finding
from tools.docs.checking.virtual_unit import on_virtual_unit
from tools.docs.markdown import Code, Document
from tools.docs.pages import RUSSIAN, document

RECORDING = "drive.pcapng"
DATASET = "dataset"
_PROGRAMS = frozenset({"$", "mikas", "tshark"})
LONGEST = 60  # seconds of a block


def recording(file: Path) -> None:
    """Record a minute of a drive in town."""
    port = f"{virtual_unit.PORT}&scenario=city&seed=1"
    with redirect_stderr(StringIO()):
        status = run(["--port", port, "log", "--duration", "60", "-o", str(file)])
    assert status == 0


def findings(file: PurePosixPath, drive: Path) -> list[Finding]:
    """Return what is wrong with the blocks of `file`; `drive`: the recording."""
    code = document(file).code
    found = [Finding(file, line, text) for line, text in unmarked(document(file))]
    if not any(each.language in _CHECKS for each in code):
        return found
    made = any(f"-o {RECORDING}" in each.command for each in _run(code))
    with tempfile.TemporaryDirectory() as folder, _inside(Path(folder), russian=_russian(file)):
        if not made:
            shutil.copyfile(drive, RECORDING)
        names: dict[str, object] = {"__name__": "__main__"}
        for each in code:
            if each.language in _CHECKS:
                with _time_limit():
                    try:
                        problems = list(_CHECKS[each.language](each, names))
                    except TimeoutError:
                        problems = [(each.line, f"takes longer than {LONGEST} s")]
                found += [Finding(file, line, text) for line, text in problems]
    return found


def unmarked(page: Document) -> Iterator[tuple[int, str]]:
    """Yield the blocks of commands that have no language."""
    for token in page.tokens:
        bare = token.type == "code_block" or (token.type == "fence" and not token.info.strip())
        if bare and token.map:
            programs = {line.split()[0] for line in token.content.splitlines() if line.strip()}
            if programs & _PROGRAMS:
                yield token.map[0] + 1, "commands without ```console: they are not checked"


def _run(code: Iterable[Code]) -> Iterator[sessions.Step]:
    for each in code:
        if each.language == "console":
            yield from (step for step in sessions.steps(each.text) if step.session)


def _russian(file: PurePosixPath) -> bool:
    return file.is_relative_to(RUSSIAN)


def _python(code: Code, names: dict[str, object]) -> Iterator[tuple[int, str]]:
    try:
        compiled = compile(
            on_virtual_unit(code.text), "example", "exec", ast.PyCF_ALLOW_TOP_LEVEL_AWAIT
        )
    except SyntaxError as error:
        yield code.line + (error.lineno or 0), f"{error.msg}: {error.text}"
        return
    if sessions.NOT_RUN in code.info.split():
        return
    try:
        with redirect_stdout(StringIO()), redirect_stderr(StringIO()):
            exec(compiled, names)
    except TimeoutError:
        raise
    except Exception as error:  # whatever the example raises is the finding
        line = 0
        step = error.__traceback__
        while step:
            line = step.tb_lineno if step.tb_frame.f_code.co_filename == "example" else line
            step = step.tb_next
        yield code.line + line, f"{type(error).__name__}: {error}"


def _toml(code: Code, _: dict[str, object]) -> Iterator[tuple[int, str]]:
    try:
        tomllib.loads(code.text)
    except tomllib.TOMLDecodeError as error:
        yield code.line, str(error)


def _json(code: Code, _: dict[str, object]) -> Iterator[tuple[int, str]]:
    if "…" in code.text:
        return
    try:
        json.loads(code.text)
    except json.JSONDecodeError as error:
        yield code.line + error.lineno, error.msg


def _sql(code: Code, _: dict[str, object]) -> Iterator[tuple[int, str]]:
    import duckdb

    for statement in duckdb.extract_statements(code.text):
        line = code.line + 1 + code.text[: code.text.index(statement.query.strip())].count("\n")
        if Path(DATASET).is_dir():
            status, printed = sessions.run_here(["fleet", "sql", DATASET, statement.query])
            if status:
                yield line, printed.strip()
            continue
        try:
            duckdb.execute(statement.query)
        except duckdb.Error as error:
            yield line, str(error)


def _console(code: Code, _: dict[str, object]) -> Iterator[tuple[int, str]]:
    return sessions.problems(code)


_CHECKS = {
    "console": _console,
    "json": _json,
    "python": _python,
    "sql": _sql,
    "toml": _toml,
}


@contextmanager
def _inside(folder: Path, *, russian: bool) -> Iterator[None]:
    """Be in `folder`, far from the user's own files, in the language of the document."""
    home = folder / ".home"
    home.mkdir()
    before = dict(os.environ)
    for name in ("MIKAS_CONFIG", "MIKAS_LANG", "LC_ALL", "LC_MESSAGES"):
        os.environ.pop(name, None)
    os.environ |= {
        "HOME": str(home),
        "USERPROFILE": str(home),
        "XDG_STATE_HOME": str(home / "state"),
        "XDG_CONFIG_HOME": str(home / "config"),
        "MIKAS_STATE": str(home / "state" / "mikas"),
        "MIKAS_PORT": virtual_unit.PORT,
        "LANG": "ru_RU.UTF-8" if russian else "C.UTF-8",
        "COLUMNS": "120",
        "NO_COLOR": "1",
    }
    here = Path.cwd()
    os.chdir(folder)
    try:
        yield
    finally:
        os.chdir(here)
        os.environ.clear()
        os.environ.update(before)


@contextmanager
def _time_limit() -> Iterator[None]:
    def over(_: int, __: FrameType | None) -> None:
        raise TimeoutError

    before = signal.signal(signal.SIGALRM, over)
    signal.alarm(LONGEST)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)
