"""Markdown as the web shows it (CommonMark), rewritten for Python-Markdown, which Zensical has.

Python-Markdown wants four spaces for each level of a list, and an empty line before a list or a
table that follows a paragraph. A fence with more words than the language it takes for a paragraph.
A heading of a clause has the clause's anchor itself (`slugs`), so the one before it goes.
"""

from __future__ import annotations

import re

from tools.docs.markdown import Document

_MARKER = re.compile(r" *(?:[-*+]|\d+[.)]) +")
_CLAUSE = re.compile(r'(#+ )<a id="s[\d-]+"></a>(?=(<a [^>]*></a>)*§)')
_WIDTH = 4
_NEEDS_GAP = frozenset({"bullet_list_open", "ordered_list_open", "table_open"})


def rewritten(text: str) -> str:
    """Return `text` in the dialect of Python-Markdown."""
    lines = text.splitlines()
    depth = [0] * len(lines)
    removed = [0] * len(lines)
    first: dict[int, int] = {}
    gaps: set[int] = set()
    level = 0
    for token in Document(text).tokens:
        if token.type == "list_item_open" and token.map:
            level += 1
            start, end = token.map
            marker = _MARKER.match(lines[start])
            width = marker.end() if marker else len(lines[start])
            first[start] = level
            for number in range(start, end):
                depth[number], removed[number] = level, width
        elif token.type == "list_item_close":
            level -= 1
        elif token.type in _NEEDS_GAP and token.map and level == 0:
            gaps.add(token.map[0])
        elif token.type == "fence" and token.map and token.info:
            fence = token.map[0]
            before, mark, info = lines[fence].partition(token.markup)
            lines[fence] = before + mark + info.split()[0]
    made: list[str] = []
    for number, line in enumerate(lines):
        if number in gaps and made and made[-1].strip():
            made.append("")
        own = _CLAUSE.sub(r"\1", line)
        made.append(_line(own, depth[number], removed[number], first.get(number)))
    return "\n".join(made) + "\n"


def _line(line: str, depth: int, removed: int, opens: int | None) -> str:
    if not depth or not line.strip():
        return line
    if opens is not None:
        content = line[removed:]
        marker = line[:removed].strip()
        return " " * (_WIDTH * (depth - 1)) + marker.ljust(_WIDTH - 1) + " " + content
    present = len(line) - len(line.lstrip(" "))
    return " " * (_WIDTH * depth) + line[min(present, removed) :]
