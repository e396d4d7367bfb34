"""Completion in the shell: commands, options, and names of channels as people use them.

A shell asks by `_MIKAS_COMPLETE`, as click's documentation has it:
`eval "$(_MIKAS_COMPLETE=bash_source mikas)"` (zsh, fish likewise).
"""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

import click
from click.shell_completion import CompletionItem, shell_complete

if TYPE_CHECKING:
    from mikas.catalog import Catalog

VARIABLE = "_MIKAS_COMPLETE"


def is_asked() -> bool:
    """Whether a shell asks for completion."""
    return VARIABLE in os.environ


def answer(cli: click.Command) -> int:
    """Print what the shell asks for; return the exit status. An error completes nothing."""
    try:
        return shell_complete(cli, {}, "mikas", VARIABLE, os.environ[VARIABLE])
    except Exception:  # in the middle of a line a message would be in the way
        return 1


def channel_names(_: click.Context, __: click.Parameter, incomplete: str) -> list[CompletionItem]:
    """Return the mnemonics that begin so, then other names («обороты», `rpm`) with theirs."""
    from mikas.cli.language import localized

    catalog = _catalog()
    items = [
        CompletionItem(name, help=localized(channel.short))
        for name, channel in catalog.channels.items()
        if name.startswith(incomplete.upper())
    ]
    if incomplete:
        begin = incomplete.casefold().replace("ё", "е")
        items += [
            CompletionItem(other, help=name)
            for other, name in catalog.synonyms.items()
            if other.startswith(begin)
        ]
    return items


def _catalog() -> Catalog:
    from mikas.catalog import shipped
    from mikas.catalog.own.file import OwnCatalog
    from mikas.cli.config import own_catalog
    from mikas.errors import MikasError

    try:
        return OwnCatalog(own_catalog()).load().catalog
    except (MikasError, OSError):
        return shipped()
