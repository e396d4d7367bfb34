"""`mikas sigrok`: the decoder for sigrok and PulseView, which see the bits. It needs no port."""

from __future__ import annotations

import shutil
import sys
from pathlib import Path

import click

from mikas.cli.click_extensions import command, option
from mikas.cli.context import CommandContext
from mikas.cli.language import current_language
from mikas.cli.render import terminal
from mikas.errors import usage_error

_EXAMPLE = "sigrok-cli -i line.sr -P uart:baudrate=9600:rx=D0,mikas -A mikas"


@command(
    "sigrok",
    en="Prints the protocol decoder for sigrok and PulseView: a logic analyser's recording "
    "of the line as frames, requests, responses and values. It has your own catalog, and the "
    "language and the interpretation of this command by default. With --install it goes where "
    "these programs look for it: run the command again after a change of your catalog.",
    ru="Печатает декодер протокола для sigrok и PulseView: запись линии логическим "
    "анализатором как кадры, запросы, ответы и значения. В нём и ваш каталог; язык и "
    "толкование по умолчанию — как у этой команды. С ключом --install ставит его туда, где его "
    "ищут эти программы: после изменения каталога выполните команду ещё раз.",
    examples=(
        "mikas sigrok --install",
        "mikas sigrok --lang ru --install",
        "mikas sigrok -o decoders",
    ),
)
@option(
    "--install",
    is_flag=True,
    en="install it for you; replaces only its own file",
    ru="поставить для вас; заменяет только свой файл",
)
@option(
    "-o",
    "--out",
    "folder",
    type=click.Path(path_type=Path),
    metavar="FOLDER",
    en="write it into another folder of decoders",
    ru="записать в другую папку декодеров",
)
def sigrok(context: CommandContext, *, install: bool, folder: Path | None) -> None:
    from mikas.dissectors.sigrok import decoder_file, source

    if install and folder is not None:
        raise usage_error(
            "--install and -o exclude each other: both say where the decoder goes",
            "Ключи --install и -o исключают друг друга: оба говорят, куда поставить декодер",
        )
    options = context.options
    text = source(
        options.catalog,
        language=current_language(),
        interpretation=options.interpretation,
        checksum="raw" if options.raw_checksum else "stuffed",
    )
    if install or folder is not None:
        _write(context, decoder_file(folder), folder, text)
    elif context.output.json:
        context.output.data({"path": None, "text": text})
    else:
        if not terminal.is_utf8_out():  # a redirected one of Windows; Python reads the escapes
            text = text.encode("ascii", "backslashreplace").decode()
        terminal.write_out(text)
        if sys.stdout.isatty():
            context.say(
                "To put it where sigrok and PulseView look for it: mikas sigrok --install",
                "Чтобы поставить его в sigrok и PulseView: mikas sigrok --install",
            )


def _write(context: CommandContext, file: Path, folder: Path | None, text: str) -> None:
    from mikas.dissectors.installing import install, is_running
    from mikas.dissectors.sigrok import MARK

    written = install(file, text, MARK)
    if context.output.json:
        context.output.data({"path": str(file), "written": written})
    if written:
        context.say(f"Written: {file}.", f"Записано: {file}.")
    else:
        context.say(f"Installed already: {file}.", f"Уже стоит: {file}.")
    if folder is not None:
        context.say(
            f"sigrok finds it where SIGROKDECODE_DIR={folder.absolute()} is set.",
            f"sigrok найдёт его, если задано SIGROKDECODE_DIR={folder.absolute()}.",
        )
    if not (shutil.which("pulseview") or shutil.which("sigrok-cli")) and sys.platform == "linux":
        context.say(
            "PulseView was not found on this computer: install it (Debian: sudo apt install "
            "pulseview sigrok-cli).",
            "PulseView на этом компьютере не найден: установите его (Debian: sudo apt install "
            "pulseview sigrok-cli).",
        )
    elif written and is_running("pulseview"):
        context.say(
            "PulseView is running: start it again.", "PulseView запущен: запустите его заново."
        )
    context.say(
        "In PulseView add the decoder UART (baud rate 9600, RX: the K-Line's channel), then stack "
        f"Mikas on it. In a terminal: {_EXAMPLE}",
        "В PulseView добавьте декодер UART (baud rate 9600, RX — канал K-Line), затем поверх него "
        f"Mikas. В терминале: {_EXAMPLE}",
    )
