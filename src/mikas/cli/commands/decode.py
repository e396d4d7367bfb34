"""`mikas decode`: a capture frame by frame, as text or JSON lines. Needs no port."""

from __future__ import annotations

from pathlib import Path

import click

from mikas.cli.arguments import File
from mikas.cli.grammar import command
from mikas.cli.run import Run
from mikas.cli.words import language
from mikas.i18n import Text
from mikas.recording import CaptureReader
from mikas.recording.inspect.describe import Describer
from mikas.recording.inspect.frames import decode as decode_frames
from mikas.recording.inspect.frames import to_json, to_text


@command(
    "decode",
    Text(
        "Shows a capture (.pcapng) frame by frame: time, direction, bytes, meaning; damage with "
        "its reason and place. What is left of a cut file is shown, the rest is reported.",
        "Показывает запись линии (.pcapng) по кадрам: время, направление, байты, значение; "
        "повреждения с причиной и местом. От обрезанного файла показывается всё, что осталось.",
    ),
    examples=("mikas decode drive.pcapng", "mikas decode drive.pcapng --json"),
)
@click.argument("file", metavar="FILE", type=File(there=True))
def decode(run: Run, file: Path) -> None:
    describe = Describer(run.catalog(), run.interpretation)
    zero: float | None = None
    for item in decode_frames(CaptureReader(file), describe):
        if run.output.json:
            line = to_json(item)
            line.pop("schema", None)
            run.output.data(line)
            continue
        if zero is None:
            zero = getattr(item, "begin", None)
        run.output.line(to_text(item, language(), zero=zero or 0.0))
