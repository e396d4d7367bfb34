"""click with texts in two languages, the common options, and late imports of commands."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import field, fields
from functools import wraps
from importlib import import_module
from typing import Any, Final, TypeVar, cast

import click

from mikas.cli.completion.values import Offers, files
from mikas.cli.language import localized, tr
from mikas.cli.options.common import CommonOption, LocalizedOption, common_options
from mikas.cli.options.parameter_types import OFFERED, any_file
from mikas.cli.render.help_formatter import HelpContext, HelpFormatter
from mikas.cli.render.terminal import write_error
from mikas.i18n import Text
from mikas.options import nearest

F = TypeVar("F", bound=Callable[..., Any])
T = TypeVar("T")
Home = tuple[str, Text]
"""The module of a command, and its line in the help."""
_OPTION: Final = "option"  # key of a field's metadata


def option(*names: str, en: str, ru: str, **settings: Any) -> Callable[[F], F]:
    """`click.option` with its help in both languages."""
    return click.option(*names, cls=LocalizedOption, en=en, ru=ru, **settings)


def argument(name: str, metavar: str, **settings: Any) -> Callable[[F], F]:
    """`click.argument`; a file is completed as one."""
    settings.setdefault("shell_complete", OFFERED.get(settings.get("type")))
    return click.argument(name, metavar=metavar, **settings)


def option_field(default: T, name: str, *, en: str, ru: str, **settings: Any) -> T:
    """Return a field of a dataclass for `grouped`: an option of the field's name."""
    return field(default=default, metadata={_OPTION: option(name, en=en, ru=ru, **settings)})


def optional_field(name: str, *, parse: Callable[[str], T], **settings: Any) -> T | None:
    """As `option_field`, for a text that `parse` reads; None: the option is not given."""
    return option_field(None, name, type=parse, **settings)


def flag_field(name: str, *, en: str, ru: str) -> bool:
    """As `option_field`, for an option without a value."""
    return option_field(False, name, is_flag=True, en=en, ru=ru)


def grouped(
    kind: type[Any], *more: Callable[..., Any]
) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """Return a decorator that adds the options of `kind`, a dataclass, and `more` parameters.

    The command gets an instance of `kind` as the argument after the context, before those of the
    decorators above. A field without an option is filled by the parameter of its name.
    """
    options = [each.metadata[_OPTION] for each in fields(kind) if each.metadata]

    def decorate(function: Callable[..., Any]) -> Callable[..., Any]:
        @wraps(function)
        def call(context: object, *groups: object, **values: Any) -> Any:  # noqa: ANN401  (as the command)
            given = {each.name: values.pop(each.name) for each in fields(kind)}
            group = kind(**{name: value for name, value in given.items() if value is not None})
            return function(context, group, *groups, **values)

        command: Callable[..., Any] = call
        for add in reversed((*options, *more)):
            command = add(command)
        return command

    return decorate


def flag(*names: str, en: str, ru: str) -> Callable[[F], F]:
    """`option` without a value."""
    return option(*names, is_flag=True, en=en, ru=ru)


def output_option(
    metavar: str = "OUT",
    *,
    endings: Sequence[str] = (),
    required: bool = True,
    en: str = "output file; required",
    ru: str = "выходной файл; обязательно",
) -> Callable[[F], F]:
    """`option` of the file that the command writes; `endings`: of such files."""
    settings = {"required": required, "metavar": metavar, "shell_complete": files(*endings)}
    return option("-o", "--out", type=any_file, en=en, ru=ru, **settings)


YES = flag("--yes", en="do not ask", ru="не спрашивать")
SURE = flag(
    "--i-know-what-this-does",
    "sure",
    en="required together with --yes for what can leave the unit unable to run",
    ru="обязателен вместе с --yes, если после команды блок может перестать работать",
)
OVERWRITE = flag(
    "--overwrite",
    en="replace OUT if it exists",
    ru="заменить OUT, если файл есть",
)


