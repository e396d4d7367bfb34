"""Every link and every anchor of the Markdown leads somewhere, as GitHub shows it.

A link out of the repository is checked by its form only: nothing is fetched.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import PurePosixPath
from urllib.parse import unquote, urlsplit

from tools.docs.checking.finding import Finding
from tools.docs.markdown import Link
from tools.docs.pages import DOCS, ROOT, RUSSIAN, document, led_to
from tools.docs.waiting import AWAITED, UNTRANSLATED

_MAIL = re.compile(r"mailto:[^@\s]+@[\w.-]+\.\w+")


def findings(file: PurePosixPath) -> Iterator[Finding]:
    """Yield the links of `file` that lead nowhere."""
    for link in document(file).links:
        if problem := _problem(file, link):
            yield Finding(file, link.line, f"{link.target}: {problem}")


def waits(place: PurePosixPath) -> bool:
    """Whether this is a page whose text or translation is still to come."""
    if place.is_relative_to(RUSSIAN):
        return place.relative_to(RUSSIAN).as_posix() in UNTRANSLATED | AWAITED
    return place.is_relative_to(DOCS) and place.relative_to(DOCS).as_posix() in AWAITED


def _problem(file: PurePosixPath, link: Link) -> str:
    if link.external:
        return "" if _well_formed(link.target) else "no valid address"
    try:
        place = led_to(file, link)
    except ValueError as error:
        return str(error)
    if not (ROOT / place).exists():
        return "" if waits(place) else "no such file"
    if link.anchor and place.suffix == ".md":
        anchor = unquote(link.anchor)
        return "" if anchor in document(place).anchors else "no such heading"
    return ""


def _well_formed(address: str) -> bool:
    if address.startswith("mailto:"):
        return _MAIL.fullmatch(address) is not None
    try:
        parts = urlsplit(address)
        return parts.scheme in ("http", "https") and "." in (parts.hostname or "")
    except ValueError:
        return False
