"""A part of a library that is private there may change with any version: so each use is listed
here, and the package has a cap in pyproject.toml with the part's name beside it.
"""

from __future__ import annotations

import ast
import inspect
import re
import sys
import tomllib
from collections.abc import Callable, Iterable, Iterator
from functools import cache, partial
from importlib import import_module
from operator import attrgetter
from pathlib import Path

import pytest
from packaging.requirements import Requirement

ROOT = Path(__file__).parent.parent
SOURCE = ROOT / "src" / "mikas"
PYPROJECT = (ROOT / "pyproject.toml").read_text("utf-8")
_PRIVATE = re.compile("_[a-z_]*[A-Za-z]")
_PUBLIC = {"_asdict", "_exit", "_replace"}  # documented, of named tuples and of `os`
_OWN_PYTHON = "browser/"  # it takes the place of parts of one Python, which the site brings itself
_KINDS = (
    ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef, ast.arg, ast.Name, ast.Attribute,
    ast.Import, ast.ImportFrom, ast.Call,
)  # fmt: skip
_KNOWN = sys.stdlib_module_names | {"mikas", "_typeshed", "sigrokdecode", "pydantic"}

# By package and file: parts that have an underscore, or that no document has.
USES = {
    "aiomqtt": {"publish/client.py": {"_client"}},
    "paho-mqtt": {
        "publish/client.py": {"_in_messages", "_send_pingreq", "_sock_close", "_sock_recv"}
    },
}
UNDOCUMENTED = {"uvicorn": {"Server._protocol"}}
DISTRIBUTIONS = {"paho": "paho-mqtt", "serial": "pyserial"}  # where the module has another name


Nodes = tuple[ast.AST, ...]


@cache
def files() -> list[tuple[str, Nodes]]:
    names = (path.relative_to(SOURCE).as_posix() for path in sorted(SOURCE.rglob("*.py")))
    mine = [name for name in names if not name.startswith(_OWN_PYTHON)]
    return [(name, nodes_of((SOURCE / name).read_text("utf-8"))) for name in mine]


def nodes_of(source: str) -> Nodes:
    """The nodes of interest."""
    return tuple(node for node in ast.walk(ast.parse(source)) if isinstance(node, _KINDS))


def is_private(name: str) -> bool:
    return _PRIVATE.fullmatch(name) is not None and name not in _PUBLIC


def names_in(nodes: Iterable[ast.AST]) -> set[str]:
    """The private names that a piece of source makes."""
    found = set()
    for node in nodes:
        match node:
            case ast.FunctionDef(name=name) | ast.AsyncFunctionDef(name=name) | ast.arg(arg=name):
                found.add(name)
            case ast.ClassDef(name=name) | ast.Name(id=name, ctx=ast.Store()):
                found.add(name)
            case ast.Attribute(value=ast.Name(id="self" | "cls"), attr=name, ctx=ast.Store()):
                found.add(name)
    return set(filter(is_private, found))


def names_used_in(nodes: Iterable[ast.AST]) -> set[str]:
    used = {node.attr for node in nodes if isinstance(node, ast.Attribute)}
    return set(filter(is_private, used))


@cache
def own_names() -> set[str]:
    return {name for _, nodes in files() for name in names_in(nodes)}


def of_others(nodes: Nodes) -> Iterator[str]:
    """Private names of other packages: used, and made nowhere here; imported; written as texts."""
    yield from names_used_in(nodes) - own_names()
    for node in nodes:
        if isinstance(node, ast.ImportFrom) and node.level == 0 and node.module:
            package = node.module.partition(".")[0]
            names = [*node.module.split("."), *(each.name for each in node.names)]
        elif isinstance(node, ast.Import):
            package, names = "", [it for each in node.names for it in each.name.split(".")]
        elif isinstance(node, ast.Call) and ast.unparse(node.func) in ("getattr", "setattr"):
            texts = (it.value for it in node.args[1:2] if isinstance(it, ast.Constant))
            package, names = "", [str(it) for it in texts if it not in own_names()]
        else:
            continue
        if package not in _KNOWN:
            yield from (it for it in names if is_private(it) and it not in sys.stdlib_module_names)


