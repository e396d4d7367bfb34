"""Docstrings of mikas' own modules: a twentieth of all that the program's archive takes.

The site shows only those of the API's description. Their lines stay, empty, so that a traceback
names the right one.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator, Mapping

READ = ("mikas/dashboard/", "mikas/sampling/events.py", "mikas/sampling/instrument_changes.py")
"""What describes the API: routes, models, events; enumerations do so wherever they are."""

_EMPTY: Mapping[type[ast.AST], bytes] = {
    ast.Module: b'""',  # `from __future__` may follow
    ast.ClassDef: b'"."',  # a dataclass without one makes one of its fields, which takes time
    ast.FunctionDef: b"0",
    ast.AsyncFunctionDef: b"0",
}


def without_docstrings(files: Mapping[str, bytes]) -> dict[str, bytes]:
    """Return `files` with no docstrings in Python modules, but for those of `READ`."""
    return {
        name: _bare(content) if name.endswith(".py") and not name.startswith(READ) else content
        for name, content in files.items()
    }


def _bare(source: bytes) -> bytes:
    lines = source.splitlines(keepends=True)
    for docstring, instead in _docstrings(ast.parse(source)):
        first, last = docstring.lineno - 1, (docstring.end_lineno or docstring.lineno) - 1
        after = lines[last][docstring.end_col_offset :]
        before = lines[first][: docstring.col_offset]
        lines[first : last + 1] = [before + instead + b"\n" * (last - first) + after]
        lines[first + 1 : first + 1] = [b""] * (last - first)  # the numbers of those below stay
    return b"".join(lines)


def _docstrings(tree: ast.Module) -> Iterator[tuple[ast.Expr, bytes]]:
    for node in ast.walk(tree):
        instead = _EMPTY.get(type(node))
        body = getattr(node, "body", None)
        if instead is None or not body or not isinstance(first := body[0], ast.Expr):
            continue
        if any(ast.unparse(base).endswith("Enum") for base in getattr(node, "bases", ())):
            continue
        if isinstance(first.value, ast.Constant) and isinstance(first.value.value, str):
            yield first, instead
