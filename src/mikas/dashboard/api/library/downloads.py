"""Kept files: one as a response, whatever happens to its name meanwhile, and those left out."""

from __future__ import annotations

import asyncio
import os
from collections.abc import Iterable
from math import inf
from typing import BinaryIO, Final
from urllib.parse import quote

from fastapi.responses import StreamingResponse
from pydantic import BaseModel
from starlette.types import Receive, Scope, Send

from mikas.dashboard.api.errors import TwoTexts, two
from mikas.dashboard.library.folder import LeftOut

_CHUNK: Final = 1 << 16


class LeftOutFile(BaseModel):
    """A file of the folder that is not listed, and why. `name` empty: several files."""

    name: str
    problem: TwoTexts


def left_out(files: Iterable[LeftOut]) -> list[LeftOutFile]:
    """Return the models of `files`."""
    return [LeftOutFile(name=each.name, problem=two(each.problem)) for each in files]


class OpenFile(StreamingResponse):
    """The bytes that a file has now, from the open file: deleted or replaced, it is sent whole.

    Of a file that grows the part written so far is sent. If it is cut meanwhile, the response ends
    without its last bytes, and the client sees that.
    """

    def __init__(self, opened: BinaryIO, name: str, media_type: str, *, most: float = inf) -> None:
        self._opened = opened
        self._left = int(min(most, os.fstat(opened.fileno()).st_size))
        headers = {"Content-Length": str(self._left), "Content-Disposition": attachment(name)}
        super().__init__((), media_type=media_type, headers=headers)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        try:
            await super().__call__(scope, receive, send)
        finally:
            self._opened.close()

    async def stream_response(self, send: Send) -> None:
        start = {"status": self.status_code, "headers": self.raw_headers}
        await send({"type": "http.response.start", **start})
        while self._left:
            data = await asyncio.to_thread(self._opened.read, min(self._left, _CHUNK))
            if not data:
                return
            self._left -= len(data)
            await send({"type": "http.response.body", "body": data, "more_body": True})
        await send({"type": "http.response.body", "body": b"", "more_body": False})


def attachment(name: str) -> str:
    """Return the header that makes a browser save the response as `name`."""
    if quote(name, safe="") == name:
        return f'attachment; filename="{name}"'
    return f"attachment; filename*=UTF-8''{quote(name, safe='')}"
