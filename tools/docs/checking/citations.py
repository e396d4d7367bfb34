"""A clause that a document cites exists in the protocol, and is a link to it (§2.1, D13, E3).

Code inside of a document is left alone: there a citation can be no link.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import PurePosixPath

from tools.docs.checking.finding import Finding
from tools.docs.pages import DOCS, RUSSIAN, document

PROTOCOL = "protocol.md"
CITED = re.compile(
    r"(?<![\w.#/-])(?<![0-9A-F]{2} )(?:§ ?(?P<clause>\d+(?:\.\d+)*)|(?P<entry>[DE][1-9]\d?))"
    r"(?!\w)(?! [0-9A-F]{2}\b)"
)
"""A clause, a decision or an erratum; no byte between other bytes (`E1 E0`)."""

_LINK = re.compile(r"\[(?P<words>[^\[\]]*)\]\((?P<target>[^()\s]+)\)")
_DEFINED = re.compile(r'<a id="[\w-]+"></a>(?:\*\*)?$')


def anchor_of(cited: re.Match[str]) -> str:
    """Return the anchor of a citation: `s2-1`, `d13`, `e3`."""
    if cited["clause"]:
        return "s" + cited["clause"].replace(".", "-")
    return cited["entry"].lower()


def anchors() -> frozenset[str]:
    """Return the anchors of the protocol."""
    return document(DOCS / PROTOCOL).anchors


def findings(file: PurePosixPath) -> Iterator[Finding]:
    """Yield the citations of `file` that lead nowhere, or are no link to their clause."""
    page = document(file)
    links = [(each.span(), each["target"]) for each in _LINK.finditer(page.prose)]
    own = file in (DOCS / PROTOCOL, RUSSIAN / PROTOCOL)
    for cited in CITED.finditer(page.prose):
        anchor, line = anchor_of(cited), page.prose.count("\n", 0, cited.start()) + 1
        if anchor not in anchors():
            yield Finding(file, line, f"{cited[0]}: not in the protocol")
        elif own and _DEFINED.search(page.prose, 0, cited.start()):
            continue
        else:
            wanted = f"#{anchor}" if own else f"{PROTOCOL}#{anchor}"
            target = next((to for (a, b), to in links if a <= cited.start() < b), "")
            if not (target == wanted if own else target.endswith(wanted)):
                yield Finding(file, line, f"{cited[0]}: no link to {wanted}")
