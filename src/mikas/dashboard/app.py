"""The application: the dashboard, the rules of access, the routers, the page.

A router is a module of `mikas.dashboard.api` with a `router`. A route gets what it needs from
`api.dependencies` and raises errors of `mikas.errors` or `mikas.dashboard.errors`; `api.errors`
turns them into JSON responses. `responses=errors(503)` describes them.
"""

from __future__ import annotations

from collections.abc import AsyncIterator, Sequence
from contextlib import asynccontextmanager
from importlib.metadata import version
from pathlib import Path
from typing import Any

from fastapi import FastAPI

from mikas.dashboard import page
from mikas.dashboard.api import (
    catalog,
    changes,
    channels,
    connection,
    errors,
    guided_tests,
    live,
    network,
    search,
    unit,
    virtual_cars,
)
from mikas.dashboard.api.actions import routes as actions
from mikas.dashboard.api.co import routes as co
from mikas.dashboard.api.instruments import routes as instruments
from mikas.dashboard.api.library import (
    cars,
    causes,
    dumps,
    files,
    foreign_logs,
    marks,
    pulls,
    recorded,
    recordings,
    references,
    report,
    surveys,
    trips,
)
from mikas.dashboard.api.messages import FieldsMessage, LiveMessage, PingMessage, component_schemas
from mikas.dashboard.dashboard import Dashboard
from mikas.dashboard.error_responses import ErrorResponse
from mikas.dashboard.program import Ending, Sharing
from mikas.dashboard.security.access import Access
from mikas.dashboard.security.certificate import Certificate
from mikas.dashboard.security.middleware import AccessMiddleware
from mikas.dashboard.settings import Settings

_DESCRIPTION = """
Everything that the page does, a script can do. Every client sends `X-Mikas-Client` (8 to 64
letters, digits or hyphens, chosen at random and kept secret); requests that control the line need
the control lease, which the first client gets. Times are UNIX seconds, bytes upper-case hex, texts
`{"en", "ru"}`.
Live data: WebSocket `/api/live?client=…`, described in docs/reference/api.md.
"""

_PARTS = (catalog, channels, connection, live, network, unit, virtual_cars,
          guided_tests, dumps, changes, recordings, references, files, foreign_logs, cars, recorded,
          marks, report, search, causes, actions, surveys,
          instruments, trips, pulls, co)  # fmt: skip

# The routes themselves, of all applications of the process. Those of a router that is included are
# analysed by FastAPI once more, at the first request: a second in a browser.
_ROUTES = [
    *(route for part in _PARTS for route in part.router.routes),
    *page.docs_router.routes,
]


class _Application(FastAPI):
    def openapi(self) -> dict[str, Any]:
        """Return FastAPI's description, without its 422: an invalid request is answered by 400."""
        described = super().openapi()
        for methods in described["paths"].values():
            for route in methods.values():
                route["responses"].pop("422", None)
        schemas = described["components"]["schemas"]
        for name in ("HTTPValidationError", "ValidationError"):
            schemas.pop(name, None)
        schemas.update(
            component_schemas(
                ErrorResponse, LiveMessage, PingMessage, FieldsMessage, connection.DiagnosisStep
            )
        )
        described["components"]["schemas"] = dict(sorted(schemas.items()))
        return described


def create_app(
    dashboard: Dashboard,
    access: Access,
    *,
    folder: Path = page.FOLDER,
    certificate: Certificate | None = None,
    here: Sequence[str] = (),
) -> FastAPI:
    """Return the application, which starts and closes `dashboard`; `folder` has the built page.

    `certificate`: with which the network is served from the start. `here`: this computer's
    addresses and names then; none: they are not followed.
    """

    @asynccontextmanager
    async def lifespan(_: FastAPI) -> AsyncIterator[None]:
        async with dashboard.running():
            yield

    app = _Application(
        title="mikas",
        description=_DESCRIPTION,
        version=version("mikas"),
        docs_url=None,
        redoc_url=None,
        openapi_url="/api/openapi.json",
        lifespan=lifespan,
        routes=_ROUTES,
    )
    app.state.dashboard = dashboard
    app.state.access = access
    app.state.sharing = Sharing(dashboard, access, certificate, here)
    app.state.ending = Ending(dashboard)
    app.state.broadcaster = live.Broadcaster(dashboard)
    errors.install(app)
    app.include_router(page.router(folder, dashboard.settings.language))
    app.add_middleware(AccessMiddleware, access=access)
    return app


def openapi_description() -> dict[str, Any]:
    """Return the OpenAPI description without starting a server; the same at each call.

    It includes the models of the messages and events of the WebSocket.
    """
    nowhere = Path("nowhere")
    return create_app(Dashboard(Settings(nowhere, state=nowhere)), Access(port=1)).openapi()
