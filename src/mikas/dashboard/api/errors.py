"""Errors as JSON, in one form: `{"error": {"code", "en", "ru", "sent", "received"}}`.

`code` is the class's name in the tree of errors, the texts are whole advice, bytes are upper-case
hex. A bug is told too (500), without its innards.
"""

from __future__ import annotations

import logging
from typing import Any

from fastapi import FastAPI, Request
from fastapi.exceptions import RequestValidationError
from fastapi.responses import JSONResponse
from pydantic import BaseModel, Field
from starlette.exceptions import HTTPException

from mikas.dashboard import not_valid
from mikas.dashboard.advice import ADVICE
from mikas.dashboard.errors import ApiRefusal, BadRequest, InternalError, NotFound
from mikas.errors import (
    EcuRefused,
    LineError,
    MikasError,
    NoConnection,
    NotConfirmed,
    UsageError,
)
from mikas.i18n import Text

_log = logging.getLogger("mikas.dashboard")


class TwoTexts(BaseModel):
    """The same sentence in both languages."""

    en: str
    ru: str


class ErrorBody(BaseModel):
    """What went wrong, what was on the wire, what to try."""

    code: str = Field(examples=["EchoOnly"])
    en: str
    ru: str
    sent: str | None = None
    received: str | None = None


class ErrorResponse(BaseModel):
    """Every answer of 400 and above."""

    error: ErrorBody


_BRANCHES: tuple[tuple[type[MikasError], int], ...] = (
    (NotConfirmed, 403),
    (UsageError, 400),
    (NoConnection, 503),
    (LineError, 502),
    (EcuRefused, 502),
)
_MEANINGS = {
    400: "the request makes no sense",
    401: "the token is wanted",
    403: "not from there, not with these rights, or locked",
    404: "no such thing",
    409: "somebody else has control, or what was confirmed is no longer so",
    410: "the confirmation is over",
    413: "too large",
    502: "line trouble, or the unit refused",
    503: "no connection",
}


def errors(*statuses: int) -> dict[int | str, dict[str, Any]]:
    """For a route's `responses`: these statuses, and those that every route may answer with."""
    every = (400, 401, 403, 413)
    return {
        status: {"model": ErrorResponse, "description": _MEANINGS[status]}
        for status in sorted({*every, *statuses})
    }


def two(text: Text) -> TwoTexts:
    """`text` for an answer."""
    return TwoTexts(en=text.en, ru=text.ru)


def two_or_none(text: Text | None) -> TwoTexts | None:
    """`text` for an answer; an empty one is none."""
    return None if text is None or not text.en else two(text)


def status_of(error: MikasError) -> int:
    """The HTTP status that says the same as `error`."""
    if isinstance(error, ApiRefusal):
        return error.status
    return next((status for branch, status in _BRANCHES if isinstance(error, branch)), 500)


def body_of(error: MikasError) -> dict[str, Any]:
    """`error` as the value of "error" in an answer, or in an event."""
    text = ADVICE.text(error)
    return {
        "code": type(error).__name__,
        "en": text.en,
        "ru": text.ru,
        "sent": in_hex(error.request),
        "received": in_hex(error.received),
    }


def in_hex(data: bytes | None) -> str | None:
    """Upper-case hex without spaces."""
    return None if data is None else data.hex().upper()


def answer_to(error: MikasError) -> JSONResponse:
    """The whole answer."""
    return JSONResponse({"error": body_of(error)}, status_of(error))


def install(app: FastAPI) -> None:
    """Has `app` tell every error in this form."""
    app.add_exception_handler(MikasError, _ours)
    app.add_exception_handler(RequestValidationError, _not_valid)
    app.add_exception_handler(HTTPException, _of_the_framework)
    app.add_exception_handler(Exception, _bug)


async def _ours(_: Request, error: Exception) -> JSONResponse:
    assert isinstance(error, MikasError)
    return answer_to(error)


async def _not_valid(_: Request, error: Exception) -> JSONResponse:
    assert isinstance(error, RequestValidationError)
    return answer_to(BadRequest(problem=not_valid.told(error.errors()[0])))


async def _of_the_framework(request: Request, error: Exception) -> JSONResponse:
    assert isinstance(error, HTTPException)
    if isinstance(error.__cause__, MikasError):  # from under the reading of a body
        return answer_to(error.__cause__)
    if error.status_code == 404:
        return answer_to(NotFound.at(request.url.path))
    told = f"{request.method} {request.url.path}: {error.detail}"
    answer = answer_to(BadRequest(problem=Text(told, told)))
    answer.status_code = error.status_code
    answer.headers.update(error.headers or {})
    return answer


async def _bug(request: Request, error: Exception) -> JSONResponse:
    _log.error("a bug in %s %s", request.method, request.url.path, exc_info=error)
    return answer_to(InternalError(kind=f"{type(error).__name__}: {error}"))
