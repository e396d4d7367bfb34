"""`mikas ports`: the serial adapters of this computer, with chip and quirks."""

from __future__ import annotations

from mikas.cli.click_extensions import command
from mikas.cli.context import CommandContext
from mikas.cli.language import localized, tr
from mikas.i18n import Text
from mikas.link import find_ports


@command(
    "ports",
    Text(
        "Lists the serial adapters of this computer, the most likely first.",
        "Показывает последовательные адаптеры этого компьютера; самый вероятный — первый.",
    ),
    examples=("mikas ports", "mikas ports --json"),
)
def ports(context: CommandContext) -> None:
    found = find_ports()
    if context.output.json:
        listed = [
            {
                "url": port.url,
                "description": port.description,
                "chip": port.chip,
                "likely": port.likely,
                "quirks": [{"en": quirk.en, "ru": quirk.ru} for quirk in port.quirks],
            }
            for port in found
        ]
        context.output.data({"ports": listed})
        return
    if not found:
        context.output.note(
            tr(
                "No serial adapter found. Plug in a KKL cable and try again; `mikas demo` needs "
                "none.",
                "Последовательные адаптеры не найдены. Подключите кабель KKL и повторите; без "
                "него работает `mikas demo`.",
            )
        )
        return
    context.output.table(
        [tr("port", "порт"), tr("chip", "микросхема"), tr("description", "описание")],
        [[port.url, port.chip or "–", port.description] for port in found],
    )
    for port in found:
        for quirk in port.quirks if port.likely else ():
            context.output.note(f"{port.url}: {localized(quirk)}")
