"""Take docs/pictures/{en,ru}/notebooks.png: a recording in JupyterLab's window, in both languages.

    python docs/pictures/jupyterlab_picture.py /tmp/lab/bin/jupyter

The argument is the `jupyter` of an environment in which `pip install jupyterlab` was called; its
kernel runs in this one. The window is Chromium's.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from time import sleep
from urllib.error import URLError
from urllib.request import urlopen

from PIL import Image
from playwright.sync_api import Page, sync_playwright

from mikas.recording.annotations.events import note_of
from mikas.recording.capture.writer import append_note
from mikas.sampling.events import Marker

HERE = Path(__file__).parent
ADDRESS = "http://127.0.0.1:8891"
WIDTH, HEIGHT, RIGHT = 1120, 1310, 35
TEXTS = {"en": ("Volga 3110", "hill"), "ru": ("Волга 3110", "подъём")}
CELLS = (
    "import mikas",
    'recording = mikas.open("drive.pcapng")\nrecording',
    'recording.plot(["FREQ", "RXX"], ["INJ", "JAIR"], figsize=(10, 4))',
)
TOWN = """
name = "town"
duration = 200
faults = [13]

[start]
ambient = 18
coolant = 84
coolant_at_start = 18
running = true

[timeline]
key = [[0, 1], [100, 0], [116, 1]]
starter = [[0, 0], [117, 1], [119, 0]]
speed = [
  [0, 0], [11, 0], [16, 18], [24, 18], [29, 0], [49, 0], [61, 36], [85, 34], [96, 0], [125, 0],
  [143, 55], [155, 50], [163, 36], [176, 38], [188, 0],
]
"""


def main() -> None:
    jupyter = Path(sys.argv[1])
    for language in TEXTS:
        with TemporaryDirectory() as folder:
            _prepare(Path(folder), language)
            with _lab(jupyter, Path(folder), language):
                _take(HERE / language / "notebooks.png")


def _prepare(folder: Path, language: str) -> None:
    """Record a drive with a fault, a gap and a marker, and write the notebook."""
    car, marker = TEXTS[language]
    (folder / "town.toml").write_text(TOWN)
    drive = folder / "drive.pcapng"
    port = f"sim:?clock=simulated&seed=2&scenario={folder / 'town.toml'}"
    channels = ["FREQ", "THR", "INJ", "JAIR", "UOZ", "TWAT/10", "UACC", "RXX"]
    command = ["log", "--port", port, "--car", car, "--duration", "200", "-o", str(drive)]
    subprocess.run(
        [sys.executable, "-m", "mikas", *command, *channels], check=True, capture_output=True
    )
    append_note(drive, note_of(Marker(70.0, marker)))
    cells = [
        {"cell_type": "code", "id": f"cell-{number}", "metadata": {}, "outputs": [],
         "execution_count": None, "source": source}
        for number, source in enumerate(CELLS)
    ]  # fmt: skip
    kernel = {"display_name": "Python 3", "language": "python", "name": "mikas"}
    notebook = {"cells": cells, "metadata": {"kernelspec": kernel}, "nbformat": 4}
    (folder / "drive.ipynb").write_text(json.dumps({**notebook, "nbformat_minor": 5}))


@contextmanager
def _lab(jupyter: Path, folder: Path, language: str) -> Iterator[None]:
    """Start JupyterLab with settings of its own, and a kernel of this environment."""
    kernel = folder / "data" / "kernels" / "mikas"
    kernel.mkdir(parents=True)
    argv = [sys.executable, "-m", "ipykernel_launcher", "-f", "{connection_file}"]
    form = {"argv": argv, "display_name": "Python 3", "language": "python"}
    (kernel / "kernel.json").write_text(json.dumps(form))
    settings = folder / "settings" / "@jupyterlab" / "apputils-extension"
    settings.mkdir(parents=True)
    no_news = {"fetchNews": "false", "checkForUpdates": False}
    (settings / "notification.jupyterlab-settings").write_text(json.dumps(no_news))
    environment = os.environ | {
        "MIKAS_LANG": language,
        "JUPYTER_DATA_DIR": str(folder / "data"),
        "JUPYTER_CONFIG_DIR": str(folder / "config"),
        "JUPYTERLAB_SETTINGS_DIR": str(folder / "settings"),
        "JUPYTERLAB_WORKSPACES_DIR": str(folder / "workspaces"),
    }
    options = [
        "--no-browser", "--allow-root", f"--port={ADDRESS.rsplit(':', 1)[1]}",
        "--IdentityProvider.token=", f"--ServerApp.root_dir={folder}",
    ]  # fmt: skip
    with subprocess.Popen(
        [jupyter, "lab", *options], env=environment, stderr=subprocess.DEVNULL
    ) as server:
        try:
            _wait_for_server()
            yield
        finally:
            server.terminate()


def _wait_for_server() -> None:
    for _ in range(60):
        try:
            urlopen(f"{ADDRESS}/api").close()
        except URLError:
            sleep(1)
        else:
            return
    raise TimeoutError("JupyterLab did not start")


def _take(target: Path) -> None:
    with sync_playwright() as playwright:
        flags = ["--headless", "--no-sandbox", "--disable-gpu"]
        browser = playwright.chromium.launch(executable_path="/usr/bin/chromium", args=flags)
        page = browser.new_page(viewport={"width": WIDTH, "height": HEIGHT + 40})
        page.goto(f"{ADDRESS}/lab/tree/drive.ipynb?reset")
        _run_cells(page)
        page.screenshot(path=target)
        browser.close()
    picture = Image.open(target).convert("RGB").crop((0, 0, WIDTH - RIGHT, HEIGHT))
    picture.quantize(256).save(target, optimize=True)


def _run_cells(page: Page) -> None:
    page.wait_for_selector(".jp-Notebook .jp-CodeCell", timeout=90_000)
    sleep(4)  # the kernel and the last of the frame
    page.keyboard.press("Control+b")  # without the list of files
    page.click(".jp-Notebook .jp-CodeCell .cm-content >> nth=0")
    for _ in CELLS:
        page.keyboard.press("Shift+Enter")
        sleep(1.5)  # the next cell is there to be chosen
    page.wait_for_selector(".jp-OutputArea-output img", timeout=90_000)
    sleep(3)  # the figure has its final size
    page.evaluate("document.querySelector('.jp-WindowedPanel-outer').scrollTop = 0")
    sleep(1)


if __name__ == "__main__":
    main()
