"""Errors as responses: JSON `{"error": {"code", "en", "ru", "sent", "received"}}`, or a page.

`code` is the class's name in the tree of errors, the texts include advice, bytes are upper-case
hex. A person who opened an address in a browser gets a page with the same texts; its policy allows
nothing but its one style, which it names by its hash.
"""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Mapping
from hashlib import sha256
from html import escape
from typing import Any

from pydantic import BaseModel, Field
from starlette.responses import HTMLResponse, JSONResponse, Response

from mikas.dashboard.errors import ADVICE, ApiRefusal, api_hex
from mikas.errors import EcuRefused, LineError, MikasError, NoConnection, NotConfirmed, UsageError

_STATUSES: tuple[tuple[type[MikasError], int], ...] = (
    (NotConfirmed, 403),
    (UsageError, 400),
    (NoConnection, 503),
    (LineError, 502),
    (EcuRefused, 502),
)
_STYLE = (
    "html{color-scheme:light dark;font:18px/1.5 system-ui,sans-serif}"
    "body{max-width:34rem;margin:12vh auto;padding:0 1.2rem}"
    "h1{font-size:1.2rem;letter-spacing:.06em;opacity:.7}p{margin:1rem 0}"
)
_HASH = b64encode(sha256(_STYLE.encode()).digest()).decode()
_POLICY = (
    f"default-src 'none'; style-src 'sha256-{_HASH}'; base-uri 'none'; form-action 'none'; "
    "frame-ancestors 'none'"
)
_HEAD = (
    '<!doctype html><html lang="en"><meta charset="utf-8">'
    '<meta name="viewport" content="width=device-width,initial-scale=1">'
    f"<title>mikas</title><style>{_STYLE}</style><h1>mikas</h1>"
)


class ErrorBody(BaseModel):
    """The error, the bytes on the wire, and advice."""

    code: str = Field(examples=["EchoOnly"])
    en: str
    ru: str
    sent: str | None
    received: str | None


class ErrorResponse(BaseModel):
    """Every response of 400 and above."""

    error: ErrorBody


def status_of(error: MikasError) -> int:
    """Return the HTTP status for `error`."""
    if isinstance(error, ApiRefusal):
        return error.status
    return next((status for branch, status in _STATUSES if isinstance(error, branch)), 500)


def body_of(error: MikasError) -> ErrorBody:
    """Return the model of `error`."""
    text = ADVICE.text(error)
    return ErrorBody(
        code=type(error).__name__,
        en=text.en,
        ru=text.ru,
        sent=api_hex(error.request),
        received=api_hex(error.received),
    )


def json_response(error: MikasError) -> JSONResponse:
    """Return the whole JSON response for `error`."""
    return JSONResponse(ErrorResponse(error=body_of(error)).model_dump(), status_of(error))


def refusal_response(error: ApiRefusal, scope: Mapping[str, Any]) -> Response:
    """Return JSON for the API, a page for a person who opened an address in a browser."""
    accepted = dict(scope["headers"]).get(b"accept", b"").decode("latin-1")
    if scope["path"].startswith("/api") or "text/html" not in accepted:
        return json_response(error)
    paragraphs = "".join(
        f'<p lang="{language}">{escape(text)}</p>'
        for language, text in zip(("en", "ru"), ADVICE.text(error), strict=True)
    )
    page = f"{_HEAD}{paragraphs}"
    return HTMLResponse(page, error.status, {"Content-Security-Policy": _POLICY})
