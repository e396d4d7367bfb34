"""The Python interface: a page a module, which mkdocstrings fills from the docstrings."""

from __future__ import annotations

from dataclasses import dataclass
from importlib import import_module

from mikas.i18n import Language, Text


@dataclass(frozen=True, slots=True)
class Module:
    """A module with a page. `names`: its `__all__`, or its errors, if none are given."""

    name: str
    about: Text
    names: tuple[str, ...] = ()

    @property
    def identifiers(self) -> list[str]:
        """The full names, in the order of the page."""
        return [f"{self.name}.{each}" for each in self.names or self._public]

    @property
    def _public(self) -> list[str]:
        module = import_module(self.name)
        errors = [
            name
            for name, each in vars(module).items()
            if isinstance(each, type) and issubclass(each, Exception)
        ]
        return list(getattr(module, "__all__", errors))


PAGES = (
    Module(
        "mikas",
        Text(
            "What a program needs: a connected unit, its values and faults, recordings.",
            "То, что нужно программе: подключённый блок, его значения и ошибки, записи.",
        ),
        (
            "connect", "open", "Ecu", "AsyncEcu", "Reading", "Sample", "Recording", "Passport",
            "Info", "Change", "Parameter", "Fault",
        ),
    ),
    Module(
        "mikas.client",
        Text("The connected unit in full.", "Подключённый блок полностью."),
        (
            "Memory", "MemorySpace", "Run", "Written", "WrittenParameter", "Erased", "Limits",
            "Support", "Method", "Answer", "ScannedCode", "AsyncMemory", "AsyncMemorySpace",
            "AsyncItems",
        ),
    ),
    Module(
        "mikas.catalog",
        Text("Parameters, derived channels, faults.", "Параметры, производные каналы, ошибки."),
        (
            "shipped", "load", "Catalog", "Derived", "Conversion", "AlarmLimits", "Meaning",
            "Model", "Erratum", "Confidence", "Level",
        ),
    ),
    Module(
        "mikas.recording.table.channels",
        Text("The columns and rows of a recording.", "Столбцы и строки записи."),
        ("Channel", "Rows"),
    ),
    Module(
        "mikas.notebook.drawing",
        Text("What `Recording.plot` returns.", "То, что возвращает `Recording.plot`."),
        ("Plot",),
    ),
    Module(
        "mikas.link",
        Text(
            "The line: what carries bytes, and whose clock it is.",
            "Линия: что переносит байты и чьи это часы.",
        ),
    ),
    Module(
        "mikas.framing",
        Text("Bytes and frames (§2).", "Байты и кадры (§2)."),
        ("checksum", "stuff", "unstuff", "encode", "Decoder", "Frame", "Damage", "DamageReason"),
    ),
    Module(
        "mikas.errors",
        Text("What can go wrong: one tree.", "Что может пойти не так: одно дерево."),
    ),
)  # fmt: skip
# Its table is of a base class that has no page of its own.
_WITH_INHERITED = frozenset({"mikas.Recording"})
_INHERITED = "    options:\n      inherited_members: true\n"
_ENGLISH = Text("", "Описания взяты из программы, поэтому они на английском языке.\n\n")


def path_of(module: Module) -> str:
    """Return the path of a module's page."""
    return f"reference/python/{module.name}.md"


def python_page(module: Module, language: Language) -> str:
    """Return a module's page."""
    names = "\n".join(
        f"::: {each}\n{_INHERITED if each in _WITH_INHERITED else ''}"
        for each in module.identifiers
    )
    about = f"{module.about.to(language)}\n\n{_ENGLISH.to(language)}"
    return f"# {module.name}\n\n{about}{names}"
