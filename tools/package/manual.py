"""mikas(1), the manual page: commands and options as the command line's own help has them."""

from __future__ import annotations

import re
from collections.abc import Iterable
from datetime import UTC, datetime

import click

from mikas.cli.language import localized, set_language, tr
from mikas.cli.main import cli
from mikas.i18n import Language
from tools.package.project import project, time_of_source, version


def page(language: Language) -> str:
    """Return the page in roff."""
    set_language(language)
    context = click.Context(cli, info_name="mikas")
    date = datetime.fromtimestamp(time_of_source(), UTC).date()
    options = [
        record for each in cli.get_params(context) if (record := each.get_help_record(context))
    ]
    commands = [(name, localized(text)) for name, (_, text) in cli.homes.items()]
    said = localized(cli.text)
    short = tr("engine diagnostics over K-Line", "диагностика двигателя по K-Line")
    more = tr(
        "COMMAND --help has the options of a command, with examples.",
        "Ключи каждой команды и примеры показывает КОМАНДА --help.",
    )
    return "\n".join(
        [
            f'.TH MIKAS 1 "{date}" "mikas {version()}"',
            f".SH {tr('NAME', 'НАЗВАНИЕ')}",
            f"mikas \\- {_escaped(short)}",
            f".SH {tr('SYNOPSIS', 'ВЫЗОВ')}",
            f".B mikas\n{_escaped(' '.join(cli.collect_usage_pieces(context)))}",
            f".SH {tr('DESCRIPTION', 'ОПИСАНИЕ')}",
            f"{_escaped(said)}\n.PP\n{_escaped(more)}",
            f".SH {tr('COMMANDS', 'КОМАНДЫ')}",
            *_list(commands),
            f".SH {tr('OPTIONS', 'КЛЮЧИ')}",
            *_list(filter(None, options)),
            f".SH {tr('SEE ALSO', 'СМ. ТАКЖЕ')}",
            project()["urls"]["Homepage"],
            "",
        ]
    )


def _list(records: Iterable[tuple[str, str]]) -> list[str]:
    return [f".TP\n.B {_escaped(name)}\n{_escaped(text)}" for name, text in records]


def _escaped(text: str) -> str:
    text = text.replace("\\", "\\e").replace("-", "\\-")
    return re.sub(r"^([.'])", r"\\&\1", text, flags=re.MULTILINE)
