"""`mikas wireshark`: the dissector that shows recordings in Wireshark. It needs no port."""

from __future__ import annotations

import shutil
import sys

from mikas.cli.click_extensions import command, option
from mikas.cli.context import CommandContext
from mikas.cli.language import current_language
from mikas.cli.render import terminal

_FILTER = "mikas.param.TWAT > 90"


@command(
    "wireshark",
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
@option(
    "--install",
    is_flag=True,
    en="put it into your folder of Wireshark plugins",
    ru="поставить в вашу папку плагинов Wireshark",
)
def wireshark(context: CommandContext, *, install: bool) -> None:
    import mikas
    from mikas.dissectors.wireshark import in_ascii, source

    options = context.options
    text = source(
        options.catalog, current_language(), options.interpretation, f"{mikas.__version__}"
    )
    if install:
        _install(context, text)
    elif context.output.json:
        context.output.data({"path": None, "text": text})
    else:
        # Another encoding: a redirected stdout of Windows.
        terminal.write_out(text if terminal.is_utf8_out() else in_ascii(text))
        if sys.stdout.isatty():
            context.say(
                "To put it where Wireshark looks for it: mikas wireshark --install",
                "Чтобы поставить его в Wireshark: mikas wireshark --install",
            )


def _install(context: CommandContext, text: str) -> None:
    from mikas.dissectors.installing import install, is_running
    from mikas.dissectors.wireshark import MARK, plugin_file

    file = plugin_file()
    written = install(file, text, MARK)
    if context.output.json:
        context.output.data({"path": str(file), "written": written})
    if written:
        context.say(f"Written: {file}.", f"Записано: {file}.")
    else:
        context.say(f"Installed already: {file}.", f"Уже стоит: {file}.")
    if sys.platform == "linux" and not (shutil.which("wireshark") or shutil.which("tshark")):
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
