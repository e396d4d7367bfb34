"""Compiles an archive of sources. Runs in Pyodide (compile.mjs), not here."""

import importlib.util
import zipfile
from importlib import _bootstrap_external


def compile_archive(before: str, after: str, level: int) -> None:
    """Compile every `a.py` of the archive `before` into `a.pyc` of the archive `after`.

    A module gets the name of its file in the archive, whatever folder it will be in.
    """
    with zipfile.ZipFile(before) as sources, zipfile.ZipFile(after, "w") as bytecode:
        for name in sources.namelist():
            source = sources.read(name)
            code = compile(source, name, "exec", dont_inherit=True, optimize=level)
            # What py_compile calls, which writes files only.
            content = _bootstrap_external._code_to_hash_pyc(  # type: ignore[attr-defined]  # noqa: SLF001
                code, importlib.util.source_hash(source), checked=False
            )
            bytecode.writestr(name + "c", bytes(content))
