"""The public members of a module's names: fields, enum members, methods, with their docstrings.

A field's docstring is the string after it, in the class or in `__init__`, or what the docstring of
the class says of it: “`raw`: the bytes as received.”
"""

from __future__ import annotations

import ast
import inspect
import json
import re
from collections.abc import Iterator, Mapping
from dataclasses import MISSING, dataclass, fields, is_dataclass
from enum import Enum
from functools import cache, cached_property
from importlib import import_module
from textwrap import indent
from types import MappingProxyType

_OURS = "mikas."
_PLAIN = frozenset({"object", "ABC", "Generic", "Protocol"})
_SAID = re.compile(
    r"(?P<names>`\w+`(?:(?:, | and )`\w+`)*): (?P<doc>.+?)"
    r"(?=\s`\w+`(?:(?:, | and )`\w+`)*: |\n\n|\Z)",
    re.DOTALL,
)
_BLANK: Mapping[str, str] = MappingProxyType({})


@dataclass(frozen=True, slots=True)
class Field:
    """A value that a class has: a field, a property, a class variable, a member of an enum.

    `default`: as Python writes it; empty: there is none, or none to show.
    """

    name: str
    annotation: str
    default: str
    doc: str


@dataclass(frozen=True, slots=True)
class Method:
    """A method, or a function of a module."""

    name: str
    signature: str
    doc: str


@dataclass(frozen=True)
class Name:
    """A public name of a module."""

    module: str
    name: str

    @cached_property
    def value(self) -> object:
        """The object itself."""
        return getattr(import_module(self.module), self.name)

    @property
    def kind(self) -> str:
        """The word for it: function, class, enum, error, constant, fixture of pytest."""
        value = self.value
        if not isinstance(value, type):
            if type(value).__name__ == "FixtureFunctionDefinition":
                return "fixture"
            return "function" if inspect.isroutine(value) else "constant"
        if issubclass(value, Exception):
            return "error"
        return "enum" if issubclass(value, Enum) else "class"

    @property
    def doc(self) -> str:
        """Its docstring; of a constant the string after it."""
        value = self.value
        if self.kind == "constant":
            return _doc_of_constant(self.module, self.name)
        return inspect.cleandoc(value.__doc__ or "") if value.__doc__ else ""

    @property
    def bases(self) -> tuple[str, ...]:
        """The names of the base classes that are not private."""
        value = self.value
        assert isinstance(value, type)
        names = (each.__name__ for each in value.__bases__)
        hidden = {*_PLAIN, self.name}
        return tuple(each for each in names if not each.startswith("_") and each not in hidden)

    @property
    def definition(self) -> str:
        """How it is called, as Python: `def connect(…) -> Ecu: ...`."""
        value = self.value
        if self.kind == "fixture":
            return ""
        if isinstance(value, type):
            return "" if _called(value) is None else _definition(value, self.name, is_class=True)
        return _definition(value, self.name)

    @cached_property
    def members(self) -> tuple[Field, ...]:
        """The members of an enum."""
        value = self.value
        if not isinstance(value, type) or not issubclass(value, Enum):
            return ()
        docs = _fields_in(value)
        return tuple(
            Field(each.name, "", shown(each.value), docs.get(each.name, ("", ""))[1])
            for each in value
        )

    @property
    def sentences(self) -> tuple[str, ...]:
        """The names of the tests of a suite, as sentences."""
        return tuple(
            name.removeprefix("test_").replace("_", " ")
            for name in (vars(self.value) if isinstance(self.value, type) else ())
            if name.startswith("test_")
        )

    @cached_property
    def fields(self) -> tuple[Field, ...]:
        """The fields and properties of a class, of its own and of bases that have no page."""
        value = self.value
        if not isinstance(value, type):
            return ()
        found: dict[str, Field] = {}
        for owner in _owners(value):
            for field in _fields(owner):
                found.setdefault(field.name, field)
        enumerated = {each.name for each in self.members}
        return tuple(each for name, each in found.items() if name not in enumerated)

    @cached_property
    def methods(self) -> tuple[Method, ...]:
        """The methods of a class, of its own and of bases that have no page.

        An override without a docstring is described where it is introduced, if that has a page.
        """
        value = self.value
        if not isinstance(value, type):
            return ()
        found: dict[str, Method] = {}
        for owner in _owners(value):
            for name, member in vars(owner).items():
                if name.startswith(("_", "test_")) or name in found or not _is_method(member):
                    continue
                function = getattr(owner, name)
                if not function.__doc__ and any(name in vars(each) for each in _paged(owner)):
                    continue
                doc = inspect.getdoc(function) or _inherited_doc(value, name)
                found[name] = Method(name, _definition(function, name, member=member), doc)
        return tuple(found.values())


