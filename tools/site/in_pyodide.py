"""What runs in Pyodide at build, by run.mjs: compiling sources, trying the result."""

import gzip
import importlib.util
import io
import sys
import zipfile
from importlib import _bootstrap_external, import_module


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
