"""A compiled file of Python that a full disk or a power cut has damaged: the sentence names it."""

from __future__ import annotations

import os
import py_compile
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

import mikas

_HEADER = 16  # bytes of a compiled file, which Python checks by itself
DAMAGES: dict[str, Callable[[bytes], bytes]] = {
    "cut in the header": lambda whole: whole[:7],
    "cut after the header": lambda whole: whole[:_HEADER],
    "cut": lambda whole: whole[: len(whole) // 2],
    "its last byte is missing": lambda whole: whole[:-1],
    "zeros": lambda whole: whole[:_HEADER] + bytes(len(whole) - _HEADER),
    "another file's bytes": lambda whole: whole[:_HEADER] + b"?" * len(whole),
    "not code": lambda whole: whole[:_HEADER] + b"N",
}
MENDED = "cut in the header"  # by Python


@pytest.fixture(scope="module")
def copy(tmp_path_factory) -> Path:
    """Give a folder with a copy of the package, without its page."""
    folder = tmp_path_factory.mktemp("copy")
    left_out = shutil.ignore_patterns("__pycache__", "page")
    shutil.copytree(Path(mikas.__file__).parent, folder / "mikas", ignore=left_out)
    return folder


@pytest.mark.parametrize(
    ("damage", "language", "words"),
    [*((damage, "en", "Delete this file") for damage in DAMAGES), ("cut", "ru", "Удалите его")],
)
def test_a_damaged_compiled_file_is_named(copy, damage, language, words):
    """It was “a bug in mikas (EOFError: marshal data too short)”."""
    compiled = Path(py_compile.compile(copy / "mikas" / "catalog" / "formulas.py", doraise=True))
    compiled.write_bytes(DAMAGES[damage](compiled.read_bytes()))
    line = "from mikas.cli.main import main; main(['params'])"
    done = subprocess.run(
        [sys.executable, "-c", line], check=False, capture_output=True, encoding="utf-8",
        env=os.environ | {
            "PYTHONPATH": str(copy), "PYTHONDONTWRITEBYTECODE": "1", "MIKAS_LANG": language,
            "PYTHONIOENCODING": "utf-8",
        },
    )  # fmt: skip
    if damage == MENDED:
        assert done.returncode == 0
        return
    assert done.returncode == 2
    assert str(compiled) in done.stderr
    assert words in done.stderr
    assert "Traceback" not in done.stderr
