"""The dashboard's page (static files), and /api/docs (the OpenAPI description as one page).

The build of `web/` puts the files into the folder `page`. Browsers keep files with a hash in their
name, and request all others again each time. If nothing was built, `/` explains that; the API works
all the same. /api/docs needs no scripts and no external resources.
"""

from __future__ import annotations

import json
import mimetypes
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from fastapi import APIRouter, Request
from fastapi.responses import FileResponse, HTMLResponse, Response

from mikas.dashboard.error_responses import refusal_response
from mikas.dashboard.errors import NotFound
from mikas.i18n import Language

if TYPE_CHECKING:
    from jinja2 import Environment

FOLDER = Path(__file__).parent / "page"
_METHODS = ("get", "post", "put", "delete")
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


docs_router: Final = APIRouter(prefix="/api", include_in_schema=False)


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


@docs_router.get("/docs")
def docs(request: Request) -> HTMLResponse:
    """Return the page, which is made once."""
    made = request.app.state
    if not hasattr(made, "docs"):
        described: dict[str, Any] = request.app.openapi()
        page = _templates().get_template("docs.html")
        made.docs = page.render(api=described, routes=_routes(described))
    return HTMLResponse(made.docs)


@docs_router.get("/docs/style.css")
def style() -> Response:
    """Return the style of the page."""
    text = _templates().get_template("docs.css").render()
    return Response(text, media_type="text/css", headers={"Cache-Control": _REVALIDATE})


@cache
def _templates() -> Environment:
    from jinja2 import Environment, PackageLoader, select_autoescape

    found = Environment(
        loader=PackageLoader("mikas.dashboard"),
        autoescape=select_autoescape(["html"]),
        trim_blocks=True,
        lstrip_blocks=True,
    )
    found.filters["shape"] = shape
    found.filters["body"] = _body
    return found


def _routes(described: dict[str, Any]) -> dict[str, list[dict[str, Any]]]:
    """Return the routes by tag, in the order of the description."""
    tags: dict[str, list[dict[str, Any]]] = {}
    for path, methods in described["paths"].items():
        for method in _METHODS:
            if method in methods:
                route = {"method": method.upper(), "path": path, **methods[method]}
                tags.setdefault(route.get("tags", ["other"])[0], []).append(route)
    return tags


def _body(described: dict[str, Any]) -> str:
    """Return the shape of the content of a request or response; empty without content."""
    for kind, content in described.get("content", {}).items():
        schema = content.get("schema")
        return shape(schema) if kind == "application/json" and schema else str(kind)
    return ""


def shape(schema: dict[str, Any]) -> str:
    """Return a schema in short: `Plan`, `list of number`, `"a" | "b"`, `string or null`."""
    if "$ref" in schema:
        return str(schema["$ref"]).rpartition("/")[2]
    if "const" in schema:
        return json.dumps(schema["const"])
    if "enum" in schema:
        return " | ".join(json.dumps(value) for value in schema["enum"])
    for key in ("anyOf", "oneOf"):
        if key in schema:
            return " or ".join(shape(each) for each in schema[key])
    kind = str(schema.get("type", "anything"))
    if kind == "array":
        return f"list of {shape(schema.get('items', {}))}"
    if kind == "object" and isinstance(schema.get("additionalProperties"), dict):
        return f"name → {shape(schema['additionalProperties'])}"
    return kind
