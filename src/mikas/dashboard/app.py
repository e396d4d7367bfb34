"""The application: a hub, the rules of access, the routers, the page.

A router is a module with a `router`; a route asks for what it needs by `mikas.dashboard.asking`
(`TheHub`, `Viewer`, `Controller`) and raises errors of `mikas.errors` or `mikas.dashboard.refusals`
as they are: `mikas.dashboard.answers` tells them as JSON. `responses=errors(503)` describes them.
"""

from __future__ import annotations

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from importlib.metadata import version
from pathlib import Path
from typing import Any

from fastapi import APIRouter, FastAPI

from mikas.dashboard import answers, page
from mikas.dashboard.access import Access
from mikas.dashboard.doorkeeper import Doorkeeper
from mikas.dashboard.hub import Hub
from mikas.dashboard.live import Broadcaster

_DESCRIPTION = """
Everything that the page does, a script can do. Every client sends `X-Mikas-Client` (8 to 64
letters, digits or hyphens); what decides what the line does needs the controller's seat, which the
first client that asks gets. Times are UNIX seconds, bytes upper-case hex, texts `{"en", "ru"}`.
Live data: WebSocket `/api/live?client=…`, described in docs/api.md.
"""


class _Application(FastAPI):
    def openapi(self) -> dict[str, Any]:
        """As FastAPI makes it, without its own form of a bad request: ours is 400."""
        described = super().openapi()
        for methods in described["paths"].values():
            for route in methods.values():
                route["responses"].pop("422", None)
        for name in ("HTTPValidationError", "ValidationError"):
            described["components"]["schemas"].pop(name, None)
        return described


def _routers() -> list[APIRouter]:
    from mikas.dashboard import (
        about,
        api_docs,
        changes,
        connection,
        doctor,
        dumps,
        live,
        memory,
        recording_routes,
        recordings,
        unit,
    )

    return [
        about.router,
        connection.router,
        doctor.router,
        live.router,
        unit.router,
        memory.router,
        dumps.router,
        changes.router,
        recording_routes.router,
        recordings.router,
        api_docs.router,
    ]


def create_app(hub: Hub, access: Access, *, folder: Path = page.FOLDER) -> FastAPI:
    """The application. It starts and closes `hub` with itself; `folder` has the built page."""

    @asynccontextmanager
    async def lifespan(_: FastAPI) -> AsyncIterator[None]:
        async with hub.running():
            yield

    app = _Application(
        title="mikas",
        description=_DESCRIPTION,
        version=version("mikas"),
        docs_url=None,
        redoc_url=None,
        openapi_url="/api/openapi.json",
        lifespan=lifespan,
    )
    app.state.hub = hub
    app.state.access = access
    app.state.broadcaster = Broadcaster(hub)
    answers.install(app)
    for router in _routers():
        app.include_router(router, prefix="/api")
    app.include_router(page.router(folder, hub.settings.language))
    app.add_middleware(Doorkeeper, access=access)
    return app
