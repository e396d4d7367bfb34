"""`mikas help`: the help of the program, of a command, of a command in a group."""

from __future__ import annotations

from collections.abc import Sequence

import click

from mikas.cli.click_extensions import LocalizedCommand, LocalizedGroup, argument, command
from mikas.cli.completion.values import Offers
from mikas.cli.context import CommandContext
from mikas.cli.language import tr
from mikas.cli.options.parameter_types import OneOf


def _commands(ctx: click.Context, _: click.Parameter, incomplete: str) -> Offers:
    group = context_of(ctx.find_root(), ctx.params.get("words") or ()).command
    if not isinstance(group, LocalizedGroup):
        return []
    return group.offers(incomplete)


@command(
    en="Shows the help of COMMAND, as COMMAND --help does; without COMMAND, that of the program.",
    ru="Показывает справку по команде COMMAND, как COMMAND --help; без COMMAND — по программе.",
    examples=("mikas help", "mikas help watch", "mikas help mem dump"),
)
@argument("words", "[COMMAND]...", nargs=-1, shell_complete=_commands)
def help(context: CommandContext, words: Sequence[str]) -> None:  # noqa: A001  (the command's name)
    found = context_of(click.get_current_context().find_root(), words)
    text = found.get_help()
    context.output.result({"command": found.command_path, "help": text}, text)


def context_of(root: click.Context, words: Sequence[str]) -> click.Context:
    """Return the context of the command that `words` call. Raises `click.UsageError`."""
    found = root
    for number, word in enumerate(words):
        group = found.command
        if not isinstance(group, LocalizedGroup):
            if word in _actions(group):
                break
            path = " ".join(words[:number])
            raise click.UsageError(
                tr(
                    f"“{path}” is a command without further commands, so there is no “{word}”.",
                    f"«{path}» — команда без вложенных, поэтому «{word}» нет.",
                ),
                found,
            )
        inner = group.get_command(found, word)
        assert isinstance(inner, LocalizedCommand)
        found = inner.context_class(inner, info_name=word, parent=found)
    return found


def _actions(command: click.Command) -> Sequence[str]:
    """Return the words that the first argument of `command` may be: `erase` of `faults`."""
    first = next((each for each in command.params if isinstance(each, click.Argument)), None)
    return first.type.words if first is not None and isinstance(first.type, OneOf) else ()
