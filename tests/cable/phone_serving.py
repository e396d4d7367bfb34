"""In the guest: open a page of a folder in Chromium, and print what the page says, a line each.

    python phone_serving.py FOLDER PORT CHROMIUM PICTURES [FLAG …]

The page sends JSON to `/say`, of each adapter its ids and what came of it, and has the answer: the
chip's name, and the program's own words if the adapter was refused. `{"end": true}` is the last:
then the page's pictures are taken, PICTURES-en.png and PICTURES-ru.png, and this ends.
"""

from __future__ import annotations

import base64
import json
import subprocess
import sys
import threading
import urllib.request
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

from websockets.sync.client import connect

from mikas.browser.refusals import refusal
from mikas.link.base import BAUD
from mikas.link.chips import chip_of
from mikas.link.ports import Port

FLAGS = (
    "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync",
    "--disable-dev-shm-usage", "--user-data-dir=/run/p/profile", "--window-size=400,760",
    "--force-device-scale-factor=2", "--remote-debugging-port=9222", "--remote-allow-origins=*",
)  # fmt: skip
_PULSE = 30.0  # s; who waits for the next line gives up after minutes
_PATIENCE = 120.0  # s


class Handler(SimpleHTTPRequestHandler):
    def do_POST(self) -> None:
        said = json.loads(self.rfile.read(int(self.headers["Content-Length"])))
        answer = json.dumps({} if "end" in said else about(said)).encode()
        self.send_response(200)
        self.send_header("Content-Length", str(len(answer)))
        self.end_headers()
        self.wfile.write(answer)
        print(json.dumps(said | json.loads(answer), ensure_ascii=False), flush=True)
        if "end" in said:
            threading.Thread(target=self.server.shutdown).start()

    def log_message(self, *_: object) -> None:
        """Say nothing."""


def about(said: dict) -> dict[str, str]:
    """Return what the program would say of this adapter."""
    vid, pid = said["ids"]["usbVendorId"], said["ids"]["usbProductId"]
    chip, _ = chip_of(vid, pid)
    if "failed" not in said:
        return {"chip": chip}
    url = f"webusb:{vid:04x}:{pid:04x}"
    error = refusal(
        url, Port(url, chip, chip, likely=True, vid=vid, pid=pid), BAUD, *said["failed"]
    )
    return {"chip": chip, "en": error.text.en, "ru": error.text.ru}


def show_life() -> None:
    """Print a line every half a minute from now on."""
    ended = threading.Event()

    def show() -> None:
        while not ended.wait(_PULSE):
            print("…", flush=True)

    threading.Thread(target=show, daemon=True).start()


def take(pictures: str) -> None:
    """Take the pictures of the one page that is open."""
    with urllib.request.urlopen("http://127.0.0.1:9222/json", timeout=_PATIENCE) as listed:
        (page,) = (it for it in json.load(listed) if it["type"] == "page")
    with connect(page["webSocketDebuggerUrl"], max_size=None, open_timeout=_PATIENCE) as devtools:

        def do(method: str, **params: object) -> dict:
            devtools.send(json.dumps({"id": 1, "method": method, "params": params}))
            while "result" not in (answer := json.loads(devtools.recv(_PATIENCE))):
                pass
            return answer["result"]

        for language in ("en", "ru"):
            do("Runtime.evaluate", expression=f"draw('{language}')")
            shot = do("Page.captureScreenshot", captureBeyondViewport=True)
            Path(f"{pictures}-{language}.png").write_bytes(base64.b64decode(shot["data"]))


def main(folder: str, port: str, program: str, pictures: str, *flags: str) -> None:
    show_life()
    handler = partial(Handler, directory=folder)
    with (
        Path("/run/p/log").open("w") as log,
        ThreadingHTTPServer(("127.0.0.1", int(port)), handler) as server,
    ):
        words = [program, *FLAGS, *flags, f"http://localhost:{port}/"]
        chromium = subprocess.Popen(words, stdout=log, stderr=log)
        try:
            server.serve_forever()
            take(pictures)
        finally:
            chromium.kill()
            chromium.wait()


if __name__ == "__main__":
    main(*sys.argv[1:])
