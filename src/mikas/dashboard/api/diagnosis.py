"""The doctor's steps, told as they end; the session lets go of the port meanwhile and comes back.

The examination is a task of its own: it ends by itself, when it is stopped, or when whoever asked
for it listens no more; the port is given back all the same.
"""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator

from fastapi import APIRouter
from fastapi.responses import StreamingResponse
from pydantic import BaseModel, Field

from mikas.client.doctor import Step
from mikas.dashboard.advice import ADVICE
from mikas.dashboard.api.dependencies import Controller, TheHub
from mikas.dashboard.api.errors import TwoTexts, errors, two, two_or_none
from mikas.dashboard.api.state import State, state_of
from mikas.dashboard.dashboard import Hub
from mikas.dashboard.errors import Busy
from mikas.dashboard.security.ports import TheReach
from mikas.dashboard.session.diagnosis import Examination
from mikas.dashboard.session.manager import CHANGING
from mikas.errors import MikasError
from mikas.i18n import Text
from mikas.link.urls import parse

router = APIRouter(tags=["connection"])

_TITLES = {
    "port": Text("port", "порт"),
    "echo": Text("echo", "эхо"),
    "baud": Text("baud rate", "скорость"),
    "latency": Text("latency", "задержка"),
    "line": Text("line", "линия"),
    "ecu": Text("ECU", "блок"),
    "commands": Text("commands", "команды"),
}


class DiagnosisRequest(BaseModel):
    """`port` null: that of the connection, or the one likely adapter."""

    port: str | None = Field(None, max_length=500)


class DiagnosisStep(BaseModel):
    """One line of the answer. `ok` null: could not be told, or could be better."""

    name: str
    title: TwoTexts
    ok: bool | None
    detail: TwoTexts
    to_try: TwoTexts | None


_NDJSON = "application/x-ndjson"
_LINE = {"$ref": "#/components/schemas/DiagnosisStep"}


@router.post(
    "/doctor",
    response_class=StreamingResponse,
    responses={**errors(409, 503), 200: {"content": {_NDJSON: {"schema": _LINE}}}},
)
async def doctor(
    hub: TheHub, _: Controller, reach: TheReach, wish: DiagnosisRequest
) -> StreamingResponse:
    """Examines the connection; a line of JSON (`DiagnosisStep`) for each step as it ends."""
    await asyncio.to_thread(reach.check, wish.port)
    port = wish.port or (hub.way.url if hub.way else None)
    if port is None:
        port = await asyncio.to_thread(hub.switch.likely)
    parse(port)
    if hub.switch.changing or hub.examination is not None:
        raise Busy(problem=CHANGING)
    told: asyncio.Queue[DiagnosisStep | None] = asyncio.Queue()
    examination = Examination(port, hub.settings)
    hub.examination = examination
    examination.task = asyncio.create_task(_examine(hub, examination, told))

    async def lines() -> AsyncIterator[str]:
        try:
            while (step := await told.get()) is not None:
                yield step.model_dump_json() + "\n"
        finally:  # nobody listens any more; not awaited, for this may be a cancelled task
            asyncio.get_running_loop().run_in_executor(None, examination.stop)

    return StreamingResponse(lines(), media_type=_NDJSON)


@router.post("/doctor/stop", responses=errors(409))
async def stop(hub: TheHub, client: Controller) -> State:
    """Ends the examination, if there is one; answers when the port was let go of."""
    if hub.examination is not None:
        await hub.examination.end()
    return state_of(hub, client)


async def _examine(
    hub: Hub, examination: Examination, told: asyncio.Queue[DiagnosisStep | None]
) -> None:
    loop = asyncio.get_running_loop()

    def tell(step: Step) -> None:
        loop.call_soon_threadsafe(told.put_nowait, _line(step))

    try:
        async with hub.switch.lent():
            await asyncio.to_thread(examination.run, tell)
    except MikasError as error:
        told.put_nowait(_line(Step("port", False, ADVICE.text(error))))
    finally:
        hub.examination = None
        told.put_nowait(None)


def _line(step: Step) -> DiagnosisStep:
    advice, to_try = Text("", ""), None
    if step.error is not None:
        advice, to_try = step.error.advice, ADVICE.advice(step.error)
    found = Text(
        *(
            detail.removesuffix(shown).strip()
            for detail, shown in zip(step.detail, advice, strict=True)
        )
    )
    return DiagnosisStep(
        name=step.name,
        title=two(_TITLES[step.name]),
        ok=step.ok,
        detail=two(found),
        to_try=two_or_none(to_try),
    )
