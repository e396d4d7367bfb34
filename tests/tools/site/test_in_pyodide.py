"""What runs in Pyodide when the site is built; Python here has the same bytecode's format."""

from __future__ import annotations

import marshal
import traceback
import zipfile
from pathlib import Path
from types import CodeType

import pytest
from tools.site.in_pyodide import compile_archive

_SOURCE = '''
"""A module."""


def outer(times):
    values = [it * 2 for it in range(times)]

    def inner():
        total = sum(values)
        raise ValueError(total)

    try:
        inner()
    finally:
        values.clear()
'''
_HEAD = 8  # bytes before the hash of the source, and it
_HASH = 8


def _code(folder: Path, level: int) -> CodeType:
    before, after = folder / "before.zip", folder / "after.zip"
    with zipfile.ZipFile(before, "w") as archive:
        archive.writestr("package/module.py", _SOURCE)
    compile_archive(str(before), str(after), level)
    with zipfile.ZipFile(after) as archive:
        assert archive.namelist() == ["package/module.pyc"]
        code = marshal.loads(archive.read("package/module.pyc")[_HEAD + _HASH :])
    assert isinstance(code, CodeType)
    return code


@pytest.mark.parametrize(
    ("level", "lines"),
    [
        pytest.param(0, [("outer", 13), ("inner", 10)], id="ours: the instruction's line"),
        pytest.param(2, [("outer", 5), ("inner", 8)], id="others': the head's line"),
    ],
)
def test_a_traceback_names_the_file_the_function_and_a_line(tmp_path, level, lines):
    space: dict[str, object] = {}
    exec(_code(tmp_path, level), space)
    outer = space["outer"]
    assert callable(outer)

    with pytest.raises(ValueError, match="20") as caught:
        outer(5)

    found = traceback.extract_tb(caught.value.__traceback__)[1:]
    assert [(it.name, it.lineno) for it in found] == lines
    assert {it.filename for it in found} == {"package/module.py"}


def test_every_instruction_has_the_heads_line_where_that_is_asked_for(tmp_path):
    def check(code: CodeType) -> None:
        assert {line for _, _, line in code.co_lines()} == {code.co_firstlineno}
        assert sum(end - start for start, end, _ in code.co_lines()) == len(code.co_code)
        for inner in code.co_consts:
            if isinstance(inner, CodeType):
                check(inner)

    check(_code(tmp_path, 2))