documented: set[object] = set()
"""The classes that have a page; filled by the pages."""


def _owners(value: type) -> Iterator[type]:
    """Yield the class and its bases of mikas that have no page of their own."""
    for owner in value.__mro__:
        if owner is value or (owner.__module__.startswith(_OURS) and owner not in documented):
            yield owner


def _paged(owner: type) -> Iterator[type]:
    """Yield the bases of a class that have a page."""
    return (each for each in owner.__mro__[1:] if each in documented)


def _is_method(member: object) -> bool:
    if isinstance(member, (staticmethod, classmethod)):
        return True
    return inspect.isfunction(member) or type(member).__name__ == "_Connect"


def _inherited_doc(value: type, name: str) -> str:
    """Return the docstring of the method that this one overrides."""
    for owner in value.__mro__:
        if doc := getattr(vars(owner).get(name), "__doc__", None):
            return inspect.cleandoc(doc)
    return ""


def _fields(owner: type) -> Iterator[Field]:
    given = _fields_in(owner)
    defaults = _defaults(owner)
    for name, (annotation, doc) in given.items():
        if not name.startswith("_"):
            yield Field(name, annotation, defaults.get(name, ""), doc or _inherited(owner, name))
    for name, member in vars(owner).items():
        if name.startswith("_") or name in given:
            continue
        if isinstance(member, (property, cached_property)):
            function = member.fget if isinstance(member, property) else member.func
            annotation = str(function.__annotations__.get("return", "")) if function else ""
            yield Field(name, annotation, "", inspect.getdoc(member) or _inherited(owner, name))


def _inherited(owner: type, name: str) -> str:
    for base in owner.__mro__[1:]:
        if base.__module__.startswith(_OURS) and base is not owner:
            if doc := _fields_in(base).get(name, ("", ""))[1]:
                return doc
            if isinstance(vars(base).get(name), property) and (doc := vars(base)[name].__doc__):
                return inspect.cleandoc(doc)
    return ""


def _defaults(owner: type) -> dict[str, str]:
    found: dict[str, str] = {}
    if is_dataclass(owner):
        for field in fields(owner):
            if field.default is not MISSING:
                found[field.name] = shown(field.default)
            elif field.default_factory is not MISSING:
                found[field.name] = "…"
    elif issubclass(owner, tuple) and hasattr(owner, "_field_defaults"):
        found = {name: shown(each) for name, each in owner._field_defaults.items()}
    return found


@cache
def _tree(module: str) -> ast.Module:
    return ast.parse(inspect.getsource(import_module(module)))


@cache
def _fields_in(owner: type) -> dict[str, tuple[str, str]]:
    """Return annotation and docstring of the fields in the source of a class and its `__init__`."""
    body: list[ast.stmt] = _tree(owner.__module__).body
    for part in owner.__qualname__.split("."):
        inner = next((n for n in body if isinstance(n, ast.ClassDef) and n.name == part), None)
        if inner is None:
            return {}
        body = inner.body
    found = _documented(body, "")
    found = {name: each for name, each in found.items() if not _is_method(vars(owner).get(name))}
    for node in body:
        if isinstance(node, ast.FunctionDef) and node.name == "__init__":
            of_arguments = {
                each.arg: ast.unparse(each.annotation)
                for each in (*node.args.args, *node.args.kwonlyargs)
                if each.annotation
            }
            for name, (annotation, doc) in _documented(node.body, "self").items():
                known, said_there = found.get(name, ("", ""))
                found[name] = (
                    known or annotation or of_arguments.get(name, ""), said_there or doc
                )  # fmt: skip
    said = _said_of(inspect.cleandoc(owner.__doc__ or ""))
    return {
        name: (annotation, doc or said.get(name, "")) for name, (annotation, doc) in found.items()
    }


def _said_of(doc: str) -> dict[str, str]:
    """Return what the docstring of a class says of its fields."""
    return {
        name: " ".join(match["doc"].split())
        for match in _SAID.finditer(doc)
        for name in re.findall(r"`(\w+)`", match["names"])
    }


