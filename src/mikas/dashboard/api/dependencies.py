"""What a route is given: who asks, whether it may, and the hub.

    @router.post("/connect")
    async def connect(hub: TheHub, _: Controller) -> State: ...

`Viewer`: anybody who was let in. `Controller`: holds the seat, or gets it now; else 403 or 409. A
GET only looks: it is let pass while the seat is free, and does not take it.
"""

from __future__ import annotations

import re
from collections.abc import AsyncIterator
from typing import Annotated
from urllib.parse import unquote

from fastapi import Depends, Header, Request
from fastapi.exceptions import RequestValidationError

from mikas.dashboard.api.errors import status_of
from mikas.dashboard.dashboard import Hub
from mikas.dashboard.errors import BadRequest, NotAllowed
from mikas.dashboard.security.control import Client
from mikas.errors import MikasError
from mikas.i18n import Text

ID = re.compile(r"[A-Za-z0-9-]{8,64}")
_LONGEST_NAME = 40
_NO_USE = (400, 403, 404, 410, 413)  # not understood, or not allowed

WHO = Text(
    "the header X-Mikas-Client must hold 8 to 64 letters, digits or hyphens",
    "в заголовке X-Mikas-Client нужны от 8 до 64 латинских букв, цифр или дефисов",
)
ClientId = Annotated[
    str | None,
    Header(alias="X-Mikas-Client", description="who asks: 8 to 64 letters, digits, hyphens"),
]
ClientName = Annotated[
    str | None,
    Header(alias="X-Mikas-Name", description="the same for a person, URI-encoded"),
]


def client_of(identity: str | None, name: str | None, *, may_control: bool) -> Client:
    """The client of that id and name. Raises `BadRequest` for an id that is none."""
    if identity is None or not ID.fullmatch(identity):
        raise BadRequest(problem=WHO)
    shown = "".join(c for c in unquote(name or "") if c.isprintable())[:_LONGEST_NAME]
    return Client(identity, shown, may_control)


def _hub(request: Request) -> Hub:
    hub: Hub = request.app.state.hub
    return hub


def _may_control(request: Request) -> bool:
    return bool(request.scope["state"]["rights"] == "control")


def _viewer(request: Request, client_id: ClientId = None, client_name: ClientName = None) -> Client:
    if client_id is None:
        return Client("", "", _may_control(request))
    return client_of(client_id, client_name, may_control=_may_control(request))


def _asker(request: Request, client_id: ClientId = None, client_name: ClientName = None) -> Client:
    client = client_of(client_id, client_name, may_control=_may_control(request))
    if not client.may_control:
        raise NotAllowed
    return client


TheHub = Annotated[Hub, Depends(_hub)]
Viewer = Annotated[Client, Depends(_viewer)]
"""Anybody; one that gave no id has an empty one."""
Asker = Annotated[Client, Depends(_asker)]
"""With rights and an id, but it need not hold the seat."""


async def _controller(hub: TheHub, client: Asker, request: Request) -> AsyncIterator[Client]:
    before = hub.seat.demand(client, take=request.method != "GET")
    try:
        yield client
    except (RequestValidationError, MikasError) as error:
        if not isinstance(error, MikasError) or status_of(error) in _NO_USE:
            hub.seat.take_back(before)
        raise


Controller = Annotated[Client, Depends(_controller)]
