"""Dependencies of routes: the dashboard, the client and its rights, the ports it may name.

    @router.post("/connect")
    async def connect(dashboard: TheDashboard, _: Controller) -> State: ...

`Viewer`: any client that has access. `Controller`: holds the control lease, or gets it now; else
403 or 409. A GET only views: it passes while the lease is free, and does not take it.
"""

from __future__ import annotations

import asyncio
import re
from collections.abc import AsyncIterator, Callable, Coroutine
from typing import Annotated, Any, TypeVar
from urllib.parse import unquote

from fastapi import Depends, Header, Query, Request
from fastapi.exceptions import RequestValidationError
from fastapi.responses import Response
from pydantic import AfterValidator, BaseModel
from starlette.exceptions import HTTPException
from starlette.requests import HTTPConnection

from mikas.cleaning import clean_line, clean_text
from mikas.dashboard.dashboard import Dashboard
from mikas.dashboard.error_responses import status_of
from mikas.dashboard.errors import BadRequest, NotAllowed, OnlyHere
from mikas.dashboard.library.folder import RecordingFile
from mikas.dashboard.library.service import RecordingService
from mikas.dashboard.security.access import check_from_network
from mikas.dashboard.security.control import Client
from mikas.errors import MikasError
from mikas.i18n import Text

T = TypeVar("T")

GONE = 499  # the usual status for logs; no client receives it
_ID = re.compile(r"[A-Za-z0-9-]{8,64}")
_MAX_NAME = 40
_UNUSED = (400, 403, 404, 410, 413)  # statuses of invalid or refused requests

NO_CLIENT_ID = Text(
    "the header X-Mikas-Client must have 8 to 64 letters, digits or hyphens",
    "в заголовке X-Mikas-Client нужны от 8 до 64 латинских букв, цифр или дефисов",
)
ClientId = Annotated[
    str | None,
    Header(
        alias="X-Mikas-Client",
        description="a secret of the client, chosen at random: 8 to 64 letters, digits, hyphens",
    ),
]
ClientName = Annotated[
    str | None,
    Header(alias="X-Mikas-Name", description="the client's name for people, URI-encoded"),
]

Names = Annotated[str | None, Query(max_length=4000, description="A,B; all")]
Line = Annotated[str, AfterValidator(clean_line)]
"""A person's words on one line; `mikas.cleaning` has replaced what no screen or file can take."""
Words = Annotated[str, AfterValidator(clean_text)]
"""The same with line feeds and tabs."""


def split_names(names: str | None) -> list[str] | None:
    """Return the names in `A,B`; None: all."""
    return None if names is None else [name for name in names.split(",") if name]


def client_of(request: HTTPConnection, identity: str | None, name: str | None) -> Client:
    """Return the client of that id and name. Raises `BadRequest` for an invalid id."""
    state = request.scope["state"]
    if identity is None or not _ID.fullmatch(identity):
        raise BadRequest(problem=NO_CLIENT_ID)
    may_control, local = state["rights"] == "control", state["local"]
    words = clean_line(unquote(name or ""), _MAX_NAME)
    return Client.with_secret(identity, words, may_control=may_control, local=local)


def address_of(request: HTTPConnection) -> str | None:
    """Return the address of a client in the network; None: it is on this computer."""
    if request.scope["state"]["local"]:
        return None
    return request.client.host if request.client else "unknown"


def _dashboard(request: Request) -> Dashboard:
    dashboard: Dashboard = request.app.state.dashboard
    return dashboard


TheDashboard = Annotated[Dashboard, Depends(_dashboard)]


def _viewer(request: Request, client_id: ClientId = None, client_name: ClientName = None) -> Client:
    if client_id is None:
        return Client("", "", request.scope["state"]["rights"] == "control")
    return client_of(request, client_id, client_name)


def json_of(model: BaseModel) -> Response:
    """Return the response with `model`; to be called in a thread, as a long one takes its time."""
    return Response(model.model_dump_json(), media_type="application/json")


