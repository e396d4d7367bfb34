"""The dashboard's page: static files, put into the folder `page` by the build of `web/`.

Browsers keep files with a hash in their name, and request all others again each time. If nothing
was built, `/` explains that; the API works all the same.
"""

from __future__ import annotations

import mimetypes
from pathlib import Path

from fastapi import APIRouter, Request
from fastapi.responses import FileResponse, HTMLResponse, Response

from mikas.dashboard.error_responses import refusal_response
from mikas.dashboard.errors import NotFound
from mikas.i18n import Language

FOLDER = Path(__file__).parent / "page"
_FOREVER = "public, max-age=31536000, immutable"
_REVALIDATE = "no-cache"
_NOT_BUILT = """<!doctype html>
<html lang="en"><head><meta charset="utf-8"><title>mikas</title></head><body>
<h1>mikas</h1>
<p>The page was not built into this installation. Install it again with <code>pip install .</code>
in the source folder (without <code>MIKAS_SKIP_PAGE</code>), or build it there
(<code>npm ci &amp;&amp; npm run build</code> in <code>web/</code>), then start this program again.
The API works: <a href="/api/docs">/api/docs</a>.</p>
<p lang="ru">В этой установке нет собранной страницы. Установите программу заново командой
<code>pip install .</code> в папке с исходниками (без <code>MIKAS_SKIP_PAGE</code>) или соберите
страницу там же (<code>npm ci &amp;&amp; npm run build</code> в <code>web/</code>) и запустите
программу снова. API работает: <a href="/api/docs">/api/docs</a>.</p>
</body></html>
"""

# Windows' registry may have other types; browsers refuse module scripts of a wrong type.
_TYPES = {".js": "text/javascript", ".css": "text/css", ".svg": "image/svg+xml",
          ".html": "text/html", ".json": "application/json", ".woff2": "font/woff2",
          ".webmanifest": "application/manifest+json"}  # fmt: skip


def router(folder: Path, language: Language | None = None) -> APIRouter:
    """Return the routes of the files in `folder`; index.html, at /, begins in `language`."""
    routes = APIRouter(include_in_schema=False)

    @routes.get("/")
    def index() -> Response:
        file = folder / "index.html"
        if not file.is_file():
            return HTMLResponse(_NOT_BUILT)
        if language is not None:
            page = file.read_text("utf-8")
            page = page.replace("<html", f'<html data-language="{language}"', 1)
            return HTMLResponse(page, headers={"Cache-Control": _REVALIDATE})
        return FileResponse(file, headers={"Cache-Control": _REVALIDATE}, media_type="text/html")

    @routes.get("/{path:path}")
    def file(request: Request, path: str) -> Response:
        found = _file_in(folder, path)
        if path.startswith("api/") or found is None:
            return refusal_response(NotFound.at(f"/{path}"), request.scope)
        caching = _FOREVER if path.startswith("assets/") else _REVALIDATE
        kind = _TYPES.get(found.suffix) or mimetypes.guess_type(found.name)[0]
        return FileResponse(found, headers={"Cache-Control": caching}, media_type=kind)

    return routes


def _file_in(folder: Path, path: str) -> Path | None:
    """Return the file at `path`; None if it is missing or outside of `folder`."""
    try:
        file = (folder / path).resolve()
        found = file.is_relative_to(folder.resolve()) and file.is_file()
    except (OSError, ValueError):  # not a valid file name
        return None
    return file if found else None
