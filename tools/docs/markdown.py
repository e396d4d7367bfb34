"""What a Markdown file consists of, as GitHub shows it: headings with anchors, code, links.

Blocks are found by CommonMark (markdown-it); links by their form in what is no code.
"""

from __future__ import annotations

import re
import unicodedata
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

from markdown_it import MarkdownIt
from markdown_it.token import Token

_COMMONMARK = MarkdownIt("commonmark").enable("table")
_SPAN = re.compile(r"(?<!`)(`+)(?!`)(.+?)(?<!`)\1(?!`)", re.DOTALL)
_COMMENT = re.compile(r"<!--.*?-->", re.DOTALL)
_LINK = re.compile(
    r"(?P<picture>!?)\[(?:[^\[\]]|!?\[[^\]]*\]\([^)]*\))*\]\((?P<target>[^()\s]+)[^()]*\)"
)
_PICTURE_IN_LINK = re.compile(r"(?P<picture>!)\[[^\]]*\]\((?P<target>[^()\s]+)[^()]*\)")
_HTML = re.compile(r"<(?P<tag>img|a|source)\b[^>]*?\b(?:src|href|srcset)=\"(?P<target>[^\"]+)\"")
_ANCHOR = re.compile(r"<a\s+(?:id|name)=\"([^\"]+)\"")
_CLAUSE = re.compile(r"§(\d+(?:\.\d+)*) ")
_MARKUP = re.compile(r"[*`]|!?\[([^\]]*)\]\([^)]*\)|<[^>]+>")


@dataclass(frozen=True, slots=True)
class Heading:
    """A heading; `anchor`: as GitHub makes it of its words."""

    level: int
    words: str
    anchor: str
    line: int


@dataclass(frozen=True, slots=True)
class Code:
    """A fenced block; `line`: of its first line, from 1; `info`: the words behind the fence."""

    info: str
    text: str
    line: int

    @property
    def language(self) -> str:
        """The first word behind the fence."""
        return self.info.split()[0] if self.info.split() else ""


@dataclass(frozen=True, slots=True)
class Link:
    """A link or a picture; `start`, `end`: of its target in the file's text."""

    target: str
    picture: bool
    start: int
    end: int
    line: int

    @property
    def path(self) -> str:
        """The target without an anchor."""
        return self.target.partition("#")[0]

    @property
    def anchor(self) -> str:
        """The target's anchor; empty: none."""
        return self.target.partition("#")[2]

    @property
    def external(self) -> bool:
        """Whether it leads out of the repository."""
        return re.match(r"[a-z][a-z0-9+.-]*:|//", self.target) is not None


class Document:
    """The parts of `text`."""

    def __init__(self, text: str) -> None:
        self.text = text

    @cached_property
    def tokens(self) -> list[Token]:
        """The blocks, by markdown-it."""
        return _COMMONMARK.parse(self.text)

    @cached_property
    def headings(self) -> tuple[Heading, ...]:
        """All headings, in their order."""
        found: list[Heading] = []
        seen: Counter[str] = Counter()
        for token, inline in zip(self.tokens, self.tokens[1:], strict=False):
            if token.type != "heading_open":
                continue
            assert token.map
            slug = slug_of(inline.content)
            anchor = f"{slug}-{seen[slug]}" if seen[slug] else slug
            seen[slug] += 1
            found.append(Heading(int(token.tag[1]), inline.content, anchor, token.map[0] + 1))
        return tuple(found)

    @cached_property
    def anchors(self) -> frozenset[str]:
        """What can stand behind a `#`."""
        own = _ANCHOR.findall(self.prose)
        return frozenset([*(each.anchor for each in self.headings), *own])

    @cached_property
    def code(self) -> tuple[Code, ...]:
        """All fenced blocks, in their order."""
        return tuple(
            Code(token.info, token.content, token.map[0] + 1)
            for token in self.tokens
            if token.type == "fence" and token.map
        )

    @cached_property
    def links(self) -> tuple[Link, ...]:
        """All links and pictures, in their order."""
        found = {
            match.start("target"): Link(
                target=match["target"],
                picture=bool(match.groupdict().get("picture"))
                or match.groupdict().get("tag") == "img",
                start=match.start("target"),
                end=match.end("target"),
                line=self.text.count("\n", 0, match.start("target")) + 1,
            )
            for form in (_LINK, _PICTURE_IN_LINK, _HTML)
            for match in form.finditer(self.prose)
        }
        return tuple(found[start] for start in sorted(found))

    @cached_property
    def prose(self) -> str:
        """The text with code and comments blanked, so that offsets stay."""
        lines = self.text.splitlines(keepends=True)
        for token in self.tokens:
            if token.type in ("fence", "code_block") and token.map:
                for number in range(*token.map):
                    lines[number] = _blank(lines[number])
        without = "".join(lines)
        for form in (_SPAN, _COMMENT):
            without = form.sub(lambda match: _blank(match[0]), without)
        return without


def slug_of(words: str) -> str:
    """Return the anchor of a heading: small letters and digits, `-` for a space, as GitHub does."""
    plain = _MARKUP.sub(lambda match: match[1] or "", words)
    kept = re.sub(r"[^\w\- ]", "", unicodedata.normalize("NFC", plain).strip().lower())
    return kept.replace(" ", "-")


def slugs() -> Callable[[str, str], str]:
    """Return `slug_of` as Python-Markdown calls it, so that anchors are those of GitHub.

    A clause of the protocol gets its own anchor, `s2-1`: that of its permanent link.
    """
    return _slug_of_toc


def _slug_of_toc(words: str, _: str) -> str:
    clause = _CLAUSE.match(words)
    return "s" + clause[1].replace(".", "-") if clause else slug_of(words)


def with_targets(document: Document, targets: dict[int, str]) -> str:
    """Return the text with other targets of links, by the place where a target begins."""
    parts, done = [], 0
    for link in document.links:
        if link.start in targets:
            parts += [document.text[done : link.start], targets[link.start]]
            done = link.end
    return "".join([*parts, document.text[done:]])


def _blank(text: str) -> str:
    return re.sub(r"[^\n]", " ", text)
