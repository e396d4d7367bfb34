"""`mikas`: the entry point, the list of commands, and what each kind of error means to a script.

Nothing heavy is imported here: `mikas --help` has to be there at once.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence

import click

from mikas.cli import words
from mikas.cli.grammar import Group, common_options
from mikas.cli.words import say, shown
from mikas.language import Text

DONE, BUG, USAGE, NO_CONNECTION, LINE, REFUSED, NOT_CONFIRMED = range(7)
INTERRUPTED = 130

_HERE = "mikas.cli.commands"
COMMANDS: dict[str, tuple[str, Text]] = {
    "ports": (
        f"{_HERE}.ports:ports",
        Text("adapters that are plugged in", "подключённые адаптеры"),
    ),
    "doctor": (
        f"{_HERE}.doctor:doctor",
        Text("finds out what is wrong with the connection", "находит, что не так со связью"),
    ),
    "info": (
        f"{_HERE}.info:info",
        Text("model, passports, what this unit supports", "модель, паспорта, что умеет этот блок"),
    ),
    "params": (
        f"{_HERE}.params:params",
        Text("every known parameter (needs no port)", "все известные параметры (порт не нужен)"),
    ),
    "read": (f"{_HERE}.read:read", Text("one reading each", "прочесть параметры один раз")),
    "watch": (f"{_HERE}.watch:watch", Text("live table", "живая таблица")),
    "log": (f"{_HERE}.log:log", Text("record to a file", "записать в файл")),
    "faults": (
        f"{_HERE}.faults:faults",
        Text("stored faults; `faults erase` erases them", "ошибки; `faults erase` стирает их"),
    ),
    "write": (f"{_HERE}.write:write", Text("write a parameter", "записать параметр")),
    "mem": (
        f"{_HERE}.mem:mem",
        Text("read, write, dump and compare memory", "чтение, запись, образ и сравнение памяти"),
    ),
    "raw": (f"{_HERE}.raw:raw", Text("send any request", "послать любой запрос")),
    "decode": (
        f"{_HERE}.decode:decode",
        Text("a capture, frame by frame (needs no port)", "запись линии по кадрам (порт не нужен)"),
    ),
    "sim": (
        f"{_HERE}.sim:sim",
        Text("a virtual ECU for other programs", "виртуальный блок для других программ"),
    ),
    "demo": (
        f"{_HERE}.demo:demo",
        Text("the live table with a virtual car", "живая таблица с виртуальной машиной"),
    ),
}


def _version(ctx: click.Context, _: click.Parameter, value: bool) -> None:
    if value:
        import mikas

        click.echo(f"mikas {mikas.__version__}")
        ctx.exit()


cli = Group(
    "mikas",
    homes=COMMANDS,
    text=Text(
        "Diagnostics for the Mikas 5.4 and 7.1 engine control units over K-Line. "
        "No cable at hand? Try: mikas demo",
        "Диагностика блоков управления Микас 5.4 и 7.1 по K-Line. "
        "Нет кабеля? Попробуйте: mikas demo",
    ),
    examples=("mikas doctor", "mikas read TWAT FREQ", "mikas watch --port sim:"),
    params=[
        *common_options(),
        click.Option(
            ["--version"], is_flag=True, is_eager=True, expose_value=False, callback=_version
        ),
    ],
)


def main(argv: Sequence[str] | None = None) -> None:
    """The `mikas` command. Ends the process with the status that docs/cli.md lays down."""
    sys.exit(run(sys.argv[1:] if argv is None else list(argv)))


def run(argv: list[str]) -> int:
    """Runs one command line; returns the exit status."""
    words.choose(words.from_surroundings(argv))
    try:
        # Not `cli.main`: it would end the process by itself when a pipe's reader is gone.
        with cli.make_context("mikas", argv) as context:
            result = cli.invoke(context)
        sys.stdout.flush()
        return result if isinstance(result, int) else DONE
    except click.exceptions.Exit as ended:
        return ended.exit_code
    except (KeyboardInterrupt, click.Abort):
        sys.stderr.write("\n")
        return INTERRUPTED
    except BrokenPipeError:
        # Whoever read our output has had enough; nothing to complain about, nor at exit.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return DONE
    except click.ClickException as error:
        return _usage(error)
    except (
        Exception
    ) as error:  # every other way out is either ours, or a bug that is said to be one
        return _failed(error, verbose="-v" in argv or "--verbose" in argv)


def _usage(error: click.ClickException) -> int:
    context = getattr(error, "ctx", None)
    path = context.command_path if context else "mikas"
    sys.stderr.write(f"{_in_words(error)}\n")
    sys.stderr.write(say(f"Try: {path} --help\n", f"Справка: {path} --help\n"))
    return USAGE


def _in_words(error: click.ClickException) -> str:
    possibilities = getattr(error, "possibilities", None)
    hint = (
        f" {say('Did you mean', 'Может быть')} {', '.join(possibilities)}?" if possibilities else ""
    )
    match error:
        case click.NoSuchOption():
            return (
                say(
                    f"There is no option {error.option_name}.",
                    f"Параметра {error.option_name} нет.",
                )
                + hint
            )
        case click.MissingParameter():
            name = error.param.human_readable_name if error.param else ""
            return say(f"{name} is missing.", f"Не хватает {name}.")
        case click.BadParameter() if error.param is not None:
            name = error.param.get_error_hint(error.ctx) if error.ctx else error.param.name
            return say(f"{name}: {error.message}", f"{name}: {error.message}")
    return error.format_message()


def _failed(error: Exception, *, verbose: bool) -> int:
    from mikas.errors import (
        EcuRefused,
        LineError,
        MikasError,
        NoConnection,
        NotConfirmed,
        UsageError,
    )

    if isinstance(error, MikasError):
        sys.stderr.write(shown(error.text) + "\n")
        if verbose and error.__cause__:
            sys.stderr.write(f"  ({type(error).__name__} ← {error.__cause__})\n")
        for kind, status in (
            (UsageError, USAGE),
            (NoConnection, NO_CONNECTION),
            (LineError, LINE),
            (EcuRefused, REFUSED),
            (NotConfirmed, NOT_CONFIRMED),
        ):
            if isinstance(error, kind):
                return status
    else:
        sys.stderr.write(
            say(
                f"This is a bug in mikas: {type(error).__name__}: {error}. Please report it with "
                f"the "
                "output of the same command with -v.\n",
                f"Это ошибка в mikas: {type(error).__name__}: {error}. Сообщите о ней, приложив "
                f"вывод "
                "той же команды с -v.\n",
            )
        )
        if verbose:
            import traceback

            traceback.print_exception(error)
    return BUG
