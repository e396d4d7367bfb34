"""What `dash` and `demo` say at the terminal beside their address."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from mikas.cli.advice import ADVICE
from mikas.cli.context import CommandContext
from mikas.cli.language import localized, tr
from mikas.errors import UsageError

if TYPE_CHECKING:
    from mikas.dashboard.dashboard import Hub
    from mikas.dashboard.settings import Settings


def tell_kept(context: CommandContext, hub: Hub) -> None:
    """What became of the recording that was being made."""
    kept = hub.recording.kept
    if kept is None:
        return
    if kept.failure is None:
        context.output.note(
            tr(
                f"The recording was ended and is kept: {kept.path}",
                f"Запись закончена и сохранена: {kept.path}",
            )
        )
    else:
        context.output.note(localized(ADVICE.text(kept.failure)))


def tell_if_nothing_can_be_kept(context: CommandContext, settings: Settings) -> None:
    """Of the folder that nobody named; one that was named is refused."""
    from mikas.dashboard.settings import check_folder

    try:
        check_folder(settings.recordings)
    except UsageError as error:
        context.output.note(localized(ADVICE.text(error)))


def tell_if_missing(context: CommandContext, url: str) -> None:
    """Says here too what the page shows: perhaps nobody looks at it yet."""
    from mikas.link import find_ports
    from mikas.link.ports import listed
    from mikas.link.urls import parse

    named = parse(url)
    if named.scheme != "serial" or Path(named.address).exists():
        return
    ports = find_ports()
    if named.address in (port.url for port in ports):
        return  # on Windows a port is no path
    found = listed(ports)
    context.output.note(
        tr(
            f"There is no port {named.address} yet; the page connects as soon as it is there. "
            f"Found: {found.en}.",
            f"Порта {named.address} пока нет; страница соединится, как только он появится. "
            f"Найдены: {found.ru}.",
        )
    )
