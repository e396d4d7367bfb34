"""Every page is in the navigation; a Russian page is built like the English one.

Built alike: headings of the same levels, the same blocks of code, pictures and links, in the same
order. So a change of one that was forgotten in the other is found.
"""

from __future__ import annotations

import ast
import re
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import PurePosixPath
from urllib.parse import unquote

from tools.docs.checking.finding import Finding
from tools.docs.checking.sessions import commands_of
from tools.docs.generated.writing import of_the_site
from tools.docs.markdown import Code, Document, Link
from tools.docs.navigation import entries
from tools.docs.pages import DOCS, ROOT, RUSSIAN, document, files, led_to, path_of
from tools.docs.waiting import AWAITED, UNTRANSLATED

_NAVIGATION = PurePosixPath("tools/docs/navigation.py")
_WAITING = PurePosixPath("tools/docs/waiting.py")


def findings() -> Iterator[Finding]:
    """Yield what is wrong with the set of pages, and with the translations."""
    english, russian = ({path_of(file) for file in files(language)} for language in ("en", "ru"))
    listed = Counter(entry.path for entry in entries())
    made = of_the_site("en").keys()
    for path in sorted((english | made) - set(listed)):
        yield Finding(DOCS / path, 1, f"in no navigation: {_NAVIGATION}")
    for path, times in listed.items():
        if times > 1:
            yield Finding(_NAVIGATION, 1, f"{path} is there {times} times")
        if path not in english | AWAITED | made:
            yield Finding(_NAVIGATION, 1, f"{path}: no such page")
    for path in sorted(AWAITED & english):
        yield Finding(_WAITING, 1, f"{path} has come: take it out of AWAITED")
    for path in sorted(UNTRANSLATED & russian):
        yield Finding(_WAITING, 1, f"{path} is translated: take it out of UNTRANSLATED")
    for path in sorted(english - russian - UNTRANSLATED - of_the_site("ru").keys()):
        yield Finding(DOCS / path, 1, f"no translation: {RUSSIAN / path}")
    for path in sorted(russian - english):
        yield Finding(RUSSIAN / path, 1, f"no English page: {DOCS / path}")
    for path in sorted(russian & english):
        yield from translated(DOCS / path, RUSSIAN / path)


def translated(english: PurePosixPath, russian: PurePosixPath) -> Iterator[Finding]:
    """Yield where the Russian page is built in another way than the English one."""
    ours, theirs = document(russian), document(english)
    for what, there, here in (
        (
            "headings",
            [each.level for each in theirs.headings],
            [each.level for each in ours.headings],
        ),
        ("code", _code(theirs), _code(ours)),
        ("pictures", _places(english, pictures=True), _places(russian, pictures=True)),
        ("links", _places(english, pictures=False), _places(russian, pictures=False)),
    ):
        if there != here:
            yield Finding(russian, 1, f"{what}: not as in {english}: {_difference(there, here)}")


def _code(page: Document) -> list[object]:
    """Return each block's language with what is not translated in it.

    Of a session that are the commands, not their output; of Python all but comments, texts and the
    language of a `Text`.
    """
    return [_untranslated(code) for code in page.code]


def _untranslated(code: Code) -> object:
    if code.language == "console":
        return (code.language, *commands_of(code.text))
    if code.language == "python":
        return (code.language, _without_texts(code.text))
    return code.language


def _without_texts(text: str) -> str:
    """Return Python without comments, and without texts that may be translated: with a space."""
    try:
        tree = ast.parse(text)
    except SyntaxError:
        return text  # its own check says so
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and " " in node.value:
            node.value = "…"
        elif isinstance(node, ast.Attribute) and node.attr == "ru":
            node.attr = "en"
    return ast.unparse(tree)


def _places(file: PurePosixPath, *, pictures: bool) -> list[str]:
    """Return where the links lead, in a form that is the same in both languages."""
    found = [
        _place(file, link)
        for link in document(file).links
        if link.picture == pictures and not link.external
    ]
    # A sentence may have its links in another order.
    return sorted(found)


def _place(file: PurePosixPath, link: Link) -> str:
    place = led_to(file, link)
    anchor = _heading(place, unquote(link.anchor)) if link.anchor else ""
    if place.is_relative_to(RUSSIAN):
        place = DOCS / place.relative_to(RUSSIAN)
    name = re.sub(r"^docs/pictures/ru/", "docs/pictures/en/", place.as_posix())
    return f"{name}{anchor}"


def _heading(place: PurePosixPath, anchor: str) -> str:
    """Return which heading of a page an anchor means: in each language it has other words."""
    if place.suffix != ".md" or not (ROOT / place).is_file():
        return "#"
    anchors = [each.anchor for each in document(place).headings]
    return f"#{anchors.index(anchor)}" if anchor in anchors else f"#{anchor}"


def _difference(there: Sequence[object], here: Sequence[object]) -> str:
    """Return the first place at which two lists differ, or what one has in excess."""
    for number, (expected, found) in enumerate(zip(there, here, strict=False), 1):
        if expected != found:
            return f"number {number} is {found!r}, there {expected!r}"
    return f"{len(here)} here, {len(there)} there"
