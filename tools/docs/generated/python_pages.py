"""The reference of the library: a page a module, from its names, their members and docstrings.

English only: the texts are the program's. On the Russian site the introduction is in Russian.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from importlib import import_module

from mikas.errors import MikasError
from mikas.i18n import Language, Text
from tools.docs.checking.citations import CITED, anchor_of
from tools.docs.generated.error_fields import MEANINGS
from tools.docs.generated.python_members import Field, Method, Name, documented
from tools.docs.generated.tables import code, table
from tools.docs.markdown import slug_of


@dataclass(frozen=True, slots=True)
class Module:
    """A module with a page. `only`: its names there; none: its `__all__`, less those before."""

    name: str
    about: Text
    only: tuple[str, ...] = ()
    but: tuple[str, ...] = ()

    @property
    def names(self) -> tuple[Name, ...]:
        """The names of the page, in its order."""
        return _names(self)


@cache
def _names(module: Module) -> tuple[Name, ...]:
    if module.only:
        return tuple(Name(module.name, each) for each in module.only)
    public = getattr(import_module(module.name), "__all__", None) or _defined_in(module.name)
    return tuple(Name(module.name, each) for each in public if each not in module.but)


def _defined_in(module: str) -> list[str]:
    """Return the public names of a module or package without a list of them."""
    return [
        name
        for name, each in vars(import_module(module)).items()
        if not name.startswith("_") and str(getattr(each, "__module__", "")).startswith(module)
    ]


_OF_MIKAS = (
    "Reading", "Sample", "Passport", "Info", "Change", "connect", "Ecu", "AsyncEcu",
)  # fmt: skip
PAGES = (
    Module(
        "mikas",
        Text(
            "What a program needs: a connected unit, its values and faults, a sampling session, "
            "recordings.",
            "То, что нужно программе: подключённый блок, его значения и ошибки, сеанс опроса, "
            "записи.",
        ),
        (
            "connect", "Ecu", "AsyncEcu", "Reading", "Sample", "Passport", "Info", "Change",
            "Parameter", "Fault", "session", "Session", "async_session", "AsyncSession", "open",
            "Recording", "MikasError",
        ),
    ),
    Module(
        "mikas.client",
        Text("The connected unit in full.", "Подключённый блок полностью."),
        but=_OF_MIKAS,
    ),
    Module(
        "mikas.survey",
        Text(
            "A survey of a real unit, and the file that it makes.",
            "Обследование настоящего блока и файл с результатом.",
        ),
    ),
    Module(
        "mikas.sampling.events",
        Text(
            "What a session reports: samples, gaps, states of the line, alarms, faults.",
            "О чём сообщает сеанс опроса: значения, разрывы, состояния линии, выходы за пределы, "
            "ошибки.",
        ),
        (
            "Event", "Sampled", "CycleFailed", "Gap", "StateChanged", "LineState", "AdapterMoved",
            "ClockChanged", "UnitFound", "PlanChanged", "MethodChosen", "ParameterDropped",
            "ParameterReturned", "AlarmChanged", "FaultReading", "Marker", "TextNote",
        ),
    ),
    Module(
        "mikas.sampling.plan",
        Text("What a session requests.", "Что запрашивает сеанс опроса."),
        ("Plan", "PlannedParameter"),
    ),
    Module(
        "mikas.client.identity",
        Text("The identity of a unit.", "Чем различаются блоки."),
        ("UnitIdentity",),
    ),
    Module(
        "mikas.recording.recorder",
        Text("The progress of a recording.", "Ход записи."),
        ("RecordingStatus",),
    ),
    Module(
        "mikas.recording.table.channels",
        Text("The columns and rows of a recording.", "Столбцы и строки записи."),
        ("Channel", "Rows"),
    ),
    Module(
        "mikas.recording.export",
        Text("A recording as a file for other programs.", "Запись как файл для других программ."),
        ("export", "formats", "Result", "Dialect"),
    ),
    Module(
        "mikas.recording.export.sheet",
        Text(
            "What a format of your own gets to write.",
            "То, что получает для записи ваш собственный формат.",
        ),
        ("Sheet", "Moment"),
    ),
    Module(
        "mikas.foreign_logs",
        Text("Logs of other programs as tables.", "Логи других программ как таблицы."),
    ),
    Module(
        "mikas.drives",
        Text("Drives in a recording, and their sums.", "Поездки в записи и их суммы."),
    ),
    Module(
        "mikas.notebook.drawing",
        Text("What `Recording.plot` returns.", "То, что возвращает `Recording.plot`."),
        ("Plot",),
    ),
    Module(
        "mikas.catalog",
        Text("Parameters, derived channels, faults.", "Параметры, производные каналы, ошибки."),
        but=("Parameter", "Fault"),
    ),
    Module(
        "mikas.instruments",
        Text(
            "Instruments beside the unit: definitions, and decoders from bytes to values.",
            "Приборы рядом с блоком: описания и декодеры, от байтов к значениям.",
        ),
    ),
    Module(
        "mikas.commands",
        Text(
            "The commands of §3: the bytes of each request, and what a response means.",
            "Команды §3: байты каждого запроса и смысл ответа.",
        ),
    ),
    Module(
        "mikas.framing",
        Text("Bytes and frames (§2).", "Байты и кадры (§2)."),
        ("checksum", "stuff", "unstuff", "encode", "Decoder", "Frame", "Damage", "DamageReason"),
    ),
    Module(
        "mikas.link",
        Text(
            "The line: what carries bytes, and whose clock it is.",
            "Линия: что переносит байты и чьи это часы.",
        ),
    ),
    Module(
        "mikas.testing",
        Text(
            "A virtual unit for tests, and the suite for links of your own.",
            "Виртуальный блок для тестов и набор тестов для собственных портов.",
        ),
    ),
    Module(
        "mikas.testing.plugin",
        Text("The fixtures of pytest.", "Фикстуры pytest."),
        ("car", "virtual_ecu"),
    ),
    Module(
        "mikas.i18n",
        Text("Texts in two languages.", "Тексты на двух языках."),
        ("Text",),
    ),
    Module(
        "mikas.errors",
        Text("What can go wrong: one tree.", "Что может пойти не так: одно дерево."),
        but=("MikasError", "PortKind"),
    ),
)  # fmt: skip
_ENGLISH = Text("", "Описания взяты из программы, поэтому они на английском языке.\n\n")
_REFERENCE = re.compile(r"(?<![\[`])`([A-Za-z_][\w.]*)(?:\(\))?`(?!`)")


def path_of(module: Module) -> str:
    """Return the path of a module's page."""
    _, _, last = module.name.partition(".")
    return f"reference/python/{last.replace('.', '-') or 'package'}.md"