class LocalizedCommand(click.Command):
    """A command with the common options; its help, in both languages, ends with examples."""

    context_class = HelpContext

    def __init__(
        self, *args: Any, en: str, ru: str, examples: tuple[str, ...] = (), **kwargs: Any
    ) -> None:
        super().__init__(*args, **kwargs)
        self.params.extend(common_options())
        self.text: Text = Text(en, ru)
        self.examples = examples

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        allow_more = ctx.allow_extra_args
        ctx.allow_extra_args = True  # surplus words are reported below
        if ctx.resilient_parsing:  # a shell completes the line
            return super().parse_args(ctx, self._without_open_end(args, ctx))
        given = [*args]  # click empties the list
        try:
            rest = super().parse_args(ctx, args)
        except click.NoSuchOption as error:
            raise self._unknown_option(error.option_name, given, ctx) from error
        except click.UsageError as error:
            error.ctx = error.ctx or ctx
            raise
        if rest and not allow_more:
            surplus = " ".join(rest)
            raise click.UsageError(
                tr(f"Unexpected argument: “{surplus}”.", f"Лишний аргумент: «{surplus}»."), ctx
            )
        return rest

    def _without_open_end(self, args: list[str], ctx: click.Context) -> list[str]:
        """Return `args` without an option at the end whose value is still to come.

        It would keep click from reading the others.
        """
        options = (it for it in self.get_params(ctx) if isinstance(it, click.Option))
        open_ones = {opt for it in options if not it.is_flag and not it.count for opt in it.opts}
        return args[:-1] if args and args[-1] in open_ones else args

    def _unknown_option(
        self, name: str, given: list[str], ctx: click.Context
    ) -> click.NoSuchOption:
        """Return the error with the nearest options; `-port` is one word, as who wrote it meant."""
        known = [opt for it in self.get_params(ctx) for opt in (*it.opts, *it.secondary_opts)]
        long = [opt for opt in known if opt.startswith("--")]
        for word in given:
            begin = word.partition("=")[0]
            if re.match("-[^-].", begin) and name[1:] in begin and nearest(f"-{begin}", long):
                name = begin
                break
        near = nearest(f"--{name.lstrip('-')}", long, 2) if len(name) > 2 else ()
        return click.NoSuchOption(name, possibilities=near, ctx=ctx)

    def shell_complete(self, ctx: click.Context, incomplete: str) -> Offers:
        """Offer the options that begin so and may still come, with their texts."""
        from click.shell_completion import CompletionItem

        if incomplete and not incomplete.startswith("-"):
            return []
        given = click.core.ParameterSource.COMMANDLINE
        return [
            CompletionItem(name, help=_line_of(it))
            for it in self.get_params(ctx)
            if isinstance(it, click.Option)
            and (it.multiple or it.count or ctx.get_parameter_source(it.name or "") is not given)
            for name in (*it.opts, *it.secondary_opts)
            if name.startswith(incomplete)
        ]

    def get_help_option(self, ctx: click.Context) -> click.Option | None:
        option = super().get_help_option(ctx)
        if option:
            option.help = tr("show this help", "показать эту справку")
        return option

    def collect_usage_pieces(self, ctx: click.Context) -> list[str]:
        self.options_metavar: str | None = tr("[OPTIONS]", "[КЛЮЧИ]")
        return super().collect_usage_pieces(ctx)

    def format_usage(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        pieces = " ".join(self.collect_usage_pieces(ctx))
        formatter.write_usage(ctx.command_path, pieces, prefix=tr("Usage: ", "Вызов: "))

    def format_help_text(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        formatter.write_paragraph()
        formatter.write_text(localized(self.text))

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        options = [p for p in self.get_params(ctx) if isinstance(p, click.Option)]
        own = [p for p in options if not isinstance(p, CommonOption)]
        common = [p for p in options if isinstance(p, CommonOption)]
        for title, parameters in (
            (tr("Options", "Ключи"), own),
            (tr("Common options", "Общие ключи"), common),
        ):
            records = [r for p in parameters if (r := p.get_help_record(ctx))]
            if records:
                with formatter.section(title):
                    formatter.write_dl(records)

    def format_epilog(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        if self.examples:
            with formatter.section(tr("Examples", "Примеры")):
                for example in self.examples:
                    cast("HelpFormatter", formatter).write_example(example)


def _line_of(option: click.Option) -> str:
    """Return the text of an option, which is that of its help."""
    return localized(option.text) if isinstance(option, LocalizedOption) else option.help or ""


class LocalizedGroup(LocalizedCommand, click.Group):
    """A group whose commands are import paths until they are called.

    `homes`: name → (module, text); the module has an attribute of the same name. `titles`: those of
    the list, each above the command of the name. The list is shown without importing any command.
    """

    def __init__(
        self,
        *args: Any,
        homes: Mapping[str, Home],
        titles: Mapping[str, Text] | None = None,
        **kwargs: Any,
    ) -> None:
        super().__init__(*args, invoke_without_command=True, callback=_require_command, **kwargs)
        self.homes, self.titles = homes, titles or {}

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(self.homes)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command:
        if cmd_name not in self.homes:
            raise click.UsageError(self._unknown(cmd_name, ctx), ctx)
        command: click.Command = getattr(import_module(self.homes[cmd_name][0]), cmd_name)
        return command

    def shell_complete(self, ctx: click.Context, incomplete: str) -> Offers:
        return self.offers(incomplete) + (
            LocalizedCommand.shell_complete(self, ctx, incomplete) if incomplete else []
        )

    def offers(self, incomplete: str) -> Offers:
        """Offer the commands that begin so, with their lines."""
        from click.shell_completion import CompletionItem

        return [
            CompletionItem(name, help=localized(text))
            for name, (_, text) in self.homes.items()
            if name.startswith(incomplete)
        ]

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        if (
            not args
            and not ctx.resilient_parsing
            and not ctx.find_root().ensure_object(dict).get("json")
        ):
            write_error(f"{ctx.get_help()}\n")
            ctx.exit(2)
        return super().parse_args(ctx, args)

    def _unknown(self, name: str, ctx: click.Context) -> str:
        near = nearest(name, self.homes, 2)
        if not near and any(f"--{name}" in it.opts for it in self.get_params(ctx)):
            near = (f"{ctx.command_path} --{name}",)
        listed = ", ".join(near or self.homes)
        problem = tr(f"There is no command “{name}”.", f"Команды «{name}» нет.")
        if near:
            return f"{problem} {tr(f'Did you mean {listed}?', f'Может быть, {listed}?')}"
        return f"{problem} {tr(f'There are {listed}.', f'Есть {listed}.')}"

    def listed(self) -> list[tuple[Text | None, list[tuple[str, str]]]]:
        """Return each title with its commands and their lines in the help."""
        found: list[tuple[Text | None, list[tuple[str, str]]]] = []
        width = max(map(len, self.homes))  # one column for all titles
        for name, (_, text) in self.homes.items():
            if name in self.titles or not found:
                found.append((self.titles.get(name), []))
            found[-1][1].append((name.ljust(width), localized(text)))
        return found

    def collect_usage_pieces(self, ctx: click.Context) -> list[str]:
        self.subcommand_metavar: str = tr("COMMAND [ARGUMENTS]...", "КОМАНДА [АРГУМЕНТЫ]...")
        return super().collect_usage_pieces(ctx)

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        with formatter.section(tr("Commands", "Команды")):
            for title, rows in self.listed():
                if title is None:
                    formatter.write_dl(rows)
                    continue
                formatter.write_heading(localized(title))
                with formatter.indentation():
                    formatter.write_dl(rows)
        LocalizedCommand.format_options(self, ctx, formatter)


@click.pass_context
def _require_command(ctx: click.Context) -> None:
    if ctx.invoked_subcommand is None:
        raise click.UsageError(tr("A command is missing.", "Не указана команда."), ctx)


def command(
    *, en: str, ru: str, **settings: Any
) -> Callable[[Callable[..., Any]], LocalizedCommand]:
    """Make a function the command of its name, with the common options.

    It is called with a `CommandContext`, then with its own arguments.
    """

    def decorate(function: Callable[..., Any]) -> LocalizedCommand:
        @click.command(function.__name__, cls=LocalizedCommand, en=en, ru=ru, **settings)
        @click.pass_context
        @wraps(function)
        def call(ctx: click.Context, *args: Any, **kwargs: Any) -> Any:  # noqa: ANN401  (the command's)
            from mikas.cli.context import CommandContext
            from mikas.cli.render.output import log_to_stderr

            context = CommandContext.from_options(ctx.find_root().ensure_object(dict))
            with log_to_stderr() if context.logs else nullcontext():
                return function(context, *args, **kwargs)

        return call

    return decorate
