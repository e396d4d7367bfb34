"""A section of the page that a module of its own makes: a title and its contents.

`page.SECTIONS` has their makers, in order. A maker gets the findings and the language, and returns
None if the section has nothing to show. Texts are escaped, as the functions here do.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from markupsafe import Markup


@dataclass(frozen=True, slots=True)
class PageSection:
    """A title, and the contents as safe markup: of the functions below, or of an own template."""

    title: str
    body: Markup


def paragraph(text: str) -> Markup:
    """Return a paragraph."""
    return Markup("<p>{}</p>").format(text)


def items(texts: Iterable[str]) -> Markup:
    """Return a list."""
    entries = Markup("").join(Markup("<li>{}</li>").format(text) for text in texts)
    return Markup("<ul>{}</ul>").format(entries)


def table(head: Iterable[str], rows: Iterable[Iterable[str]]) -> Markup:
    """Return a table with a line of titles."""
    titles = Markup("").join(Markup("<th>{}</th>").format(text) for text in head)
    lines = Markup("").join(
        Markup("<tr>{}</tr>").format(
            Markup("").join(Markup("<td>{}</td>").format(text) for text in row)
        )
        for row in rows
    )
    return Markup("<table><thead><tr>{}</tr></thead><tbody>{}</tbody></table>").format(
        titles, lines
    )
