"""The dashboard's routes of recordings over a folder with one file: in this process, no socket."""

from __future__ import annotations

import asyncio
import json
import tempfile
from functools import cache
from pathlib import Path
from typing import Any, Final
from urllib.parse import quote

import httpx

from mikas.dashboard.app import create_app
from mikas.dashboard.dashboard import Dashboard
from mikas.dashboard.security.access import Access
from mikas.dashboard.settings import Settings

_PORT: Final = 8123
_ME: Final = {"X-Mikas-Client": "fuzzer-0001"}


def read(path: Path) -> None:
    """Request everything about the file; no answer may be 500, and JSON must be JSON."""
    asyncio.run(_all(path.read_bytes()))


async def _all(data: bytes) -> None:
    folder, client = _client()
    name = "it.pcapng"
    file = folder / name
    file.write_bytes(data)
    it = f"/api/recordings/{quote(name)}"
    try:
        listed = await _json(client, "/api/recordings")
        assert [each["id"] for each in listed["recordings"]] == [name]
        found = await _json(client, it)
        await _json(client, f"{it}/rows?points=50")
        if found.get("first") is not None:
            middle = (found["first"] + found["last"]) / 2
            await _json(client, f"{it}/rows?points=20&from={middle!r}")
        for path in ("export?format=csv&dialect=excel&lang=ru", "report?inline=1", "file"):
            await _got(client, f"{it}/{path}")
        answer = await client.put(f"{it}/note", json={"text": "после ремонта"}, headers=_ME)
        _judge(answer)
        await _json(client, "/api/recordings")
    finally:
        file.unlink(missing_ok=True)


async def _json(client: httpx.AsyncClient, path: str) -> Any:  # noqa: ANN401  (any JSON)
    def refuse(word: str) -> None:
        raise ValueError(f"{word} in the JSON of {path}")

    answer = await _got(client, path)
    return json.loads(answer.content, parse_constant=refuse)


async def _got(client: httpx.AsyncClient, path: str) -> httpx.Response:
    answer = await client.get(path, headers=_ME)
    _judge(answer)
    return answer


def _judge(answer: httpx.Response) -> None:
    assert answer.status_code < 500, (answer.request.url.path, answer.status_code, answer.text)


@cache
def _client() -> tuple[Path, httpx.AsyncClient]:
    """Return the folder of recordings, and a client of the application over it."""
    folder = Path(tempfile.mkdtemp(prefix="mikas-fuzz-"))
    settings = Settings(folder / "recordings", state=folder / "state", find=list)
    settings.recordings.mkdir()
    access = Access(_PORT)
    app = create_app(Dashboard(settings), access, folder=folder / "page")
    transport = httpx.ASGITransport(app)  # raises the application's own exceptions
    base = f"http://127.0.0.1:{_PORT}"
    return settings.recordings, httpx.AsyncClient(transport=transport, base_url=base)
