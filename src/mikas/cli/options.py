"""Options with a text in two languages; those that every command has (docs/cli.md, Everywhere)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields
from functools import wraps
from typing import Any, TypeVar

import click

from mikas.cli.config import ECHO, INTERPRETATIONS, LANGUAGES, MAX_RETRIES, MAX_TIMEOUT
from mikas.cli.language import localized
from mikas.cli.parameter_types import File, Number, OneOf, Whole
from mikas.i18n import Text

F = TypeVar("F", bound=Callable[..., Any])


class LocalizedOption(click.Option):
    """An option whose help is a `Text`."""

    def __init__(self, *args: Any, text: Text, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self.text = text

    def get_help_record(self, ctx: click.Context) -> tuple[str, str] | None:
        record = super().get_help_record(ctx)
        # click's notes in brackets are English only; our texts contain limits and "required".
        return (record[0], localized(self.text)) if record else None


class CommonOption(LocalizedOption):
    """An option that every command has, before or after its name."""

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, expose_value=False, callback=_keep, **kwargs)


def _keep(ctx: click.Context, option: click.Parameter, value: object) -> object:
    """Store the value in the settings of this command; the last one on the line wins."""
    given = ctx.get_parameter_source(option.name or "")
    if given is click.core.ParameterSource.COMMANDLINE:
        ctx.find_root().ensure_object(dict)[option.name] = value
    return value


def common_options() -> list[click.Parameter]:
    """Return new instances of the common options, for one command."""
    return [
        CommonOption(
            ["--port"],
            metavar="URL",
            text=Text(
                "/dev/ttyUSB0, COM3, socket://host:port, rfc2217://host:port, sim: (a virtual "
                "ECU), replay:FILE (a recorded one)",
                "/dev/ttyUSB0, COM3, socket://host:port, rfc2217://host:port, sim: (виртуальный "
                "блок), replay:FILE (записанный)",
            ),
        ),
        CommonOption(
            ["--echo"],
            type=OneOf(ECHO),
            text=Text(
                "whether the adapter echoes what it sends (auto: detect)",
                "возвращает ли адаптер эхо (auto: определить)",
            ),
        ),
        CommonOption(
            ["--timeout"],
            type=Number(above=0, most=MAX_TIMEOUT),
            metavar="SECONDS",
            text=Text(
                "how long to wait for the first byte of a response (0.5)",
                "сколько ждать первого байта ответа, секунд (0.5)",
            ),
        ),
        CommonOption(
            ["--retries"],
            type=Whole(0, MAX_RETRIES),
            metavar="N",
            text=Text(
                "how often to repeat a failed request, if that is safe (2)",
                "сколько раз повторять неудачный запрос, если это безопасно (2)",
            ),
        ),
        CommonOption(
            ["--capture"],
            type=File(),
            metavar="FILE",
            text=Text(
                "record everything on the line (.pcapng)", "записать весь обмен на линии (.pcapng)"
            ),
        ),
        CommonOption(
            ["--interpretation"],
            type=OneOf(INTERPRETATIONS),
            text=Text(
                "how the doubtful places of the protocol's source are interpreted (corrected)",
                "как толковать сомнительные места описания протокола (corrected)",
            ),
        ),
        CommonOption(
            ["--catalog"],
            type=File(),
            multiple=True,
            metavar="FILE",
            text=Text(
                "your own parameters and faults, added to the shipped ones",
                "свои параметры и ошибки в дополнение к встроенным",
            ),
        ),
        CommonOption(["--lang"], type=OneOf(LANGUAGES), text=Text("language", "язык: en или ru")),
        CommonOption(["--json"], is_flag=True, text=Text("JSON on stdout", "вывод в виде JSON")),
        CommonOption(
            ["-v", "--verbose"],
            count=True,
            text=Text(
                "more details (on stderr); -vv: the log too, with every frame",
                "больше подробностей (в stderr); -vv — ещё и журнал с каждым кадром",
            ),
        ),
    ]


def option(*names: str, text: Text, **settings: Any) -> Callable[[F], F]:
    """`click.option` with a `Text`."""
    return click.option(*names, cls=LocalizedOption, text=text, **settings)


def grouped(
    kind: type[Any], *options: Callable[[Callable[..., Any]], Callable[..., Any]]
) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """Return a decorator that adds `options`; the command gets them as one dataclass `kind`.

    `kind` has a field for each option; it is the argument after the context.
    """

    def decorate(function: Callable[..., Any]) -> Callable[..., Any]:
        @wraps(function)
        def call(context: object, **values: Any) -> Any:  # noqa: ANN401  (as the command)
            group = kind(**{field.name: values.pop(field.name) for field in fields(kind)})
            return function(context, group, **values)

        command: Callable[..., Any] = call
        for add in reversed(options):
            command = add(command)
        return command

    return decorate


YES = option("--yes", is_flag=True, text=Text("do not ask", "не спрашивать"))
OUT = option(
    "-o",
    "--out",
    required=True,
    type=File(),
    metavar="OUT",
    text=Text("output file; required", "выходной файл; обязательно"),
)
OVERWRITE = option(
    "--overwrite",
    is_flag=True,
    text=Text("replace OUT if it exists", "заменить OUT, если файл есть"),
)