class Requester:
    """The client that waits for work, which is done in the lanes of the dashboard's library.

    A route whose work grows with data, or with what the client sends, has this dependency; a test
    (`tests/dashboard/test_work_of_routes.py`) names the routes that need none.
    """

    def __init__(self, request: Request, dashboard: TheDashboard) -> None:
        self._request = request
        self.dashboard: TheDashboard = dashboard
        self.library: RecordingService = dashboard.library
        self.address: str | None = address_of(request)

    async def view(
        self, identity: str, look: Callable[[RecordingFile], T], *, virtual: bool = False
    ) -> T:
        """Return `look(file)`, called in a thread. Raises `NotFound`, `Busy`, `TookTooLong`.

        `virtual`: also of a recording of the virtual car.
        """
        library = self.library

        def work() -> T:
            return look(library.of_any(identity) if virtual else library.folder.one(identity))

        with library.views.place(self.address):
            return await self.awaits(library.views.run(work, key=identity, address=self.address))

    async def make(self, key: str, work: Callable[[], T]) -> T:
        """Return the result of `work`, which takes long. Raises `Busy`, `TookTooLong`."""
        files = self.library.files
        with files.place(self.address):
            return await self.awaits(files.run(work, key=key, address=self.address))

    async def compute(self, work: Callable[[], T]) -> T:
        """Return the result of `work` on live data, lists or the user's files.

        Raises `Busy`, `TookTooLong`.
        """
        answers = self.library.answers
        with answers.place(self.address):
            return await self.awaits(answers.run(work, key=None, address=self.address))

    async def answer(self, work: Callable[[], BaseModel]) -> Response:
        """Return the response with the model that `work` returns, made as in `compute`."""
        return await self.compute(lambda: json_of(work()))

    async def awaits(self, work: Coroutine[Any, Any, T]) -> T:
        """Return the result of `work`, which is cancelled when the client disconnects."""
        working = asyncio.create_task(work)
        leaving = asyncio.create_task(self._leave())
        try:
            await asyncio.wait({working, leaving}, return_when=asyncio.FIRST_COMPLETED)
            if not working.done():
                leaving.result()  # it may have sent too long a body
                raise HTTPException(GONE, "the client has disconnected")
            return working.result()
        finally:
            working.cancel()
            leaving.cancel()
            await asyncio.wait({working, leaving})

    async def _leave(self) -> None:
        while (await self._request.receive())["type"] != "http.disconnect":
            pass


TheRequester = Annotated[Requester, Depends(Requester)]
Viewer = Annotated[Client, Depends(_viewer)]
"""Any client; one without an id has an empty one."""


def _known(client: Viewer) -> Client:
    if not client.id:
        raise BadRequest(problem=NO_CLIENT_ID)
    if not client.may_control:
        raise NotAllowed
    return client


KnownClient = Annotated[Client, Depends(_known)]
"""A client with control rights and an id, which need not hold the lease."""


def _local(client: KnownClient) -> Client:
    if not client.local:
        raise OnlyHere
    return client


LocalClient = Annotated[Client, Depends(_local)]
"""A client with control rights and an id, on this computer."""


async def _controller(
    dashboard: TheDashboard, client: KnownClient, request: Request
) -> AsyncIterator[Client]:
    undo = dashboard.control.demand(client, take=request.method != "GET")
    try:
        yield client
    except (RequestValidationError, MikasError) as error:
        if not isinstance(error, MikasError) or status_of(error) in _UNUSED:
            undo()
        raise


Controller = Annotated[Client, Depends(_controller)]


async def port_named(dashboard: Dashboard, client: Client, url: str | None) -> str | None:
    """Return the port that the client names, by the URL that it was shown if it is in use.

    Raises `NotFromNetwork`, `BadPortUrl` for one that it may not name. The port in use, and None,
    the one likely adapter, are always allowed.
    """
    port = dashboard.connection.port
    if port is not None and url in (port.url, port.shown):
        return port.url
    if url is not None and not client.local:
        await asyncio.to_thread(check_from_network, url, dashboard.settings.find)
    return url
