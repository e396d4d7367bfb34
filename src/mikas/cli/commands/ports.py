"""`mikas ports`: the serial adapters of this computer; `--install-rules`: udev's rules for them."""

from __future__ import annotations

import os
import shlex
import sys
from pathlib import Path

from mikas.cli.advice import ADVICE
from mikas.cli.click_extensions import YES, command, flag
from mikas.cli.context import CommandContext, require_consent
from mikas.cli.language import localized, tr
from mikas.errors import UsageError, reason_of, usage_error
from mikas.i18n import Text
from mikas.json_values import picked
from mikas.link import find_ports, udev_rules
from mikas.link.holders import adapter_without_port
from mikas.saving import save

_READABLE = 0o644  # by udev and everybody


@command(
    en="Lists the serial adapters of this computer, the most likely first. With --install-rules "
    "(Linux): prints the udev rules for adapters and installs them, after a question. They "
    "keep ModemManager and brltty off, let you open the port, and set an FT232 to 1 ms.",
    ru="Показывает последовательные адаптеры этого компьютера; самый вероятный — первый. С ключом "
    "--install-rules (Linux): печатает правила udev для адаптеров и после вопроса ставит их: "
    "ModemManager и brltty не трогают адаптер, порт может открыть тот, кто за компьютером, "
    "FT232 отдаёт байты через 1 мс.",
    examples=("mikas ports", "mikas ports --json", "mikas ports --install-rules"),
)
@flag(
    "--install-rules",
    en="print and install udev rules for adapters (Linux)",
    ru="напечатать и поставить правила udev для адаптеров (Linux)",
)
@YES
def ports(context: CommandContext, *, install_rules: bool, yes: bool) -> None:
    if install_rules:
        _install(context, udev_rules.FILE, udev_rules.rules(), yes=yes)
        return
    if yes:
        raise usage_error(
            "--yes goes with --install-rules", "Ключ --yes нужен только с --install-rules"
        )
    _list(context)


def _list(context: CommandContext) -> None:
    found = find_ports()
    if context.output.json:
        names = ("url", "description", "chip", "likely", "serial_number", "quirks")
        context.output.data({"ports": [picked(port, *names) for port in found]})
        return
    without_port = adapter_without_port()
    if found:
        context.output.listing(
            found,
            {
                tr("port", "порт"): lambda port: port.url,
                tr("chip", "микросхема"): lambda port: port.chip or "–",
                tr("serial number", "серийный номер"): lambda port: port.serial_number or "–",
                tr("description", "описание"): lambda port: port.description,
            },
        )
    elif without_port is None:
        context.say(
            "No serial adapter found. Plug in a KKL cable and try again; `mikas demo` needs none.",
            "Последовательные адаптеры не найдены. Подключите кабель KKL и повторите; без "
            "него работает `mikas demo`.",
        )
    for port in found:
        for quirk in port.quirks if port.likely else ():
            context.output.print_note(f"{port.url}: {localized(quirk)}")
    if without_port is not None:
        context.output.print_note(localized(ADVICE.text(without_port)))


def _install(context: CommandContext, file: Path, rules: str, *, yes: bool) -> None:
    """Print `rules`, and write them to `file` with consent."""
    if sys.platform != "linux":
        raise usage_error(
            "Only Linux has udev rules; this system needs none",
            "Правила udev нужны только в Linux, здесь без них можно обойтись",
        )
    output = context.output
    if not output.json:
        output.line(rules.rstrip("\n"))
    used = next((each for each in (file, udev_rules.PACKAGED) if each.exists()), file)
    written = _present(used) != rules
    if written:
        _require_root(file)
        what = Text(f"write these rules to {file}", f"записать эти правила в {file}")
        output.print_note(
            tr(f"This writes the rules to {file}.", f"Правила будут записаны в {file}.")
        )
        require_consent(what, yes=yes)
        _write(file, rules)
    else:
        file = used
    if output.json:
        output.data({"rules": rules, "path": str(file), "written": written})
    if written:
        context.say(
            f"Written: {file}. Unplug the adapter and plug it in again.",
            f"Записано: {file}. Отключите адаптер и подключите снова.",
        )
    else:
        context.say(
            f"These rules are installed already: {file}.", f"Эти правила уже стоят: {file}."
        )


def _present(file: Path) -> str | None:
    try:
        return file.read_text("utf-8")
    except (OSError, UnicodeDecodeError):
        return None


def _require_root(file: Path) -> None:
    """Raise `UsageError` with the command for root if this user may not write `file`."""
    folder = next(each for each in file.parents if each.exists())
    if os.access(folder, os.W_OK) or os.geteuid() == 0:
        return
    again = f"sudo {_this_program()} ports --install-rules"
    raise UsageError(
        problem=Text(
            f"Nothing was written: only root may write {file}",
            f"Ничего не записано: писать в {file} может только root",
        ),
        advice=Text(
            f"Run: {again}. Or save the printed text there yourself.",
            f"Выполните: {again}. Или сами сохраните туда напечатанный текст.",
        ),
    )


def _this_program() -> str:
    """Return this program as root's shell finds it, which has another PATH."""
    started = Path(sys.argv[0])
    if started.name == "__main__.py" or not started.exists():
        return f"{shlex.quote(sys.executable)} -m mikas"
    return shlex.quote(str(started.resolve()))


def _write(file: Path, rules: str) -> None:
    """Write the whole file at once, as udev may read it at any moment."""
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        save(file, rules)
        file.chmod(_READABLE)
    except OSError as error:
        why = reason_of(error)
        failed = usage_error(
            f"The rules can't be written to {file}: {why.en}",
            f"Не удаётся записать правила в {file}: {why.ru}",
        )
        raise failed.caused_by(error, file) from error
