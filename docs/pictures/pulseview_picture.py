"""Take sigrok.png, the picture in docs/how-to/sigrok.md, in both languages: PulseView itself.

Run from the repository's root, with pulseview, Xvfb, xdotool and ImageMagick (Debian's packages):
PYTHONPATH=tests python docs/pictures/pulseview_picture.py
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

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
        screen = ["Xvfb", DISPLAY, "-screen", "0", f"{WIDTH}x{HEIGHT}x24"]
        xvfb = subprocess.Popen(screen, stderr=subprocess.DEVNULL)
        try:
            time.sleep(1)
            for language in ("en", "ru"):
                text = source(shipped(), language=language)
                install(decoder_file(folder / "decoders"), text, MARK)
                take(folder, Path(__file__).parent / language / "sigrok.png")
        finally:
            xvfb.terminate()


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
    environment = os.environ | {
        "DISPLAY": DISPLAY, "HOME": str(folder), "SIGROKDECODE_DIR": str(folder / "decoders"),
    }  # fmt: skip
    environment.pop("XDG_CONFIG_HOME", None)
    command = ["pulseview", "-c", "-D", "-i", "line.sr", "-s", "line.pvs"]
    with (folder / "log").open("w") as log:
        pulseview = subprocess.Popen(command, cwd=folder, env=environment, stdout=log, stderr=log)
    try:
        time.sleep(5)
        window = ["xdotool", "search", "--name", "line.sr - PulseView"]
        found = subprocess.run(window, env=environment, capture_output=True, check=True).stdout
        number = found.decode().split()[-1]
        for action in (["windowmove", number, "0", "0"], ["windowsize", number, "1500", "300"]):
            subprocess.run(["xdotool", *action], env=environment, check=True)
        time.sleep(3)
        shot = ["import", "-window", "root", "+dither", "-colors", "96", f"png8:{out}"]
        subprocess.run(shot, env=environment, check=True)
        print(out, file=sys.stderr)
    finally:
        pulseview.terminate()
        pulseview.wait()


if __name__ == "__main__":
    main()
