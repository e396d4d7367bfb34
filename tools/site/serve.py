"""python -m tools.site.serve: build/site on this computer, and a browser that shows it.

What the page keeps (recordings, settings) belongs to its address, so the port is the same each
time as long as it is free.
"""

from __future__ import annotations

import argparse
import sys
import webbrowser
from collections.abc import Callable
from functools import partial
from http import HTTPStatus
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

SITE = Path(__file__).resolve().parents[2] / "build" / "site"
PORT = 8075

# The system's registry may have other types; browsers refuse modules and WebAssembly of those.
_TYPES = {
    ".css": "text/css", ".html": "text/html", ".js": "text/javascript", ".json": "application/json",
    ".mjs": "text/javascript", ".pack": "application/octet-stream", ".png": "image/png",
    ".svg": "image/svg+xml", ".wasm": "application/wasm",
    ".webmanifest": "application/manifest+json", ".zip": "application/zip",
}  # fmt: skip
_ELSEWHERE = """\
Port {port} is in use, perhaps by another `make page`: then go on at http://localhost:{port}/
A browser keeps recordings for each address, so this page does not show those made there."""
_FOREVER = "public, max-age=31536000, immutable"


class Handler(SimpleHTTPRequestHandler):
    """Sends files; says nothing on the terminal."""

    protocol_version = "HTTP/1.1"
    extensions_map = _TYPES | {"": "application/octet-stream"}

    def end_headers(self) -> None:
        # Names with a hash in them; a browser asks for all others again, and for what is not there.
        hashed = self.path.lstrip("/").startswith(("assets/", "program-"))
        self.send_header("Cache-Control", _FOREVER if hashed and self._is_here else "no-cache")
        super().end_headers()

    def send_response(self, code: int, message: str | None = None) -> None:
        self._is_here = code < HTTPStatus.BAD_REQUEST
        super().send_response(code, message)

    def log_message(self, format: str, *args: object) -> None:  # noqa: A002 (its own name)
        pass


class Server(ThreadingHTTPServer):
    """Ends at once, whatever a browser still reads."""

    daemon_threads = True


def server_of(site: Path, port: int) -> Server:
    """Return a server of `site` on this computer alone, at `port` or at any that is free."""
    handler = partial(Handler, directory=str(site))
    try:
        return Server(("127.0.0.1", port), handler)
    except OSError:
        return Server(("127.0.0.1", 0), handler)


def main(show: Callable[[str], object] = webbrowser.open) -> int:
    """Serve until Ctrl-C; return the exit status."""
    parser = argparse.ArgumentParser(prog="python -m tools.site.serve")
    parser.add_argument("--no-browser", action="store_true", help="only print the address")
    arguments = parser.parse_args()
    if not (SITE / "index.html").is_file():
        print("There is no build/site: make site", file=sys.stderr)
        return 1
    with server_of(SITE, PORT) as server:
        address = f"http://localhost:{server.server_port}/"
        try:
            if server.server_port != PORT:
                print(_ELSEWHERE.format(port=PORT))
            print(f"{address}  (Ctrl-C ends it)", flush=True)
            if not arguments.no_browser:
                show(address)
            server.serve_forever()
        except KeyboardInterrupt:
            print()
    return 0


if __name__ == "__main__":
    sys.exit(main())
