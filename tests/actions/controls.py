"""What a person can press on the page, found in its sources: buttons, links, items of menus.

A control is named by its file and the key of its text: `live/Screen edit`; where the text is no
message of the page, by the expression: `basic/Tabs {tab.title}`. The English text is that of the
page's own dictionaries, with any words in place of what it names.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path

WEB = Path(__file__).parents[2] / "web" / "src"
FOLDERS = ("screens", "components")
TAGS = r"Button|button|a|summary|Tabs|Menu|Confirm|ConfirmChange|ConfirmDelete"
ROLES = {"a": "link", "summary": "", "Tabs": "tab"}
UNNAMED = re.compile(r" Confirm(Change|Delete)?$")
_STRING = r'"(?:[^"\\]|\\.)*"'
_MESSAGE = re.compile(rf"(\w+):\s*\{{\s*en:\s*({_STRING}|\{{(?:[^{{}}\"]|{_STRING})*\}})")
_IMPORT = re.compile(r'import \{([^}]*)\} from "(\.[^"]*)"')
_COMMAND = re.compile(r"^(?!.*\bcode: ).*\b(?:text: (?=.*\brun: )|label: )(.*)", re.MULTILINE)
"""An item of a menu, or one of a row of buttons, where a script lists them. Not a key's."""
_SNIPPET = re.compile(r'\{@render verb\("\w+", ([^,]*)')
_VERB = re.compile(r"\bverb=(\{(?:[^{}]|\{[^{}]*\})*\})")
_CALL = re.compile(r'(?<!\$)\b(\w+)\((?:[^()"]*\? )?"(\w+)"(?: : "(\w+)")?')


@dataclass(frozen=True)
class Control:
    """`role`: an element's, or nothing where it has none; `name`: None where the data give it."""

    role: str
    name: re.Pattern[str] | None


@cache
def controls() -> dict[str, Control]:
    """Return them all. That of a confirmation is its verb, where it has one of its own."""
    found = {name: control for file in _files() for name, control in _of(file)}
    return {name: it for name, it in found.items() if not UNNAMED.search(name)}


def _files() -> Iterator[Path]:
    for folder in FOLDERS:
        for file in sorted((WEB / folder).rglob("*.svelte")):
            if file.parent.name != "basic":  # what others give a name
                yield file


def _of(file: Path) -> Iterator[tuple[str, Control]]:
    source = re.sub(r"<style.*?</style>|<!--.*?-->", "", file.read_text("utf-8"), flags=re.DOTALL)
    script = "".join(re.findall(r"<script.*?</script>", source, re.DOTALL))
    markup = re.sub(r"<script.*?</script>", "", source, flags=re.DOTALL)
    texts = _dictionaries(file, script)
    place = file.relative_to(WEB).with_suffix("").as_posix().partition("/")[2]
    said = [(_role(tag, more), _name_of(tag, more, body)) for tag, more, body in _elements(markup)]
    listed = (it for it in _COMMAND.findall(script) if _CALL.search(it))
    said += [("link" if "href: " in it else "button", it) for it in listed]
    said += [("button", it) for it in _SNIPPET.findall(markup)]
    for role, each in said:
        calls = ((f, key) for f, *both in _CALL.findall(each) for key in both if key)
        found = [(f, key) for f, key in calls if f in texts]
        known = [texts[f][key] for f, key in found if key in texts[f]]
        if len(known) < len(found) or not found:
            yield f"{place} {' '.join(each.split())}", Control(role, None)
        else:
            for (_, key), text in zip(found, known, strict=True):
                yield f"{place} {key}", Control(role, text)


def _role(tag: str, attributes: str) -> str:
    return "link" if re.search(r"\bhref=", attributes) else ROLES.get(tag, "button")


def _elements(markup: str) -> Iterator[tuple[str, str, str]]:
    """Yield the tag, attributes and content of each element that is pressed."""
    for found in re.finditer(rf"<({TAGS})\b", markup):
        end, depth = found.end(), 0
        while depth or markup[end] != ">":
            depth += {"{": 1, "}": -1}.get(markup[end], 0)
            end += 1
        alone = markup[end - 1] == "/"
        stop = end if alone else markup.index(f"</{found[1]}", end)
        yield found[1], markup[found.end() : end].rstrip("/"), markup[end + 1 : stop]


def _name_of(tag: str, attributes: str, body: str) -> str:
    """Return the expression that names an element: a label, or how its content begins."""
    if tag.startswith("Confirm"):
        return verb[1] if (verb := _VERB.search(attributes)) else tag
    for name in ("aria-label", "label"):
        if at := re.search(rf'(?<![-\w]){name}=("[^"]*"|\{{)', attributes):
            return at[1].strip('"') if at[1] != "{" else _braced(attributes, at.end() - 1)
    bare = re.sub(r"\{#.*?\}|\{:.*?\}|\{/.*?\}|\{@.*?\}", "", re.sub(r"<[^<>]*>", " ", body))
    if said := bare.strip():
        begin = said.find("{")
        return said if begin < 0 else said[:begin] + _braced(said, begin)
    return tag


def _braced(text: str, at: int) -> str:
    end, depth = at + 1, 1
    while depth:
        depth += {"{": 1, "}": -1}.get(text[end], 0)
        end += 1
    return text[at:end]


def _dictionaries(file: Path, script: str) -> dict[str, dict[str, re.Pattern[str]]]:
    """Return the messages of each function that gives texts in `file`."""
    found = {}
    for names, path in _IMPORT.findall(script):
        module = (file.parent / f"{path}.ts").resolve()
        for name in names.split(","):
            theirs, _, own = name.strip().partition(" as ")
            if theirs in ("t", "screenTitle") and module.is_file():
                found[own or theirs] = _messages(module.read_text("utf-8"))
    for name in re.findall(r"const (\w+) = dictionary\b", script):
        found[name] = _messages(script)
    return found


def _messages(source: str) -> dict[str, re.Pattern[str]]:
    return {key: _pattern(text) for key, text in _MESSAGE.findall(source)}


def _pattern(text: str) -> re.Pattern[str]:
    """Return what an English text looks like; of several forms, any."""
    forms = [re.sub(r"\\(.)", r"\1", it[1:-1]) for it in re.findall(_STRING, text)]
    each = (re.sub(r"\\\{\w+\\\}", ".+?", re.escape(it).replace("\\ ", " ")) for it in forms)
    return re.compile("|".join(f"^{it}$" for it in each))
