"""Imports of mikas' own modules that the site's Python lacks.

The build imports every module there, so an import at a module's head can't be missing. One within a
function is reached when a person presses the button that needs it: the sources are searched for it.
An import that is reached only where its package exists stands in `DESKTOP`, with the reason.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from types import MappingProxyType

from tools.site import packages

_PLACES = "on Windows and macOS, which have no XDG folders"
_TLS = "for the network's HTTPS, which the site does not serve"
_NETWORK = "where there are sockets: a page's actions have none"
_NUMPY = "if there is the whole numpy"
_UNIT = "for a unit from a file of this computer"
_NOTEBOOK = "for a notebook, which shows and draws `mikas.open`"
_MDF = "if there is asammdf"
DESKTOP: Mapping[str, Mapping[str, str]] = MappingProxyType(
    {
        "mikas/home.py": {"platformdirs": _PLACES},
        "mikas/conditions/performing.py": {
            "mikas.conditions.messages": _NETWORK,
            "mikas.conditions.webhooks": _NETWORK,
        },
        "mikas/dashboard/security/certificate.py": {"cryptography": _TLS},
        "mikas/foreign_logs/apart.py": {"multiprocessing": _MDF},
        "mikas/foreign_logs/opening.py": {"mikas.foreign_logs.mdf": _MDF},
        "mikas/link/ports.py": {"serial": "lists the system's ports; the site lists the browser's"},
        "mikas/notebook/recording.py": {"mikas.notebook": _NOTEBOOK},
        "mikas/recording/exchanges/__init__.py": {"mikas.recording.exchanges.columns": _NUMPY},
        "mikas/replay/build.py": {"mikas.replay.routine": _NUMPY},
        "mikas/virtual/build.py": {"mikas.virtual.met_unit": _UNIT},
        "mikas/virtual/serve.py": {"pty": "serves a virtual unit", "tty": "serves a virtual unit"},
    }
)


@dataclass(frozen=True, slots=True)
class LateImport:
    """An import within a function. `names`: modules, of which a `from` names several."""

    file: str
    line: int
    names: tuple[str, ...]

    def is_expected(self, name: str) -> bool:
        """Whether this import of `name` is reached only where there is such a module."""
        parts = name.split(".")
        heads = {".".join(parts[:count]) for count in range(1, len(parts) + 1)}
        return not heads.isdisjoint(DESKTOP.get(self.file, {}))


def missing(files: Mapping[str, bytes], has: Callable[[str], bool]) -> Iterator[str]:
    """Yield the place and name of each late import that `has` lacks and no list expects."""
    for each in late_imports(files):
        for name in each.names:
            if not has(name) and not each.is_expected(name):
                yield f"{each.file}:{each.line}: {name}"


def late_imports(files: Mapping[str, bytes]) -> Iterator[LateImport]:
    """Yield the imports within functions of the Python files."""
    for file, content in files.items():
        if file.endswith(".py"):
            tree = ast.parse(content)
            for node in _reached_late(tree.body, late=False):
                yield LateImport(file, node.lineno, _names(node))


def _reached_late(body: Iterable[ast.AST], *, late: bool) -> Iterator[ast.Import | ast.ImportFrom]:
    for node in body:
        if isinstance(node, ast.Import | ast.ImportFrom):
            if late:
                yield node
        elif isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test):
            continue
        elif isinstance(node, ast.Try) and any(map(_catches_its_absence, node.handlers)):
            rest = (*node.handlers, *node.orelse, *node.finalbody)
            yield from _reached_late(rest, late=late)
        else:
            within = isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)
            yield from _reached_late(ast.iter_child_nodes(node), late=late or within)


def _catches_its_absence(handler: ast.ExceptHandler) -> bool:
    caught = "" if handler.type is None else ast.unparse(handler.type)
    return "ImportError" in caught or "ModuleNotFoundError" in caught


def _names(node: ast.Import | ast.ImportFrom) -> tuple[str, ...]:
    """Return the modules that are imported, with those of mikas that a `from` may name."""
    if isinstance(node, ast.Import):
        return tuple(alias.name for alias in node.names)
    module = node.module or ""
    below = (f"{module}.{alias.name}" for alias in node.names)
    return (module, *(name for name in below if _is_module(name)))


def _is_module(name: str) -> bool:
    """Whether mikas has this module, in the site or not."""
    path = packages.ROOT.joinpath("src", *name.split("."))
    return path.with_suffix(".py").is_file() or path.is_dir()
