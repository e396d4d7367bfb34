"""In the guest: open a page of a folder in Chromium, and print what the page says, a line each.

    python phone_serving.py FOLDER PORT CHROMIUM [FLAG …]

The page sends JSON to `/say`; `{"end": true}` is the last, and ends this.
"""

from __future__ import annotations

import subprocess
import sys
import threading
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

FLAGS = (
    "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync",
    "--disable-dev-shm-usage",
)  # fmt: skip
_PULSE = 30.0  # s; who waits for the next line gives up after minutes


class Handler(SimpleHTTPRequestHandler):
    def do_POST(self) -> None:
        said = self.rfile.read(int(self.headers["Content-Length"])).decode()
        print(said, flush=True)
        self.send_response(200)
        self.send_header("Content-Length", "0")
        self.end_headers()
        if '"end"' in said:
            threading.Thread(target=self.server.shutdown).start()

    def log_message(self, *_: object) -> None:
        """Say nothing."""


def served(folder: str, port: int) -> ThreadingHTTPServer:
    """Return a server of this folder, to be started."""
    return ThreadingHTTPServer(("127.0.0.1", port), partial(Handler, directory=folder))


def show_life() -> None:
    """Print a line every half a minute from now on."""
    ended = threading.Event()

    def show() -> None:
        while not ended.wait(_PULSE):
            print("…", flush=True)

    threading.Thread(target=show, daemon=True).start()


def main(folder: str, port: str, program: str, *flags: str) -> None:
    show_life()
    words = [program, *FLAGS, "--user-data-dir=/run/p/profile", *flags, f"http://localhost:{port}/"]
    with Path("/run/p/log").open("w") as log, served(folder, int(port)) as server:
        chromium = subprocess.Popen(words, stdout=log, stderr=log)
        server.serve_forever()
        chromium.kill()
        chromium.wait()


if __name__ == "__main__":
    main(*sys.argv[1:])
