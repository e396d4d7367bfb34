"""click, with texts in two languages, the common options everywhere, and commands imported late.

The common options stand before or after the command's name (docs/cli.md): the group and every
command have them, and what is given nearer to the end wins.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from importlib import import_module
from typing import Any, TypeVar

import click

from mikas.cli.words import say, shown
from mikas.language import Text

F = TypeVar("F", bound=Callable[..., Any])


class Option(click.Option):
    """An option whose help is a `Text`."""

    def __init__(self, *args: Any, text: Text, **kwargs: Any) -> None:  # noqa: ANN401
        super().__init__(*args, **kwargs)
        self.text = text

    def get_help_record(self, ctx: click.Context) -> tuple[str, str] | None:
        self.help = shown(self.text)
        return super().get_help_record(ctx)


class Command(click.Command):
    """A command whose help is a `Text`, followed by examples."""

    def __init__(
        self,
        *args: Any,  # noqa: ANN401
        text: Text,
        examples: tuple[str, ...] = (),
        **kwargs: Any,  # noqa: ANN401
    ) -> None:
        super().__init__(*args, **kwargs)
        self.text = text
        self.examples = examples

    def get_short_help_str(self, limit: int = 45) -> str:  # noqa: ARG002  (never cut)
        return shown(self.text).split(". ")[0].rstrip(".")

    def format_usage(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        pieces = " ".join(self.collect_usage_pieces(ctx))
        formatter.write_usage(ctx.command_path, pieces, prefix=say("Usage: ", "Вызов: "))

    def format_help_text(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:  # noqa: ARG002
        formatter.write_paragraph()
        formatter.write_text(shown(self.text))

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        own = [p for p in self.get_params(ctx) if not isinstance(p, CommonOption)]
        common = [p for p in self.get_params(ctx) if isinstance(p, CommonOption)]
        for title, parameters in (
            (say("Options", "Параметры"), own),
            (say("Common options", "Общие параметры"), common),
        ):
            records = [r for p in parameters if (r := p.get_help_record(ctx))]
            if records:
                with formatter.section(title):
                    formatter.write_dl(records)

    def format_epilog(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:  # noqa: ARG002
        if self.examples:
            with formatter.section(say("Examples", "Примеры")):
                for example in self.examples:
                    formatter.write(f"  {example}\n")


class Group(Command, click.Group):
    """A group whose commands are import paths until they are called.

    `homes`: name → (module:attribute, text). The text stands here so that the list of commands is
    shown without importing any.
    """

    def __init__(
        self,
        *args: Any,  # noqa: ANN401
        homes: Mapping[str, tuple[str, Text]],
        **kwargs: Any,  # noqa: ANN401
    ) -> None:
        super().__init__(*args, **kwargs)
        self.homes = homes

    def list_commands(self, ctx: click.Context) -> list[str]:  # noqa: ARG002
        return list(self.homes)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:  # noqa: ARG002
        if cmd_name not in self.homes:
            return None
        module, _, attribute = self.homes[cmd_name][0].partition(":")
        command: click.Command = getattr(import_module(module), attribute)
        return command

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        Command.format_options(self, ctx, formatter)
        with formatter.section(say("Commands", "Команды")):
            formatter.write_dl([(name, shown(text)) for name, (_, text) in self.homes.items()])


class CommonOption(Option):
    """An option that every command has, before or after its name."""

    def __init__(self, *args: Any, **kwargs: Any) -> None:  # noqa: ANN401
        super().__init__(*args, expose_value=False, callback=_keep, **kwargs)


def _keep(ctx: click.Context, option: click.Parameter, value: object) -> object:
    """Puts what was given into the settings of this run, nearest to the end of the line wins."""
    given = ctx.get_parameter_source(option.name or "")
    if given is click.core.ParameterSource.COMMANDLINE:
        ctx.find_root().ensure_object(dict)[option.name] = value
    return value


ECHO = click.Choice(["auto", "on", "off"])
READING = click.Choice(["corrected", "literal", "alternative"])


def common_options() -> list[click.Parameter]:
    """Fresh instances of the common options, for one command."""
    return [
        CommonOption(
            ["--port"],
            metavar="URL",
            text=Text(
                "/dev/ttyUSB0, COM3, socket://host:port, rfc2217://host:port, sim: …",
                "/dev/ttyUSB0, COM3, socket://host:port, rfc2217://host:port, sim: …",
            ),
        ),
        CommonOption(
            ["--echo"],
            type=ECHO,
            text=Text(
                "whether the adapter returns what it sends (auto finds out)",
                "возвращает ли адаптер посланное (auto определяет сам)",
            ),
        ),
        CommonOption(
            ["--timeout"],
            type=click.FloatRange(min=0, min_open=True, max=60),
            metavar="SECONDS",
            text=Text("first byte of a response (0.5)", "ожидание первого байта ответа (0.5)"),
        ),
        CommonOption(
            ["--retries"],
            type=click.IntRange(0, 100),
            metavar="N",
            text=Text("of what is safe to repeat (2)", "повторы безопасных запросов (2)"),
        ),
        CommonOption(
            ["--capture"],
            type=click.Path(dir_okay=False),
            metavar="FILE",
            text=Text(
                "record everything on the wire (.pcapng)",
                "записать всё, что было на линии (.pcapng)",
            ),
        ),
        CommonOption(
            ["--reading"],
            type=READING,
            text=Text("of the source's doubtful places", "толкование сомнительных мест источника"),
        ),
        CommonOption(
            ["--catalog"],
            type=click.Path(dir_okay=False),
            multiple=True,
            metavar="FILE",
            text=Text("your own definitions, over ours", "свои определения поверх наших"),
        ),
        CommonOption(["--lang"], type=click.Choice(["en", "ru"]), text=Text("language", "язык")),
        CommonOption(
            ["--json"], is_flag=True, text=Text("JSON on stdout", "JSON на стандартный вывод")
        ),
        CommonOption(
            ["-v", "--verbose"], is_flag=True, text=Text("more on stderr", "подробности в stderr")
        ),
    ]


def command(
    name: str,
    text: Text,
    *,
    examples: tuple[str, ...] = (),
    **settings: Any,  # noqa: ANN401
) -> Callable[[Callable[..., Any]], Command]:
    """Makes a function a command with the common options. It gets `run`, then its own arguments."""

    def decorate(function: Callable[..., Any]) -> Command:
        made = click.command(name, cls=Command, text=text, examples=examples, **settings)(
            click.pass_context(_with_run(function))
        )
        made.params.extend(common_options())
        return made

    return decorate


def _with_run(function: Callable[..., Any]) -> Callable[..., Any]:
    from functools import wraps

    @wraps(function)
    def call(ctx: click.Context, *args: Any, **kwargs: Any) -> Any:  # noqa: ANN401
        from mikas.cli.run import Run

        return function(Run.of(ctx.find_root().ensure_object(dict)), *args, **kwargs)

    return call


def option(*names: str, text: Text, **settings: Any) -> Callable[[F], F]:  # noqa: ANN401
    """`click.option` with a `Text`."""
    return click.option(*names, cls=Option, text=text, **settings)


YES = option("--yes", is_flag=True, text=Text("do not ask", "не спрашивать"))
