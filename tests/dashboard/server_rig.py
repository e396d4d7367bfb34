"""The application behind its own server, on a socket."""

from __future__ import annotations

import asyncio
import threading
from contextlib import contextmanager
from dataclasses import dataclass

import httpx
from anyio.from_thread import start_blocking_portal
from websockets.asyncio.client import connect as connect_in_a_loop
from websockets.sync.client import connect

from mikas.dashboard.app import create_app
from mikas.dashboard.network.listening import listen
from mikas.dashboard.security.access import Access
from mikas.dashboard.server import Server


@dataclass
class Reached:
    """How the application is reached."""

    access: Access
    client: httpx.Client
    server: Server
    loop: asyncio.AbstractEventLoop
    """The server's."""

    def open(self, address, headers):
        """A WebSocket."""
        url = f"ws://127.0.0.1:{self.access.port}{address}"
        return connect(url, additional_headers=headers, open_timeout=60)


@contextmanager
def watching(url, tls, **settings):
    """A function that waits for the next message of the WebSocket at wss:// `url`.

    In the one thread of a loop: `websockets.sync` reads in one thread while another one writes,
    which Python's TLS does not stand; 13 of 600 such connections ended in their handshake.
    """
    opening = connect_in_a_loop(url, ssl=tls, open_timeout=60, **settings)
    with start_blocking_portal() as portal, portal.wrap_async_context_manager(opening) as socket:
        yield lambda: portal.call(asyncio.wait_for, socket.recv(), 60)


@contextmanager
def served(dashboard, page, tls, access):
    """`page`: the folder of the built page; `access`: settings of `Access`."""
    with listen(0, lan=False) as own:
        rules = Access(own.getsockname()[1], **access)
        ready = threading.Event()
        loops = []

        def begun():
            loops.append(asyncio.get_running_loop())
            ready.set()

        server = Server(create_app(dashboard, rules, folder=page), ready=begun, tls=tls)
        thread = threading.Thread(target=server.run, kwargs={"sockets": [own]})
        thread.start()
        try:
            assert ready.wait(60)
            url = f"http://127.0.0.1:{rules.port}"
            # Without TLS: to load the system's certificates takes as long as to start the server.
            with httpx.Client(base_url=url, timeout=60, verify=False) as client:
                yield Reached(rules, client, server, loops[0])
        finally:
            server.should_exit = True
            thread.join()
