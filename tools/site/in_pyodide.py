"""What runs in Pyodide at build, by run.mjs: compiling sources, trying the result."""

import gzip
import importlib.util
import io
import sys
import types
import zipfile
from importlib import _bootstrap_external, import_module


def compile_archive(before: str, after: str, level: int) -> None:
    """Compile every `a.py` of the archive `before` into `a.pyc` of the archive `after`.

    A module gets the name of its file in the archive, whatever folder it will be in. What is
    optimized (`level` 2), which is others' code, names in a traceback the line of the function's
    head instead of the instruction's: the tables of lines would be 4 % of the whole site.
    """
    with zipfile.ZipFile(before) as sources, zipfile.ZipFile(after, "w") as bytecode:
        for name in sources.namelist():
            source = sources.read(name)
            code = compile(source, name, "exec", dont_inherit=True, optimize=level)
            if level == 2:
                code = _with_heads_alone(code)
            # What py_compile calls, which writes files only.
            content = _bootstrap_external._code_to_hash_pyc(  # type: ignore[attr-defined]  # noqa: SLF001
                code, importlib.util.source_hash(source), checked=False
            )
            bytecode.writestr(name + "c", bytes(content))


def _with_heads_alone(code: types.CodeType) -> types.CodeType:
    """Return `code` with the line of its head for all its instructions, functions in it too.

    An entry of a line table is of up to eight units of bytecode: its first byte has the highest bit
    set, then its kind, 13 (a line without columns), and the units less one; what follows is the
    step from the line before, 0 (InternalDocs/code_objects.md of CPython).
    """
    whole, rest = divmod(len(code.co_code) // 2, 8)
    table = bytes((0x80 | 13 << 3 | 7, 0)) * whole
    if rest:
        table += bytes((0x80 | 13 << 3 | rest - 1, 0))
    inner = (
        _with_heads_alone(it) if isinstance(it, types.CodeType) else it for it in code.co_consts
    )
    return code.replace(co_linetable=table, co_consts=tuple(inner))


def import_all(pack: str, left_out: list[str]) -> None:
    """Import every module of mikas in the archive `pack`; raises `ImportError` with all failures.

    As a worker has them: with arrays instead of numpy.
    """
    with open(pack, "rb") as file:  # noqa: PTH123 (no more imports than needed)
        archive = zipfile.ZipFile(io.BytesIO(gzip.decompress(file.read())))
    archive.extractall("/program")
    sys.path.insert(0, "/program")
    import_module("mikas.browser.arrays").install()
    failures = []
    for name in sorted(archive.namelist()):
        module = name.removesuffix(".pyc").removesuffix("/__init__").replace("/", ".")
        if name.endswith(".pyc") and module.startswith("mikas") and module not in left_out:
            try:
                import_module(module)
            except ImportError as error:
                failures.append(f"{module}: {error}")
    if failures:
        raise ImportError("\n".join(failures))
