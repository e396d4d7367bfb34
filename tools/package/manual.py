"""The manual: mikas(1) and a page of each command, as the command line's own help has them.

The pages are roff of man(7), in UTF-8. A page has the options of its command; those of every
command stand in mikas(1).
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from datetime import UTC, datetime
from textwrap import fill
from typing import Final

import click

from mikas.cli.click_extensions import LocalizedCommand, LocalizedGroup
from mikas.cli.language import localized, set_language, tr
from mikas.cli.main import cli
from mikas.cli.options.common import CommonOption
from mikas.i18n import Language, Text
from tools.package.project import project, time_of_source, version

_SHORT: Final = Text("engine diagnostics over K-Line", "диагностика двигателя по K-Line")
_STATUSES: Final = (
    ("0", Text("success", "успех")),
    ("1", Text("a bug in mikas", "ошибка в программе mikas")),
    ("2", Text("wrong usage", "неверный вызов")),
    (
        "3",
        Text(
            "no connection: no port, port busy, no response",
            "нет связи: нет порта, порт занят, нет ответа",
        ),
    ),
    (
        "4",
        Text(
            "line errors that retries did not cure", "ошибки на линии, которые не исправили повторы"
        ),
    ),
    (
        "5",
        Text("the unit refused, or does not know the command", "блок отказал или не знает команды"),
    ),
    ("6", Text("not confirmed", "не подтверждено")),
    ("130", Text("interrupted by Ctrl-C", "прервано по Ctrl-C")),
)
_ENVIRONMENT: Final = (
    ("MIKAS_PORT", Text("the port, unless --port names one", "порт, если его не задаёт --port")),
    ("MIKAS_CONFIG", Text("another config file", "другой файл настроек")),
    ("MIKAS_STATE", Text("another folder for what is remembered", "другая папка для изученного")),
    ("MIKAS_LANG", Text("the language, en or ru", "язык: en или ru")),
    ("MIKAS_MQTT_USER", Text("the user of `mikas publish`", "имя для `mikas publish`")),
    ("MIKAS_MQTT_PASSWORD", Text("its password", "пароль к нему")),
    ("NO_COLOR", Text("no colours", "без цветов")),
)
_FILES: Final = (
    (
        "~/.config/mikas/config.toml",
        Text("settings of every command: port, lang …", "настройки всех команд: port, lang …"),
    ),
    (
        "~/.config/mikas/catalog.toml",
        Text("your own parameters and faults", "свои параметры и ошибки"),
    ),
    (
        "~/.local/state/mikas",
        Text(
            "what is remembered of units, and the journal of changes",
            "изученное о блоках и журнал изменений",
        ),
    ),
)


def files() -> dict[str, str]:
    """Return the pages of both languages by the names of their files in a folder `share`."""
    folders: tuple[tuple[Language, str], ...] = (("en", "man/man1"), ("ru", "man/ru/man1"))
    return {
        f"{folder}/{name}.1": page
        for language, folder in folders
        for name, page in pages(language).items()
    }


def pages(language: Language) -> dict[str, str]:
    """Return the pages by name: `mikas`, `mikas-read`, `mikas-mem`, `mikas-mem-dump` …"""
    set_language(language)
    try:
        root = cli.context_class(cli, info_name="mikas")
        return dict(_pages(root, _SHORT))
    finally:
        set_language("en")


def _pages(context: click.Context, short: Text) -> Iterator[tuple[str, str]]:
    name = _name(context)
    lines = [*_head(name, localized(short)), *_body(context)]
    yield name, "\n".join([*lines, ""])
    group = context.command
    if not isinstance(group, LocalizedGroup):
        return
    for inner_name, (_, text) in group.homes.items():
        inner = group.get_command(context, inner_name)
        assert isinstance(inner, LocalizedCommand)
        yield from _pages(inner.context_class(inner, parent=context, info_name=inner_name), text)


def _name(context: click.Context) -> str:
    return context.command_path.replace(" ", "-")


def _head(name: str, short: str) -> list[str]:
    date = datetime.fromtimestamp(time_of_source(), UTC).date()
    title = tr("mikas manual", "Справка по mikas")
    return [
        f'.TH {_escaped(name.upper())} 1 "{date}" "mikas {version()}" "{title}"',
        ".nh",  # whole words
        ".ad l",
        f".SH {tr('NAME', 'НАЗВАНИЕ')}",
        rf"{_escaped(name)} \- {_escaped(short.replace('`', ''))}",
    ]


def _body(context: click.Context) -> list[str]:
    command = context.command
    assert isinstance(command, LocalizedCommand)
    is_root = context.parent is None
    options = [it for it in command.get_params(context) if isinstance(it, click.Option)]
    common = [it for it in options if isinstance(it, CommonOption)]
    own = [it for it in options if it not in common]
    pieces = " ".join(command.collect_usage_pieces(context))
    lines = [
        f".SH {tr('SYNOPSIS', 'ВЫЗОВ')}",
        f"{_bold(context.command_path)} {_escaped(pieces)}",
        f".SH {tr('DESCRIPTION', 'ОПИСАНИЕ')}",
        _prose(localized(command.text)),
    ]
    if isinstance(command, LocalizedGroup):
        lines += _commands(command, _name(context))
    lines += [f".SH {tr('OPTIONS', 'КЛЮЧИ')}", *_options(own, context)]
    if is_root:
        every = tr("Options of every command", "Ключи всех команд")
        lines += [f".SS {every}", *_options(common, context), *_environment()]
    else:
        more = tr("The options of every command are in", "Ключи всех команд описаны в")
        lines += [".PP", rf"{more} \fBmikas\fR(1)."]
    lines += [f".SH {tr('EXAMPLES', 'ПРИМЕРЫ')}"]
    lines += [".nf", *map(_escaped, command.examples), ".fi"]
    return [*lines, f".SH {tr('SEE ALSO', 'СМ. ТАКЖЕ')}", *_see_also(context)]


def _commands(group: LocalizedGroup, name: str) -> Iterator[str]:
    yield f".SH {tr('COMMANDS', 'КОМАНДЫ')}"
    for title, rows in group.listed():
        if title is not None:
            yield f".SS {_escaped(localized(title))}"
        for word, text in rows:
            yield f".TP\n{_bold(f'{name}-{word.strip()}')}(1)\n{_prose(text)}"


def _options(options: Iterable[click.Option], context: click.Context) -> Iterator[str]:
    for each in options:
        if (record := each.get_help_record(context)) is not None:
            words = re.split(r"(--?[\w-]+)", record[0])  # at odd places the options
            shown = "".join(
                _bold(word) if number % 2 else _italic(word) for number, word in enumerate(words)
            )
            yield f".TP\n{shown}\n{_prose(record[1])}"


def _environment() -> Iterator[str]:
    for title, rows in (
        (tr("EXIT STATUS", "КОД ЗАВЕРШЕНИЯ"), _STATUSES),
        (tr("ENVIRONMENT", "ПЕРЕМЕННЫЕ ОКРУЖЕНИЯ"), _ENVIRONMENT),
        (tr("FILES", "ФАЙЛЫ"), _FILES),
    ):
        yield f".SH {title}"
        for word, text in rows:
            yield f".TP\n{_bold(word)}\n{_prose(localized(text))}"


def _see_also(context: click.Context) -> Iterator[str]:
    if context.parent is not None:
        yield f"{_bold(_name(context.parent))}(1)"
        yield ".PP"
    if context.parent is None:
        help_text = tr(
            "`mikas help COMMAND` shows the same in the terminal.",
            "`mikas help КОМАНДА` показывает то же в терминале.",
        )
        yield _prose(help_text)
        yield ".PP"
    yield _escaped(str(project()["urls"]["Documentation"]))


def _prose(text: str) -> str:
    """Return a paragraph, with what stands in backticks in bold."""
    parts = re.split("`([^`]*)`", text)  # at odd places what stands in backticks
    shown = "".join(
        _bold(part) if number % 2 else _escaped(part) for number, part in enumerate(parts)
    )
    return _protected(fill(shown, 79, break_long_words=False, break_on_hyphens=False))


def _bold(text: str) -> str:
    return rf"\fB{_escaped(text)}\fR"


def _italic(text: str) -> str:
    """Return a value's name in italics; signs between options stay as they are."""
    stripped = text.strip(" ,/[]")
    if not stripped:
        return _escaped(text)
    begin, _, end = text.partition(stripped)
    return rf"{_escaped(begin)}\fI{_escaped(stripped)}\fR{_escaped(end)}"


_SIGNS: Final = str.maketrans(
    {"\\": r"\e", "-": r"\-", "'": r"\(aq", "`": r"\(ga", "^": r"\(ha", "~": r"\(ti", '"': r"\(dq"}
)


def _escaped(text: str) -> str:
    """Return text whose signs groff shows as they are, not as typographic ones."""
    return _protected(text.translate(_SIGNS))


def _protected(text: str) -> str:
    return re.sub(r"^(\.)", r"\\&\1", text, flags=re.MULTILINE)
