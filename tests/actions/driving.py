"""Drives the table of routes: asks row by row, and collects what is not as it says."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable
from typing import Any
from urllib.parse import quote

from .routes import Home, Kept, Row

Ask = Callable[[str, str, Any], tuple[int, bytes]]
"""Sends a request, `api/…` with a JSON or bytes as its body; returns the status and the body."""
TURNS = 600


def drive(ask: Ask, rows: Iterable[Row], home: Home) -> list[str]:
    """Return a line for each row that was answered otherwise than it says."""
    kept, found = Kept(), []
    for row in rows:
        if home not in row.homes:
            continue
        try:
            problem = _problem(ask, row, kept)
        except (AttributeError, KeyError, IndexError, TypeError) as error:
            problem = f"what it needs is not there: {error!r}"
        if problem:
            found.append(f"{row.method} {row.address or row.route}: {problem}")
    return found


def _problem(ask: Ask, row: Row, kept: Kept) -> str:
    address = (row.address or row.route).format(**_quoted(kept))
    body = row.body(kept) if callable(row.body) else row.body
    for _ in range(TURNS):
        status, content = ask(row.method, f"api{address}", body)
        if status != row.status:
            return f"{status} {content[:300]!r}"
        answer = _read(content)
        if status != 200 or row.until(answer):
            for name, take in row.takes.items():
                setattr(kept, name, take(answer))
            return ""
    return f"it never came: {content[:300]!r}"


def _quoted(kept: Kept) -> dict[str, str]:
    return {
        name: quote(str(value), safe="") for name, value in vars(kept).items() if name != "bytes"
    }


def _read(content: bytes) -> Any:
    try:
        return json.loads(content)
    except ValueError:
        return content
