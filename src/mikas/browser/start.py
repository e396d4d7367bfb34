"""The program in a browser's worker: what `mikas dash` composes, over what JavaScript hands in.

There are two workers, each with the whole program. The line's has the cable and writes the kept
files. The reader's opens recordings, makes exports and reports, so that sampling never waits for
them; it only reads the kept files, and learns of the recording and the catalog in use.

All files are in the present folder, which JavaScript mounts: errors name `recordings/a.pcapng`,
not a place that no user knows.
"""

from __future__ import annotations

import asyncio
import gc
import threading
import warnings
from collections.abc import Callable, Mapping
from concurrent.futures import Future
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Literal, Protocol

from mikas.browser import arrays, green_threads, shallow_json, suspension
from mikas.browser.event_loop import EventLoop
from mikas.cancellation import at_each_check

if TYPE_CHECKING:
    from mikas.browser.asgi import BrowserPage, PageServer
    from mikas.dashboard.dashboard import Dashboard

Role = Literal["line", "reader"]
Take = Callable[[Mapping[str, Any]], None]
"""Takes a message of the page."""

KEPT: Final = Path()
_MADE_AGAIN: Final = Path("/tmp/mikas")  # in memory, of this worker alone
_YOUNG: Final = 1.0  # s between two looks for garbage among new objects
_ALL: Final = 60  # such looks; then among all objects since the start


class Host(green_threads.Stacks, Protocol):
    """The module `mikas_host`: what JavaScript hands in."""

    page: BrowserPage


def prepare(host: Host, run_sync: Callable[..., Any]) -> None:
    """Put threads, arrays and a safe JSON in place, before anything of the program is imported."""
    # Python's own collection, in steps, looks into the frames of all stacks, and those of suspended
    # ones are elsewhere meanwhile: it would crash. See `_collect`.
    gc.disable()
    green_threads.install(host, run_sync)
    at_each_check(suspension.give_way)
    arrays.install()
    shallow_json.install()
    _build_models_late()


def _build_models_late() -> None:
    """Let pydantic build a model at its first use, which most do not see in a session.

    FastAPI's description of an API and the API's own messages are 150 models: a quarter of a start.
    """
    from pydantic import BaseModel
    from pydantic.warnings import UnsupportedFieldAttributeWarning

    BaseModel.model_config["defer_build"] = True
    # FastAPI hides it where models are built at once: a request's body has an alias of its own.
    warnings.simplefilter("ignore", UnsupportedFieldAttributeWarning)


def begin(host: Host, role: Role) -> Take:
    """Start the program; return what takes the messages of the page once it runs.

    Raises what the start of the program raises.
    """
    ready: Future[Take] = Future()

    def run() -> None:
        loop = EventLoop()
        try:
            loop.run_until_complete(_run(host.page, role, ready))
        except BaseException as error:  # any: raised where the program is started
            ready.set_exception(error)

    threading.Thread(target=run, name="mikas event loop").start()
    return ready.result()


async def _run(page: BrowserPage, role: Role, ready: Future[Take]) -> None:
    from mikas.browser.asgi import PORT, PageServer
    from mikas.dashboard.app import create_app
    from mikas.dashboard.security.access import Access

    dashboard = _compose()
    app = create_app(dashboard, Access(PORT))
    async with app.router.lifespan_context(app):
        server = PageServer(app, page)
        taker = server if role == "line" else _Reader(dashboard, server)
        ready.set_result(taker.receive_message)
        await _collect()


def _compose() -> Dashboard:
    from mikas.browser.real_time import open_in_real_time
    from mikas.browser.web_serial import find_web_ports
    from mikas.catalog.own.file import OwnCatalog
    from mikas.client.connecting import ConnectionOptions
    from mikas.dashboard.dashboard import Dashboard
    from mikas.dashboard.settings import Settings, VirtualCars

    own = OwnCatalog(KEPT / "catalog.toml")
    return Dashboard(
        Settings(
            KEPT / "recordings",
            state=KEPT / "state",
            connection=ConnectionOptions(catalog=own.load().catalog, virtual_units=False),
            find=find_web_ports,
            open_port=VirtualCars(open_in_real_time).open,
            addresses=tuple,
            own=own,
            tests=KEPT / "tests",
            causes=KEPT / "causes",
            made_again=_MADE_AGAIN,
            sockets=False,
        )
    )


class _Reader:
    """The reader's program. `situation`: messages of what the line's worker does."""

    def __init__(self, dashboard: Dashboard, server: PageServer) -> None:
        self._dashboard, self._server = dashboard, server
        self._recording: str | None = None
        dashboard.library.in_progress = lambda: self._recording

    def receive_message(self, message: Mapping[str, Any]) -> None:
        """Take a message of the page."""
        if message["kind"] != "situation":
            return self._server.receive_message(message)
        self._recording = message["recording"]
        catalogs = self._dashboard.catalogs
        if message["catalog"] not in (None, catalogs.catalog.version):
            from mikas.errors import CatalogError

            with suppress(CatalogError):  # the one in use stays
                catalogs.change(None, lambda own, _: own.load().catalog)
        return None


async def _collect() -> None:
    """Collect garbage for ever; what the start has made stays."""
    gc.collect()
    gc.freeze()
    while True:
        for _ in range(_ALL):
            await asyncio.sleep(_YOUNG)
            gc.collect(0)
        gc.collect()
