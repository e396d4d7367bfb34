"""Take sigrok.png, the picture in docs/how-to/sigrok.md, in both languages: PulseView itself.

Run from the repository's root, with pulseview, Xvfb, xdotool and ImageMagick (Debian's packages):
PYTHONPATH=tests python docs/pictures/pulseview_picture.py
"""

from __future__ import annotations

import tempfile
import time
from pathlib import Path

from virtual_screen import Window, screen

from dissectors.levels_rig import Tap, signals, write_session
from mikas.catalog import shipped
from mikas.client.connecting import ConnectionOptions
from mikas.dissectors.installing import install
from mikas.dissectors.sigrok import MARK, decoder_file, source
from mikas.link import open_link

DISPLAY = ":77"
WIDTH, HEIGHT = 1500, 300
SCALE = 1.24e-5  # s a pixel
MARGIN = 0.0031  # s in front of the first frame, for the names of the rows
SETUP = rf"""[General]
decode_signals=1
generated_signals=0
meta_objs=0
views=1

[decode_signal0]
name=UART
enabled=true
decoders=2
channels=2
channel0\name=RX
channel0\initial_pin_state=1
channel0\assigned_signal_name=K-Line
channel1\name=TX
channel1\initial_pin_state=1
decoder0\id=uart
decoder0\visible=true
decoder0\options=1
decoder0\option0\name=baudrate
decoder0\option0\value=@ByteArray(\x80%\0\0\0\0\0\0)
decoder0\option0\type=@ByteArray(x)
decoder1\id=mikas
decoder1\visible=true
decoder1\options=0

[view0]
scale={SCALE}
"""


def main() -> None:
    """Take the picture in each language."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        recorded(folder / "line.sr")
        (folder / "line.pvs").write_text(SETUP, "utf-8")
        with screen(DISPLAY, WIDTH, HEIGHT):
            for language in ("en", "ru"):
                text = source(shipped(), language=language)
                install(decoder_file(folder / "decoders"), text, MARK)
                take(folder, Path(__file__).parent / language / "sigrok.png")


def recorded(file: Path) -> None:
    """Write what a logic analyser sees of a reading of three parameters."""
    link = open_link("sim:?clock=simulated&seed=3&scenario=city")
    tap = Tap(link.bus)
    link.gather(37.0)
    ecu = ConnectionOptions().create_ecu(link)
    ecu.tester.connect()
    link.gather(link.now() + 0.01)
    begin = link.now()
    for _ in range(3):
        ecu.read("TWAT", "FREQ", "INJ")
        link.gather(link.now() + 0.003)
    for noted in (tap.sent, tap.received):
        noted[:] = [byte for byte in noted if byte[0] >= begin]
    write_session(file, signals(tap, 1_000_000, margin=MARGIN))


def take(folder: Path, out: Path) -> None:
    """Start PulseView with the recording and the decoders, and take its window."""
    command = ["pulseview", "-c", "-D", "-i", "line.sr", "-s", "line.pvs"]
    decoders = str(folder / "decoders")
    window = Window(command, DISPLAY, folder, SIGROKDECODE_DIR=decoders)
    with window.opened(5):
        number = window.act("search", "--name", "line.sr - PulseView").split()[-1]
        window.act("windowmove", number, "0", "0")
        window.act("windowsize", number, str(WIDTH), str(HEIGHT))
        time.sleep(3)
        window.picture(out)


if __name__ == "__main__":
    main()
