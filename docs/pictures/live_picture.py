"""Draw live.svg, the picture in docs/reference/cli.md, in both languages: a car that warms up.

Run from the repository's root: python docs/pictures/live_picture.py
"""

from __future__ import annotations

import io
import re
from pathlib import Path

from rich.console import Console

from mikas.cli.context import CommandContext
from mikas.cli.language import set_language
from mikas.cli.options.sampling import SamplingOptions
from mikas.cli.render import table_layout
from mikas.cli.render.live_table import LiveTable
from mikas.cli.render.output import Output
from mikas.cli.sampling_run import sampling_session

SECONDS = 75
WIDTH = 118


def main() -> None:
    """Write the picture into the folder of each language."""
    for language in ("en", "ru"):
        set_language(language)
        draw(Path(__file__).parent / language / "live.svg")


def draw(out: Path) -> None:
    """Write the picture in the current language."""
    console = Console(record=True, width=WIDTH, height=40, file=io.StringIO(), force_terminal=True)
    run = CommandContext(port="sim:?scenario=cold-start&seed=1&clock=simulated")
    asked = SamplingOptions(duration=SECONDS)
    with run.open_ahead() as ahead, sampling_session(run, asked, ahead) as made:
        table = LiveTable(made, Output(), console)
        for event in made.events():
            table.add_event(event)
        console.print(table.drawing(table_layout.UNLIMITED))
    picture = console.export_svg(title="mikas watch")
    # The picture must not fetch a font: any monospaced one of the system will do.
    picture = re.sub(r"@font-face \{.*?\}\s*", "", picture, flags=re.DOTALL)
    picture = picture.replace("Fira Code", "DejaVu Sans Mono, Menlo, Consolas")
    out.write_text(picture, "utf-8")


main()
