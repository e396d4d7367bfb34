"""Take wireshark.png, the picture in docs/how-to/wireshark.md, in both languages: Wireshark itself.

Run from the repository's root, with wireshark, Xvfb, xdotool and ImageMagick (Debian's packages):
python docs/pictures/wireshark_picture.py
"""

from __future__ import annotations

import tempfile
import time
from pathlib import Path

from virtual_screen import Window, screen

import mikas
from mikas.catalog import shipped
from mikas.client.connecting import ConnectionOptions
from mikas.dissectors.installing import install
from mikas.dissectors.wireshark import MARK, source
from mikas.link import CaptureTee, open_link
from mikas.recording import CaptureWriter, Coalescer

DISPLAY = ":78"
WIDTH, HEIGHT = 1240, 700
FILTER = "mikas.param.TWAT > 84"
NAMES = ("TWAT", "FREQ", "JAIR", "UOZ", "INJ", "THR", "RXX", "DET")
COLUMNS = ("No.", "%m"), ("Time", "%t"), ("Source", "%s"), *(
    (name, f"%Cus:mikas.param.{name}:0:R") for name in NAMES[:2]
), ("Info", "%i")  # fmt: skip
RECENT = f"""\
privs.warn_if_elevated: FALSE
gui.geometry_main_x: 0
gui.geometry_main_y: 0
gui.geometry_main_width: {WIDTH}
gui.geometry_main_height: {HEIGHT}
"""
# Pixels: a packet, the line of the protocol, that of a value; where panes meet, before and after.
PACKET, PROTOCOL, VALUE = (300, 188), (100, 279), (200, 398)
BELOW, BESIDE = ((900, 384), (900, 250)), ((620, 520), (880, 520))


def main() -> None:
    """Take the picture in each language."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        recorded(folder / "drive.pcapng")
        settings = folder / ".config/wireshark"
        settings.mkdir(parents=True)
        columns = ", ".join(f'"{title}", "{form}"' for title, form in COLUMNS)
        settings.joinpath("preferences").write_text(f"gui.column.format: {columns}\n", "utf-8")
        settings.joinpath("recent_common").write_text(RECENT, "utf-8")
        with screen(DISPLAY, WIDTH, HEIGHT):
            for language in ("en", "ru"):
                text = source(shipped(), language, "corrected", f"{mikas.__version__}")
                install(folder / ".local/lib/wireshark/plugins/mikas.lua", text, MARK)
                settings.joinpath("language").write_text(f"language: {language}\n", "utf-8")
                take(folder, Path(__file__).parent / language / "wireshark.png")


def recorded(file: Path) -> None:
    """Write the recording of a warm car in town."""
    link = open_link("sim:?clock=simulated&seed=3&scenario=city")
    with CaptureWriter(file, url="/dev/ttyUSB0") as writer:
        joined = Coalescer(writer)
        ecu = ConnectionOptions().create_ecu(CaptureTee(link, joined))
        ecu.tester.connect()
        for _ in range(1500):
            ecu.read(*NAMES)
        joined.flush()


def take(folder: Path, out: Path) -> None:
    """Start Wireshark with the recording and the filter, open the tree, and take its window."""
    command = ["wireshark", "-r", "drive.pcapng", "-Y", FILTER]
    window = Window(command, DISPLAY, folder, TZ="UTC")
    with window.opened(10):
        for action in (
            dragged(*BELOW),
            dragged(*BESIDE),
            clicked(*PACKET),
            [*clicked(*PROTOCOL), "key", "shift+Right"],
            clicked(*VALUE),
        ):
            window.act(*action)
            time.sleep(1)
        window.picture(out)


def clicked(x: int, y: int) -> list[str]:
    """Return the words by which xdotool clicks there."""
    return ["mousemove", str(x), str(y), "click", "1"]


def dragged(begin: tuple[int, int], end: tuple[int, int]) -> list[str]:
    """Return the words by which xdotool drags something."""
    at, to = (["mousemove", *map(str, place)] for place in (begin, end))
    return [*at, "mousedown", "1", *to, "sleep", "0.5", "mouseup", "1"]


if __name__ == "__main__":
    main()
