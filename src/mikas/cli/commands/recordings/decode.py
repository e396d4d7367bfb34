"""`mikas decode`: a capture frame by frame, as text or JSON lines. Needs no port."""

from __future__ import annotations

from pathlib import Path

import click

from mikas.cli.click_extensions import command
from mikas.cli.context import CommandContext
from mikas.cli.language import current_language
from mikas.cli.parameter_types import File
from mikas.i18n import Text
from mikas.recording import CaptureReader
from mikas.recording.inspect.describe import Describer
from mikas.recording.inspect.frames import decode as decode_frames
from mikas.recording.inspect.frames import to_json, to_text


@command(
    "decode",
    Text(
        "Shows a capture (.pcapng) frame by frame: time, direction, bytes, meaning; damage with "
        "its reason and offset. Of a truncated file the readable part is shown.",
        "Показывает запись (.pcapng) по кадрам: время, направление, байты, значение; повреждения "
        "с причиной и смещением. Обрезанный файл показывается до места обрыва.",
    ),
    examples=("mikas decode drive.pcapng", "mikas decode drive.pcapng --json"),
)
@click.argument("file", metavar="FILE", type=File(there=True))
def decode(context: CommandContext, file: Path) -> None:
    describe = Describer(context.catalog(), context.interpretation)
    zero: float | None = None
    for item in decode_frames(CaptureReader(file), describe):
        if context.output.json:
            line = to_json(item)
            line.pop("schema", None)
            context.output.data(line)
            continue
        if zero is None:
            zero = getattr(item, "begin", None)
        context.output.line(to_text(item, current_language(), zero=zero or 0.0))
