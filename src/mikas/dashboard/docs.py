"""/api/docs: the OpenAPI description as one page, without scripts and external resources."""

from __future__ import annotations

import json
from functools import cache
from typing import Any

from fastapi import APIRouter, Request
from fastapi.responses import HTMLResponse, Response
from jinja2 import Environment, PackageLoader, select_autoescape

router = APIRouter(include_in_schema=False)

_METHODS = ("get", "post", "put", "delete")


@router.get("/docs")
def docs(request: Request) -> HTMLResponse:
    """Return the page."""
    described: dict[str, Any] = request.app.openapi()
    page = _templates().get_template("docs.html")
    return HTMLResponse(page.render(api=described, routes=_routes(described)))


@router.get("/docs/style.css")
def style() -> Response:
    """Return the style of the page."""
    text = _templates().get_template("docs.css").render()
    return Response(text, media_type="text/css", headers={"Cache-Control": "no-cache"})


@cache
def _templates() -> Environment:
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
