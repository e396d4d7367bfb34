"""The doctor's steps, told as they end; the session lets go of the port meanwhile and comes back.

The examination is a task of its own: whoever asked for it may close the page, the port is given
back all the same.
"""

from __future__ import annotations

import asyncio
import json
from collections.abc import AsyncIterator
from contextlib import suppress
from typing import Any

from fastapi import APIRouter
from fastapi.responses import StreamingResponse
from pydantic import BaseModel, Field

from mikas.client.doctor import Step, examine
from mikas.dashboard.answers import TwoTexts, errors
from mikas.dashboard.asking import Controller, TheHub
from mikas.dashboard.happenings import both
from mikas.dashboard.hub import Hub
from mikas.dashboard.reach import TheReach
from mikas.dashboard.refusals import Busy
from mikas.language import Text
from mikas.link import Link
from mikas.link.urls import parse
from mikas.tester import Echo, Tester, Timing

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
_BUSY = Text("the connection is being changed", "соединение как раз меняется")


class DoctorWish(BaseModel):
    """`port` null: that of the connection, or the one likely adapter."""

    port: str | None = Field(None, max_length=500)


class DoctorStep(BaseModel):
    """One line of the answer. `ok` null: could not be told, or could be better."""

    name: str
    title: TwoTexts
    ok: bool | None
    detail: TwoTexts
    to_try: TwoTexts | None


@router.post(
    "/doctor",
    response_class=StreamingResponse,
    responses={**errors(409, 503), 200: {"content": {"application/x-ndjson": {}}}},
)
async def doctor(
    hub: TheHub, _: Controller, reach: TheReach, wish: DoctorWish
) -> StreamingResponse:
    """Examines the connection; a line of JSON (`DoctorStep`) for each step as it ends."""
    await asyncio.to_thread(reach.check, wish.port)
    port = wish.port or (hub.way.url if hub.way else None)
    if port is None:
        port = await asyncio.to_thread(hub.switch.likely)
    parse(port)
    if hub.switch.changing:
        raise Busy(problem=_BUSY)
    told: asyncio.Queue[dict[str, Any] | None] = asyncio.Queue()
    task = asyncio.create_task(_examine(hub, port, told))
    hub.tasks.add(task)
    task.add_done_callback(hub.tasks.discard)

    async def lines() -> AsyncIterator[str]:
        while (step := await told.get()) is not None:
            yield json.dumps(step, ensure_ascii=False) + "\n"

    return StreamingResponse(lines(), media_type="application/x-ndjson")


async def _examine(hub: Hub, port: str, told: asyncio.Queue[dict[str, Any] | None]) -> None:
    loop = asyncio.get_running_loop()

    def tell(step: dict[str, Any]) -> None:
        loop.call_soon_threadsafe(told.put_nowait, step)

    try:
        async with hub.switch.lent():
            await asyncio.to_thread(_run, hub, port, tell)
    except Busy as error:
        tell(_line(Step("port", False, error.text)))
    finally:
        told.put_nowait(None)


def _run(hub: Hub, port: str, tell: Any) -> None:  # noqa: ANN401  (a plain function)
    settings = hub.settings

    def tester(link: Link) -> Tester:
        return Tester(
            link,
            timing=Timing(first_byte=settings.timeout),
            echo=Echo(settings.echo),
            retries=settings.retries,
        )

    with suppress(GeneratorExit):
        for step in examine(lambda: settings.open_port(port), tester, hub.catalog):
            tell(_line(step))


def _line(step: Step) -> dict[str, Any]:
    to_try = step.to_try or Text("", "")
    found = Text(
        *(
            detail.removesuffix(advice).strip()
            for detail, advice in zip(step.detail, to_try, strict=True)
        )
    )
    return {
        "name": step.name,
        "title": both(_TITLES[step.name]),
        "ok": step.ok,
        "detail": both(found),
        "to_try": both(to_try),
    }
