"""Take docs/pictures/en/dask.png: Dask's own page while `mikas fleet add` uses a cluster of two.

    python docs/pictures/dask_picture.py /tmp/dask/bin/python

The argument is the Python of an environment that can import mikas and distributed as this one can,
and in which `pip install bokeh` was called, which the page needs. The window is Chromium's.
"""

from __future__ import annotations

import subprocess
import sys
from contextlib import ExitStack, suppress
from io import BytesIO
from pathlib import Path
from tempfile import TemporaryDirectory
from time import sleep
from urllib.error import URLError
from urllib.request import urlopen

from PIL import Image
from playwright.sync_api import sync_playwright

PICTURE = Path(__file__).parent / "en" / "dask.png"
SCHEDULER, PAGE = "127.0.0.1:8786", "127.0.0.1:8787"
CARS = 24
SHOWN_AFTER = 5_000  # ms of work: each worker has added several recordings
CROP = (0, 0, 1200, 760)
COLOURS = 64


def main() -> None:
    """Take the picture."""
    dask = [sys.argv[1], "-m"]
    with TemporaryDirectory() as folder, ExitStack() as started:
        for car in range(CARS):
            port = f"sim:?clock=simulated&scenario=city&seed={car}"
            _mikas(
                "log", "--port", port, "--duration", "300", "--plate", f"A{car:03}MP52",
                "-o", f"{folder}/drive-{car}.pcapng",
            )  # fmt: skip
        scheduler = ["distributed.cli.dask_scheduler", "--host", SCHEDULER, "--dashboard-address"]
        worker = ["distributed.cli.dask_worker", SCHEDULER, "--nthreads=1", "--no-dashboard"]
        for words in ([*scheduler, PAGE], worker, worker):
            process = subprocess.Popen([*dask, *words], cwd=folder)
            started.callback(process.wait)
            started.callback(process.terminate)
        _picture(folder).save(PICTURE, optimize=True)


def _picture(folder: str) -> Image.Image:
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path="/usr/bin/chromium", args=["--no-sandbox"]
        )
        page = browser.new_page(viewport={"width": CROP[2], "height": CROP[3]})
        _wait_for_it()
        page.goto(f"http://{PAGE}/status")
        page.locator("canvas").first.wait_for()
        program = [sys.executable, "-m", "mikas", "fleet", "add", folder, "--to"]
        added = subprocess.Popen(
            [*program, f"{folder}/dataset", "--executor", f"dask://{SCHEDULER}"]
        )
        page.wait_for_timeout(SHOWN_AFTER)
        taken = Image.open(BytesIO(page.screenshot())).convert("RGB").crop(CROP)
        added.wait()
        browser.close()
    return taken.quantize(COLOURS, dither=Image.Dither.NONE)


def _wait_for_it() -> None:
    while True:
        with suppress(URLError):
            urlopen(f"http://{PAGE}/status").close()
            return
        sleep(0.2)


def _mikas(*words: str) -> None:
    subprocess.run([sys.executable, "-m", "mikas", *words], check=True)


if __name__ == "__main__":
    main()
