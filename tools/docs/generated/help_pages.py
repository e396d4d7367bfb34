"""What every command says to `--help`, on one page; options of all commands only once."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import redirect_stdout
from io import StringIO

import click

from mikas.cli.main import cli, run
from mikas.i18n import Language, Text
from tools.docs.generated.tables import page

_COMMON = Text("Common options:", "Общие ключи:")


def help_page(language: Language) -> str:
    """Return the page."""
    common = re.compile(rf"^{_COMMON.to(language)}\n(?:(?: .*)?\n)*", re.MULTILINE)
    parts = []
    for words in _commands(cli, ()):
        said = _said([*words, "--help", "--lang", language])
        title = " ".join(("mikas", *words))
        assert common.search(said), title
        shown = common.sub("", said) if words else said
        parts.append(f"## {title}\n\n```text\n{shown.strip()}\n```\n")
    return page("help", language, help="\n".join(parts))


def _commands(group: click.Group, path: tuple[str, ...]) -> Iterator[tuple[str, ...]]:
    yield path
    context = click.Context(group)
    for name in group.list_commands(context):
        command = group.get_command(context, name)
        if isinstance(command, click.Group):
            yield from _commands(command, (*path, name))
        else:
            yield (*path, name)


def _said(argv: list[str]) -> str:
    written = StringIO()
    with redirect_stdout(written):
        assert run(argv) == 0
    return written.getvalue()
