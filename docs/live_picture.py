"""Draws docs/live.svg, the README's picture: the real live table over a virtual car warming up.

Run from the repository's root: python docs/live_picture.py
"""

from __future__ import annotations

import io
import re
from pathlib import Path

from rich.console import Console

import mikas
from mikas.cli import layout
from mikas.cli.live import LiveTable

SECONDS = 75
WIDTH = 118


def main() -> None:
    """Writes the picture beside this file."""
    console = Console(record=True, width=WIDTH, height=40, file=io.StringIO(), force_terminal=True)
    with mikas.connect("sim:?scenario=cold-start&seed=1&clock=simulated") as ecu:
        table = LiveTable(ecu, ecu.catalog.parameters, console)
        for sample in ecu.watch():
            table.show(sample)
            if sample.time > SECONDS:
                break
        console.print(table.drawing(layout.UNLIMITED))
    picture = console.export_svg(title="mikas watch")
    # The picture must not fetch a font from elsewhere: whatever monospaced one there is will do.
    picture = re.sub(r"@font-face \{.*?\}\s*", "", picture, flags=re.DOTALL)
    picture = picture.replace("Fira Code", "DejaVu Sans Mono, Menlo, Consolas")
    Path(__file__).with_name("live.svg").write_text(picture, "utf-8")


main()
