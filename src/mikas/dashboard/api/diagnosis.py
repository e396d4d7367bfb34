"""Routes of the diagnosis: its steps, sent as each ends. The connection lends it the port.

The diagnosis is a task of its own: it ends after its last step, when it is stopped, or when its
client disconnects; the port is given back in each case.
"""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator

from fastapi import APIRouter
from fastapi.responses import StreamingResponse
from pydantic import BaseModel, Field

from mikas.client.doctor import Step
from mikas.dashboard.api.dependencies import Controller, TheDashboard, check_port
from mikas.dashboard.api.errors import TwoTexts, errors, made_of, two_or_none
from mikas.dashboard.api.state import State, state_of
from mikas.dashboard.dashboard import Dashboard
from mikas.dashboard.errors import ADVICE, Busy
from mikas.dashboard.session.connection import CHANGING
from mikas.dashboard.session.port_threads import Diagnosis
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
    """One line of the response. `ok` null: not known, or could be better."""

    name: str
    port: str = Field(description="the URL that is checked")
    title: TwoTexts
    ok: bool | None
    detail: TwoTexts
    to_try: TwoTexts | None
    code: str | None = Field(description="the class of the error: NoEcho…")


_NDJSON = "application/x-ndjson"
_LINE = {"$ref": "#/components/schemas/DiagnosisStep"}


@router.post(
    "/doctor",
    response_class=StreamingResponse,
    responses={**errors(409, 503), 200: {"content": {_NDJSON: {"schema": _LINE}}}},
)
async def doctor(
    dashboard: TheDashboard, client: Controller, body: DiagnosisRequest
) -> StreamingResponse:
    """Run the diagnosis; the response has a line of JSON (`DiagnosisStep`) for each step."""
    await check_port(dashboard, client, body.port)
    port = body.port or (dashboard.connection.port.url if dashboard.connection.port else None)
    if port is None:
        port = await asyncio.to_thread(dashboard.connection.likely)
    parse(port)
    if dashboard.connection.changing or dashboard.diagnosis is not None:
        raise Busy(problem=CHANGING)
    steps: asyncio.Queue[DiagnosisStep | None] = asyncio.Queue()
    diagnosis = Diagnosis(port, dashboard.settings)
    dashboard.diagnosis = diagnosis
    diagnosis.task = asyncio.create_task(_run(dashboard, diagnosis, steps))

    async def lines() -> AsyncIterator[str]:
        try:
            while (step := await steps.get()) is not None:
                yield step.model_dump_json() + "\n"
        finally:  # not awaited: this may be a cancelled task
            asyncio.get_running_loop().run_in_executor(None, diagnosis.stop)

    return StreamingResponse(lines(), media_type=_NDJSON)


@router.post("/doctor/stop", responses=errors(409))
async def stop(dashboard: TheDashboard, client: Controller) -> State:
    """Stop the diagnosis, if there is one; responds when its port is closed."""
    if dashboard.diagnosis is not None:
        await dashboard.diagnosis.stop_and_wait()
    return state_of(dashboard, client)


async def _run(
    dashboard: Dashboard, diagnosis: Diagnosis, steps: asyncio.Queue[DiagnosisStep | None]
) -> None:
    loop = asyncio.get_running_loop()

    def report(step: Step) -> None:
        loop.call_soon_threadsafe(steps.put_nowait, _line(diagnosis.url, step))

    try:
        async with dashboard.connection.lent():
            await asyncio.to_thread(diagnosis.run, report)
    except MikasError as error:
        steps.put_nowait(_line(diagnosis.url, Step("port", False, error.text, error)))
    finally:
        dashboard.diagnosis = None
        steps.put_nowait(None)


def _line(port: str, step: Step) -> DiagnosisStep:
    advice, to_try = Text("", ""), None
    if step.error is not None:
        advice, to_try = step.error.advice, ADVICE.advice(step.error)
    found = Text(
        *(
            detail.removesuffix(shown).strip()
            for detail, shown in zip(step.detail, advice, strict=True)
        )
    )
    code = type(step.error).__name__ if step.error else None
    shown = {"title": _TITLES[step.name], "detail": found, "to_try": two_or_none(to_try)}
    return made_of(DiagnosisStep, step, port=port, code=code, **shown)
