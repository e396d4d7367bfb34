"""Error responses of the routes: their descriptions, and the handlers of exceptions.

The texts of validation errors are in both languages; pydantic's own are English only.
"""

from __future__ import annotations

import logging
from collections.abc import Mapping
from typing import Annotated, Any, TypeVar

from fastapi import FastAPI, Request
from fastapi.exceptions import RequestValidationError
from fastapi.responses import JSONResponse
from pydantic import BaseModel, BeforeValidator
from starlette.exceptions import HTTPException

from mikas.dashboard.error_responses import ErrorResponse, json_response
from mikas.dashboard.errors import BadRequest, InternalError, NotFound
from mikas.errors import MikasError
from mikas.i18n import Text

M = TypeVar("M", bound=BaseModel)

_log = logging.getLogger("mikas.dashboard")


class TwoTexts(BaseModel):
    """The same sentence in both languages."""

    en: str
    ru: str


_DESCRIPTIONS = {
    400: "invalid request",
    401: "the token is missing",
    403: "refused from there, with these rights, or while writing is locked",
    404: "not found",
    409: "another client has control, or the content changed since it was shown",
    410: "the confirmation has expired",
    413: "too large",
    502: "line trouble, or the unit refused",
    503: "no connection",
    504: "it took too long and was cancelled",
}

# By name: FastAPI would build the model for each status of each route, 200 times at every start.
_ERROR = {
    "application/json": {"schema": {"$ref": f"#/components/schemas/{ErrorResponse.__name__}"}}
}


def errors(*statuses: int) -> dict[int | str, dict[str, Any]]:
    """Return a route's `responses`: these statuses, and those that every route may answer with."""
    every = (400, 401, 403, 413)
    return {
        status: {"content": _ERROR, "description": _DESCRIPTIONS[status]}
        for status in sorted({*every, *statuses})
    }


def content(media_type: str, description: str) -> dict[int | str, dict[str, Any]]:
    """Return the part of a route's `responses` for a file."""
    return {200: {"content": {media_type: {}}, "description": description}}


def two(text: Text) -> TwoTexts:
    """Return the model of `text`."""
    return TwoTexts(en=text.en, ru=text.ru)


def _none_if_empty(text: object) -> object:
    return None if isinstance(text, Text) and not text.en else text


OptionalTexts = Annotated[TwoTexts | None, BeforeValidator(_none_if_empty)]


def made_of(model: type[M], source: object, /, **more: object) -> M:
    """Return `model` with `more`, and the attributes of `source` as its other fields.

    A field that is itself a model may be given an object with its fields as attributes.
    """
    own = {name: getattr(source, name) for name in model.model_fields if name not in more}
    return model.model_validate(own | more, from_attributes=True)


def install(app: FastAPI) -> None:
    """Install the handlers that turn every exception into an `ErrorResponse`."""

    @app.exception_handler(MikasError)
    async def expected(_: Request, error: MikasError) -> JSONResponse:
        return json_response(error)

    @app.exception_handler(RequestValidationError)
    async def invalid(_: Request, error: RequestValidationError) -> JSONResponse:
        return json_response(BadRequest(problem=validation_text(error.errors()[0])))

    @app.exception_handler(HTTPException)
    async def of_the_framework(request: Request, error: HTTPException) -> JSONResponse:
        if isinstance(error.__cause__, MikasError):  # raised while the body was read
            return json_response(error.__cause__)
        if error.status_code == 404:
            return json_response(NotFound.at(request.url.path))
        detail = f"{request.method} {request.url.path}: {error.detail}"
        response = json_response(BadRequest(problem=Text(detail, detail)))
        response.status_code = error.status_code
        response.headers.update(error.headers or {})
        return response

    @app.exception_handler(Exception)
    async def bug(request: Request, error: Exception) -> JSONResponse:
        _log.error("a bug in %s %s", request.method, request.url.path, exc_info=error)
        return json_response(InternalError(kind=f"{type(error).__name__}: {error}"))


_PROBLEMS = {
    "missing": Text("is missing", "не указано"),
    "extra_forbidden": Text("is unknown", "не предусмотрено"),
    "json_invalid": Text("is not valid JSON", "не является JSON"),
    "literal_error": Text("must be one of: {expected}", "допустимо только: {expected}"),
    "enum": Text("must be one of: {expected}", "допустимо только: {expected}"),
    "union_tag_invalid": Text(
        "must be one of: {expected_tags}", "допустимо только: {expected_tags}"
    ),
    "union_tag_not_found": Text("has no {discriminator}", "не указано: {discriminator}"),
    "greater_than": Text("must be more than {gt}", "должно быть больше {gt}"),
    "greater_than_equal": Text("must be {ge} or more", "должно быть не меньше {ge}"),
    "less_than": Text("must be less than {lt}", "должно быть меньше {lt}"),
    "less_than_equal": Text("must be {le} or less", "должно быть не больше {le}"),
    "string_too_short": Text(
        "is too short (at least {min_length})", "слишком коротко (не меньше {min_length})"
    ),
    "string_too_long": Text(
        "is too long (at most {max_length})", "слишком длинно (не больше {max_length})"
    ),
    "too_short": Text(
        "has too few entries (at least {min_length})",
        "слишком мало записей (не меньше {min_length})",
    ),
    "too_long": Text(
        "has too many entries (at most {max_length})",
        "слишком много записей (не больше {max_length})",
    ),
    "string_pattern_mismatch": Text(
        "does not match the pattern {pattern}", "не соответствует шаблону {pattern}"
    ),
}
_TYPES = {
    "int": Text("must be a whole number", "должно быть целым числом"),
    "float": Text("must be a number", "должно быть числом"),
    "finite": Text("must be a finite number", "должно быть конечным числом"),
    "bool": Text("must be true or false", "должно быть true или false"),
    "string": Text("must be a text", "должно быть текстом"),
    "list": Text("must be a list", "должно быть списком"),
    "dict": Text("must be an object", "должно быть объектом"),
    "model": Text("must be an object", "должно быть объектом"),
}
_OTHER = Text("has an invalid value", "имеет недопустимое значение")


def validation_text(error: Mapping[str, Any]) -> Text:
    """Return the field's name and its problem; `error`: one of pydantic's."""
    kind = str(error["type"])
    problem = _PROBLEMS.get(kind) or _TYPES.get(kind.partition("_")[0]) or _OTHER
    try:
        problem = problem.filled(**error.get("ctx", {}))
    except (KeyError, IndexError):
        problem = _OTHER
    # `wanted.3.name`, without the part of the request that holds the field
    part, *inside = error["loc"] or ("?",)
    field = ".".join(map(str, inside)) or part
    return Text(f"“{field}” {problem.en}", f"«{field}» {problem.ru}")
