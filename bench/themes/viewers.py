"""What a viewer's work costs the owner: thirty-two requests at once, by time and memory.

python -m bench.themes.viewers     the program of the measurement, until its input ends
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Final

from bench.rows import Row, Scope, Theme

if TYPE_CHECKING:
    from httpx import Client

    from mikas.dashboard.server import Server

_ROWS: Final = 216_000  # two hours at thirty a second
_AT_ONCE: Final = 32
_POWERS: Final = f"max({','.join(['FREQ**1.1'] * 94)})>1"
_PRODUCTS: Final = f"{'+'.join(['FREQ*JAIR'] * 48)}>1"
_REQUESTS: Final = {
    "searches with 94 powers each": ("/history/find", {"expression": _POWERS}),
    "searches with 48 products each": ("/history/find", {"expression": _PRODUCTS}),
    "histories of 20,000 points": ("/history", {"points": "20000", "seconds": "86400"}),
}
_QUIET: Final = 10.0  # s until freed memory has been given back

_METHOD = """\
A program that holds two hours of all parameters, 30 rows a second, and a client in the network
that may only view and sends 32 requests at once. A second later the owner's page, on this computer,
asks for the state, three times; memory is looked at when all are answered and the program has been
quiet for ten seconds."""


def run(scope: Scope) -> Iterator[Theme]:
    with subprocess.Popen(
        [sys.executable, "-m", "bench.themes.viewers", str(scope.of(_ROWS, _ROWS // 10))],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    ) as process:
        try:
            assert process.stdout is not None
            yield Theme("Viewers at work", _METHOD, list(_rows(process.pid, process.stdout)))
        finally:
            process.kill()


def _rows(process: int, output: Iterator[str]) -> Iterator[Row]:
    import httpx

    reached = json.loads(next(iter(output)))
    url = f"http://127.0.0.1:{reached['port']}/api"
    viewer = {"X-Forwarded-For": "192.168.0.7", "Cookie": reached["cookie"]}
    with httpx.Client(base_url=url, timeout=600) as owner:
        yield Row("the state, nothing else asked for", _states(owner), "s", 3)
        for what, (path, query) in _REQUESTS.items():
            before = _resident(process)

            def ask(path: str = path, query: dict[str, str] = query) -> None:
                httpx.get(f"{url}{path}", params=query, headers=viewer, timeout=600)

            asking = [threading.Thread(target=ask) for _ in range(_AT_ONCE)]
            for thread in asking:
                thread.start()
            time.sleep(1)  # until they are in the lanes: real time is what is measured
            yield Row(f"the state during {what}", _states(owner), "s", 3, at_most=1)
            for thread in asking:
                thread.join()
            time.sleep(_QUIET)  # until the lanes have given their memory back
            left = _resident(process) - before
            yield Row(f"memory after {what}", [left], "MB", 0, at_most=200)


def _states(owner: Client) -> list[float]:
    taken = []
    for _ in range(3):
        began = time.perf_counter()
        owner.get("/state").raise_for_status()
        taken.append(time.perf_counter() - began)
    return taken


def _resident(process: int) -> float:
    """MB that a process has in memory."""
    pages = int(Path(f"/proc/{process}/statm").read_text("utf-8").split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6


def _serve(rows: int) -> None:
    """Serve a dashboard that has sampled for so many rows, until the input ends."""
    from mikas.catalog import shipped
    from mikas.dashboard.app import create_app
    from mikas.dashboard.dashboard import Dashboard
    from mikas.dashboard.network.listening import listen
    from mikas.dashboard.security.access import Access
    from mikas.dashboard.server import Server
    from mikas.dashboard.settings import Settings

    with TemporaryDirectory() as folder, listen(0, lan=False) as own:
        dashboard = Dashboard(Settings(Path(folder), state=Path(folder)), lan=True)
        names = tuple(parameter.name for parameter in shipped().parameters)
        for at in range(rows):
            values = {"FREQ": 900.0 + at % 3000}
            row = [values.get(name, 50.0 + at % 7) for name in names]
            dashboard.history.add(1e9 + at / 30, names, row)
        access = Access(own.getsockname()[1], lan=True)
        cookie = f"{access.cookie}={access.token}"

        def ready() -> None:
            print(json.dumps({"port": access.port, "cookie": cookie}), flush=True)

        server = Server(create_app(dashboard, access), ready=ready)
        threading.Thread(target=_end_with_input, args=(server,), daemon=True).start()
        server.run(sockets=[own])


def _end_with_input(server: Server) -> None:
    sys.stdin.read()
    server.should_exit = True


if __name__ == "__main__":
    _serve(int(sys.argv[1]))