def python_page(module: Module, language: Language) -> str:
    """Return a module's page."""
    linked = _Linked(module)
    head = f"# {module.name}\n\n{cited(module.about.to(language))}\n\n{_ENGLISH.to(language)}"
    if module.name == "mikas.errors":
        head += f"{linked.text(import_module(module.name).__doc__ or '')}\n\n"
    return head + "\n".join("\n".join(_about(name, linked)) for name in module.names)


@cache
def places() -> dict[str, str]:
    """Return where each name, and each member `Class.member`, is described: page and anchor."""
    found: dict[str, str] = {}
    for module in PAGES:
        page = path_of(module).rpartition("/")[2]
        for name in module.names:
            if isinstance(name.value, type):
                documented.add(name.value)
            for word in (name.name, f"{name.module}.{name.name}", f"mikas.{name.name}"):
                found.setdefault(word, f"{page}#{slug_of(name.name)}")
    for module in PAGES:
        page = path_of(module).rpartition("/")[2]
        for name in module.names:
            for method in name.methods:
                heading = f"{name.name}.{method.name}"
                found.setdefault(heading, f"{page}#{slug_of(heading)}")
    return found


class _Linked:
    """Docstrings as Markdown, with links from the names in them to their places."""

    def __init__(self, module: Module) -> None:
        self._page = path_of(module).rpartition("/")[2]

    def text(self, doc: str, within: str = "") -> str:
        """Return a docstring; blocks of code in it stay."""
        return "\n".join(
            line if line.startswith("    ") else self.line(line, within)
            for line in doc.strip().splitlines()
        )

    def line(self, line: str, within: str = "") -> str:
        """Return a line with its links. `within`: the class, whose methods need not name it."""
        line = line.replace("<", "&lt;") if "`" not in line else line

        def link(match: re.Match[str]) -> str:
            word = match[1]
            place = places().get(word) or places().get(f"{within}.{word}")
            if place is None or word == within:
                return match[0]
            return f"[{match[0]}]({place.removeprefix(self._page)})"

        return cited(_REFERENCE.sub(link, line))