def of_bases(nodes: Nodes) -> Iterator[tuple[str, str]]:
    """The package and a private name of it that a class here shares with a base from there."""
    modules = foreign_imports(nodes)
    for node in (it for it in nodes if isinstance(it, ast.ClassDef)):
        for base in map(ast.unparse, node.bases):
            first, _, rest = base.partition("[")[0].partition(".")
            if first not in modules:
                continue
            kind = attrgetter(rest)(modules[first]()) if rest else modules[first]()
            inner = [*ast.walk(node)]
            mine = names_in(inner) | names_used_in(inner)
            for each in inspect.getmro(kind) if inspect.isclass(kind) else ():
                package = each.__module__.partition(".")[0]
                if package not in sys.stdlib_module_names:
                    for shared in mine & names_made_by(each):
                        yield DISTRIBUTIONS.get(package, package), shared


def foreign_imports(nodes: Nodes) -> dict[str, Callable[[], object]]:
    """By name in a module, what gets it from its package: of all packages but Python's and ours."""
    found: dict[str, Callable[[], object]] = {}
    for node in nodes:
        if isinstance(node, ast.Import):
            for each in node.names:
                package = each.name.partition(".")[0]
                name = each.name if each.asname else package
                if package not in _KNOWN:
                    found[each.asname or package] = partial(import_module, name)
        elif isinstance(node, ast.ImportFrom) and node.module and node.level == 0:
            for each in node.names:
                if node.module.partition(".")[0] not in _KNOWN:
                    found[each.asname or each.name] = partial(imported, node.module, each.name)
    return found


def imported(module: str, name: str) -> object:
    whole = import_module(module)
    return getattr(whole, name) if hasattr(whole, name) else import_module(f"{module}.{name}")


@cache
def names_made_by(kind: type) -> set[str]:
    classes = (it for it in classes_of(kind.__module__) if it.name == kind.__name__)
    return {name for each in classes for name in names_in(ast.walk(each))}


@cache
def classes_of(module: str) -> list[ast.ClassDef]:
    """The classes of a module; none if its source is not of Python."""
    try:
        tree = ast.parse(inspect.getsource(sys.modules[module]))
    except (OSError, TypeError):
        return []
    return [node for node in ast.walk(tree) if isinstance(node, ast.ClassDef)]


def test_each_private_part_of_a_library_is_listed() -> None:
    found: dict[str, set[str]] = {}
    by_package: dict[str, dict[str, set[str]]] = {}
    for name, nodes in files():
        if parts := set(of_others(nodes)):
            found.setdefault(name, set()).update(parts)
        for package, part in of_bases(nodes):
            by_package.setdefault(package, {}).setdefault(name, set()).add(part)
            found.setdefault(name, set()).add(part)
    listed: dict[str, set[str]] = {}
    for uses in USES.values():
        for name, parts in uses.items():
            listed.setdefault(name, set()).update(parts)
    assert found == listed
    for package, uses in by_package.items():
        for name, parts in uses.items():
            assert parts <= USES[package][name], package


@pytest.mark.parametrize("package", [*USES, *UNDOCUMENTED])
def test_a_package_whose_private_parts_are_used_is_capped_with_the_reason(package) -> None:
    project = tomllib.loads(PYPROJECT)["project"]
    texts = [*project["dependencies"]]
    texts += [text for extra in project["optional-dependencies"].values() for text in extra]
    mine = [text for text in texts if Requirement(text).name == package]
    assert mine, package
    parts = {part for found in USES.get(package, {}).values() for part in found}
    parts |= UNDOCUMENTED.get(package, set())
    for text in mine:
        assert any(it.operator == "<" for it in Requirement(text).specifier), text
        line = next(it for it in PYPROJECT.splitlines() if f'"{text}"' in it and "#" in it)
        assert all(f"`{part}`" in line.partition("#")[2] for part in parts), line