def _documented(body: list[ast.stmt], of: str) -> dict[str, tuple[str, str]]:
    found: dict[str, tuple[str, str]] = {}
    for node, following in zip(body, [*body[1:], None], strict=True):
        targets: list[ast.expr] = []
        annotation = ""
        if isinstance(node, ast.AnnAssign):
            targets, annotation = [node.target], ast.unparse(node.annotation)
        elif isinstance(node, ast.Assign):
            targets = node.targets
        doc = ""
        if isinstance(following, ast.Expr) and isinstance(following.value, ast.Constant):
            doc = inspect.cleandoc(str(following.value.value))
        for target in targets:
            for each in target.elts if isinstance(target, ast.Tuple) else [target]:
                if of and isinstance(each, ast.Attribute) and ast.unparse(each.value) == of:
                    found[each.attr] = (annotation, doc)
                elif not of and isinstance(each, ast.Name):
                    found[each.id] = (annotation, doc)
    return found


def _doc_of_constant(module: str, name: str) -> str:
    """Return the string after a constant, where it is defined."""
    for source in _sources(module, name):
        if doc := _documented(_tree(source).body, "").get(name, ("", ""))[1]:
            return doc
    return ""


def _sources(module: str, name: str) -> Iterator[str]:
    yield module
    for node in ast.walk(_tree(module)):
        if not isinstance(node, ast.ImportFrom) or not node.module:
            continue
        if any((each.asname or each.name) == name for each in node.names):
            yield from _sources(node.module, name)


def _called(value: type) -> inspect.Signature | None:
    """Return how a class is called; None: it is not made by its users, or as its fields say."""
    if issubclass(value, (Enum, Exception)) or is_dataclass(value) or issubclass(value, tuple):
        return None
    if "__init__" not in vars(value) or getattr(value, "_is_protocol", False):
        return None
    return inspect.signature(value)


def _definition(value: object, name: str, *, is_class: bool = False, member: object = None) -> str:
    assert callable(value)
    signature = inspect.signature(value)
    parameters = [each for each in signature.parameters.values() if not each.name.startswith("_")]
    if parameters and parameters[0].name in ("self", "cls"):
        parameters = parameters[1:]
    parts: list[str] = []
    for number, each in enumerate(parameters):
        before = parameters[number - 1].kind if number else None
        stars_before = (each.KEYWORD_ONLY, each.VAR_POSITIONAL)
        if each.kind is each.KEYWORD_ONLY and before not in stars_before:
            parts.append("*")
        stars = {"VAR_POSITIONAL": "*", "VAR_KEYWORD": "**"}.get(each.kind.name, "")
        annotation = "" if each.annotation is each.empty else f": {_plain(each.annotation)}"
        if each.default is each.empty:
            default = ""
        else:
            default = f"{' = ' if annotation else '='}{shown(each.default)}"
        parts.append(f"{stars}{each.name}{annotation}{default}")
    returned = signature.return_annotation
    if is_class:
        init = _wrapped("def __init__", ["self", *parts], " -> None")
        return f"class {name}:\n{indent(init, '    ')}"
    arrow = "" if returned is signature.empty else f" -> {_plain(returned)}"
    word = "async def" if _is_awaited(value, member) else "def"
    return _wrapped(f"{word} {name}", parts, arrow)


def _wrapped(head: str, parts: list[str], arrow: str) -> str:
    line = f"{head}({', '.join(parts)}){arrow}: ..."
    if len(line) > 88:
        inside = "".join(f"    {part},\n" for part in parts)
        line = f"{head}(\n{inside}){arrow}: ..."
    return line


def _is_awaited(value: object, member: object) -> bool:
    return inspect.iscoroutinefunction(value) or type(member).__name__ == "_Connect"


def _plain(annotation: object) -> str:
    return annotation if isinstance(annotation, str) else inspect.formatannotation(annotation)


def shown(value: object) -> str:
    """Return a default as Python writes it; `...` for what has no short form."""
    if isinstance(value, Enum):
        return f"{type(value).__name__}.{value.name}"
    if value is None or isinstance(value, (bool, int, float, str, bytes, tuple)):
        text = json.dumps(value, ensure_ascii=False) if isinstance(value, str) else repr(value)
        return text if len(text) < 40 else "..."
    return "..."
