"""A static host, as any that could serve the site: files of a folder, and nothing else."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

from .computer_rig import ORIGIN, Computer

Answer = Callable[[bytes], bytes | None]


class StaticHost:
    """Serves `folder` at `ORIGIN` of the computer's network until it is stopped.

    `answers`: what a page can ask the test by POST, by its path.
    """

    url = ORIGIN

    def __init__(
        self, computer: Computer, folder: Path, answers: Mapping[str, Answer] | None = None
    ) -> None:
        self._computer, self._folder, self._answers = computer, folder, answers or {}
        self.start()

    def start(self) -> None:
        """Again, after `stop`: the network is there."""
        handler = partial(_Handler, directory=str(self._folder))
        self._server = ThreadingHTTPServer(("", 0), handler, bind_and_activate=False)
        self._server.socket.close()
        self._server.socket = self._computer.listen()
        self._server.answers = self._answers
        self._thread = threading.Thread(target=self._server.serve_forever, args=(0.01,))
        self._thread.start()

    def stop(self) -> None:
        """Answer no more: the network is gone."""
        if self._thread.is_alive():
            self._server.shutdown()
            self._server.server_close()
            self._thread.join()


class _Handler(SimpleHTTPRequestHandler):
    extensions_map = SimpleHTTPRequestHandler.extensions_map | {
        ".mjs": "text/javascript", ".wasm": "application/wasm",
    }  # fmt: skip

    def do_POST(self) -> None:
        answer = self.server.answers[self.path]
        body = answer(self.rfile.read(int(self.headers["Content-Length"]))) or b""
        self.send_response(200)
        self.send_header("Content-Length", str(len(body)))
        self.end_headers()
        self.wfile.write(body)

    def log_message(self, *_: object) -> None:
        """Say nothing."""
