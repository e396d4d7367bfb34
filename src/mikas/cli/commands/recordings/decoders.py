"""`mikas wireshark`, `mikas sigrok`: the decoders for other programs. They need no port.

Wireshark shows recordings; sigrok and PulseView see the bits.
"""

from __future__ import annotations

import shutil
import sys
from collections.abc import Callable
from pathlib import Path

import click

from mikas.cli.click_extensions import command, flag, option
from mikas.cli.completion.values import folders
from mikas.cli.context import CommandContext
from mikas.cli.language import current_language
from mikas.cli.render import terminal
from mikas.errors import usage_error
from mikas.files import absolute
from mikas.i18n import Text

_FILTER = "mikas.param.TWAT > 90"
_EXAMPLE = "sigrok-cli -i line.sr -P uart:baudrate=9600:rx=D0,mikas -A mikas"


@command(
    en="Prints a plugin for Wireshark and tshark, in Lua: recordings (.pcapng) then open there "
    "frame by frame, with every parameter as a field to filter by. With --install it is put "
    "where Wireshark looks for it. It knows your own catalog, too: run the command again after "
    "a change.",
    ru="Печатает плагин на Lua для Wireshark и tshark: записи (.pcapng) открываются там по "
    "кадрам, каждый параметр — поле для фильтра. С ключом --install плагин ставится туда, где "
    "его ищет Wireshark. Он знает и ваш каталог: после изменения выполните команду ещё раз.",
    examples=(
        "mikas wireshark --install",
        "mikas wireshark > mikas.lua",
        "mikas --catalog mine.toml wireshark --install",
    ),
)
@flag(
    "--install",
    en="put it into your folder of Wireshark plugins",
    ru="поставить в вашу папку плагинов Wireshark",
)
def wireshark(context: CommandContext, *, install: bool) -> None:
    import mikas
    from mikas.dissectors.installing import is_running, plugin_file
    from mikas.dissectors.wireshark.generator import MARK, in_ascii, source

    options = context.options
    text = source(
        options.catalog, current_language(), options.interpretation, f"{mikas.__version__}"
    )
    if not install:
        hint = Text(
            "To put it where Wireshark looks for it: mikas wireshark --install",
            "Чтобы поставить его в Wireshark: mikas wireshark --install",
        )
        _print(context, text, in_ascii, hint)
        return
    written = _install(context, plugin_file(), text, MARK)
    if _is_absent("wireshark", "tshark"):
        context.say(
            "Wireshark was not found on this computer: install it (Debian: sudo apt install "
            "wireshark).",
            "Wireshark на этом компьютере не найден: установите его (Debian: sudo apt install "
            "wireshark).",
        )
    elif written and is_running("wireshark"):
        context.say(
            "Wireshark is running: press Ctrl+Shift+L in it (Analyze, Reload Lua Plugins), or "
            "start it again.",
            "Wireshark запущен: нажмите в нём Ctrl+Shift+L (перезагрузка плагинов Lua) или "
            "запустите его заново.",
        )
    context.say(
        f"Now open a recording: wireshark drive.pcapng. A filter to try: {_FILTER}",
        f"Теперь откройте запись: wireshark drive.pcapng. Фильтр для пробы: {_FILTER}",
    )


@command(
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
@flag(
    "--install",
    en="install it for you; replaces only its own file",
    ru="поставить для вас; заменяет только свой файл",
)
@option(
    "-o",
    "--out",
    "folder",
    type=click.Path(path_type=Path),
    metavar="FOLDER",
    shell_complete=folders,
    en="write it into another folder of decoders",
    ru="записать в другую папку декодеров",
)
def sigrok(context: CommandContext, *, install: bool, folder: Path | None) -> None:
    from mikas.dissectors.installing import decoder_file, is_running
    from mikas.dissectors.sigrok.generator import MARK, source

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
    if not install and folder is None:
        hint = Text(
            "To put it where sigrok and PulseView look for it: mikas sigrok --install",
            "Чтобы поставить его в sigrok и PulseView: mikas sigrok --install",
        )
        _print(context, text, _in_ascii, hint)
        return
    written = _install(context, decoder_file(folder), text, MARK)
    if folder is not None:
        context.say(
            f"sigrok finds it where SIGROKDECODE_DIR={absolute(folder)} is set.",
            f"sigrok найдёт его, если задано SIGROKDECODE_DIR={absolute(folder)}.",
        )
    if _is_absent("pulseview", "sigrok-cli"):
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


def _print(context: CommandContext, text: str, in_ascii: Callable[[str], str], hint: Text) -> None:
    """Print the decoder `text`; on a terminal `hint` says how it is installed."""
    if context.output.json:
        context.output.data({"path": None, "text": text})
        return
    # Another encoding: a redirected stdout of Windows.
    terminal.write_out(text if terminal.is_utf8_out() else in_ascii(text))
    if sys.stdout.isatty():
        context.say(*hint)


def _in_ascii(text: str) -> str:
    return text.encode("ascii", "backslashreplace").decode()  # Python reads the escapes


def _install(context: CommandContext, file: Path, text: str, mark: str) -> bool:
    """Write the decoder to `file`; return whether it differed."""
    from mikas.dissectors.installing import install

    written = install(file, text, mark)
    if context.output.json:
        context.output.data({"path": str(file), "written": written})
    if written:
        context.say(f"Written: {file}.", f"Записано: {file}.")
    else:
        context.say(f"Installed already: {file}.", f"Уже стоит: {file}.")
    return written


def _is_absent(*programs: str) -> bool:
    """Return whether none of `programs` is installed; only Linux has them all in its PATH."""
    return sys.platform == "linux" and not any(map(shutil.which, programs))