def cited(line: str) -> str:
    """Return a line with a link from each clause that it cites, but within code."""
    parts = re.split(r"(`[^`]*`)", line)
    return "".join(part if part.startswith("`") else CITED.sub(_to_clause, part) for part in parts)


def _to_clause(match: re.Match[str]) -> str:
    return f"[{match[0]}](../../protocol.md#{anchor_of(match)})"


def _about(name: Name, linked: _Linked) -> Iterator[str]:
    yield f"## {name.name}\n"
    bases = name.bases if isinstance(name.value, type) else ()
    of = f" of {', '.join(linked.line(code(each)) for each in bases)}" if bases else ""
    yield f"*{name.kind}*{of}, `{name.module}.{name.name}`\n"
    if name.kind == "constant":
        yield f"```text\n{name.name} = {_shown(name.value)}\n```\n"
    elif definition := name.definition:
        yield _code(definition)
    yield f"{linked.text(name.doc, name.name)}\n"
    if name.kind == "error":
        yield from _about_error(name, linked)
    if name.sentences:
        yield "Its tests:\n"
        yield "".join(f"- {each}\n" for each in name.sentences)
    if name.members:
        rows = [(code(each.name), code(each.default), linked.line(_flat(each.doc)))
                for each in name.members]  # fmt: skip
        yield table("en", ("member|value|meaning", ""), rows)
    if fields := _own(name):
        yield table("en", ("field|type|default|meaning", ""), (_row(each, name.name, linked)
                                                              for each in fields))  # fmt: skip
    for method in name.methods:
        yield from _about_method(name, method, linked)


def _own(name: Name) -> list[Field]:
    """Return the fields to list: of an error, without those that are its texts."""
    if name.kind != "error" or name.name == "MikasError":
        return list(name.fields)
    of_texts = ("what", "advice", "defaults", "more_fields")
    return [each for each in name.fields if each.name not in of_texts]


def _about_error(name: Name, linked: _Linked) -> Iterator[str]:
    error = name.value
    if not isinstance(error, type) or not issubclass(error, MikasError):
        return
    if error.what.en != "{problem}" and error is not MikasError:
        yield cited(f"> {error.what.en}. {error.advice.en}".rstrip()) + "\n"
    found = error.field_names()
    rows = [(code(each), linked.line(MEANINGS[each])) for each in sorted(found)]
    if rows:
        yield table("en", ("`fields`|meaning", ""), rows)


def _about_method(name: Name, method: Method, linked: _Linked) -> Iterator[str]:
    yield f"### {name.name}.{method.name}\n"
    yield _code(method.signature)
    yield f"{linked.text(method.doc, name.name)}\n"


def _row(field: Field, within: str, linked: _Linked) -> tuple[str, ...]:
    return (
        code(field.name),
        code(field.annotation),
        code(field.default),
        linked.line(_flat(field.doc), within),
    )


def _flat(doc: str) -> str:
    return " ".join(doc.split())


def _code(definition: str) -> str:
    return f"```python no-run\n{definition}\n```\n"


def _shown(value: object) -> str:
    text = repr(value).replace("typing.", "")
    return text if len(text) < 200 else f"{text[:200]}…"
