"""A refusal as a page in plain words, for a person who opened an address: on a phone, by day and
night. It has one style, which its own policy names by its hash; nothing else is let in.
"""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Mapping
from hashlib import sha256
from html import escape
from typing import Any

from starlette.responses import HTMLResponse, Response

from mikas.dashboard.advice import ADVICE
from mikas.dashboard.api.errors import answer_to
from mikas.dashboard.errors import ApiRefusal

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


def refusal(error: ApiRefusal, scope: Mapping[str, Any]) -> Response:
    """JSON for the API; a page in words for a person who opened an address."""
    wanted = dict(scope["headers"]).get(b"accept", b"").decode("latin-1")
    if scope["path"].startswith("/api") or "text/html" not in wanted:
        return answer_to(error)
    said = "".join(
        f'<p lang="{language}">{escape(text)}</p>'
        for language, text in zip(("en", "ru"), ADVICE.text(error), strict=True)
    )
    return HTMLResponse(f"{_HEAD}{said}", error.status, {"Content-Security-Policy": _POLICY})
