"""`mikas`: the entry point, and the exit status and message for each kind of error.

Nothing heavy is imported here: `mikas --help` must appear at once.
"""

from __future__ import annotations

import io
import os
import re
import sys
from collections.abc import Sequence
from pathlib import Path

import click

from mikas.cli import config
from mikas.cli.click_extensions import LocalizedGroup
from mikas.cli.commands import COMMANDS
from mikas.cli.common_options import LocalizedOption, common_options
from mikas.cli.language import capital, detect_language, localized, set_language, tr
from mikas.i18n import Text

DONE, BUG, USAGE, NO_CONNECTION, LINE, REFUSED, NOT_CONFIRMED = range(7)
INTERRUPTED = 130


def _version(ctx: click.Context, _: click.Parameter, value: bool) -> None:
    if value:
        import mikas

        click.echo(f"mikas {mikas.__version__}")
        ctx.exit()


cli = LocalizedGroup(
    "mikas",
    homes=COMMANDS,
    text=Text(
        "Diagnostics for the Mikas 5.4 and 7.1 engine control units over K-Line. "
        "No cable at hand? Try: mikas demo",
        "Диагностика блоков управления Микас 5.4 и 7.1 по K-Line. "
        "Нет кабеля под рукой? Попробуйте: mikas demo",
    ),
    examples=("mikas doctor", "mikas read TWAT FREQ", "mikas watch --port sim:"),
    params=[
        *common_options(),
        LocalizedOption(
            ["--version"],
            is_flag=True,
            is_eager=True,
            expose_value=False,
            callback=_version,
            text=Text("show the version", "показать версию программы"),
        ),
    ],
)


def main(argv: Sequence[str] | None = None) -> None:
    """Run the `mikas` command and end the process with the status of docs/cli.md."""
    _make_writable()
    sys.exit(run(sys.argv[1:] if argv is None else list(argv)))


def _make_writable() -> None:
    """Replace closed streams; replace characters that a stream can't encode."""
    for name, mode in (("stdin", "r"), ("stdout", "w"), ("stderr", "w")):
        if getattr(sys, name) is None:
            nowhere = Path(os.devnull).open(mode, encoding="utf-8")  # noqa: SIM115  (open for good)
            setattr(sys, name, nowhere)
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")


def run(argv: list[str]) -> int:
    """Run one command line; return the exit status."""
    try:
        set_language(detect_language(argv, config.language))
        # `cli.main` would end the process when a pipe's reader is gone.
        with cli.make_context("mikas", argv) as context:
            result = cli.invoke(context)
        sys.stdout.flush()
        return result if isinstance(result, int) else DONE
    except click.exceptions.Exit as ended:
        return ended.exit_code
    except (KeyboardInterrupt, click.Abort):
        _print_error("")
        return INTERRUPTED
    except BrokenPipeError:
        # The reader of stdout has closed it: no error, not at exit either.
        _discard_output()
        return DONE
    except click.ClickException as error:
        _print_error(_usage(error))
        return USAGE
    except Exception as error:  # a MikasError or a bug
        return _failed(error, verbose=any(word in ("-v", "-vv", "--verbose") for word in argv))


def _print_error(text: str) -> None:
    try:
        sys.stdout.flush()
        sys.stderr.write(f"{text}\n")
        sys.stderr.flush()
    except BrokenPipeError:
        _discard_output()


def _discard_output() -> None:
    for stream in (sys.stdout, sys.stderr):
        try:
            stream.flush()
        except BrokenPipeError:
            os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


def _usage(error: click.ClickException) -> str:
    """Return the message for wrong usage, with the command for help."""
    context = getattr(error, "ctx", None)
    path = context.command_path if context else "mikas"
    message = _message(error)
    message = message if message.endswith((".", "?")) else f"{message}."
    return f"{message} {tr(f'Help: {path} --help', f'Справка: {path} --help')}"


def _message(error: click.ClickException) -> str:
    context = getattr(error, "ctx", None)
    match error:
        case click.NoSuchOption():
            problem = tr(
                f"There is no option {error.option_name}.", f"Ключа {error.option_name} нет."
            )
            nearest = ", ".join(error.possibilities or ())
            hint = tr(f" Did you mean {nearest}?", f" Может быть, {nearest}?")
            return problem + (hint if nearest else "")
        case click.MissingParameter():
            name = _name(error.param)
            return tr(f"{name} is missing.", f"Не указано: {name}.")
        case click.BadParameter():
            return f"{_name(error.param)}: {error.message}"
        case click.BadOptionUsage():
            name = error.option_name
            if _is_flag(name, context):
                return tr(f"{name} takes no value.", f"Ключ {name} не принимает значения.")
            return tr(f"{name} requires a value.", f"После {name} нужно значение.")
    return error.format_message()


def _name(parameter: click.Parameter | None) -> str:
    """Return the parameter as the user writes it: `--out`, `FILE`."""
    if isinstance(parameter, click.Option):
        return max(parameter.opts, key=len)
    metavar = (parameter.metavar if isinstance(parameter, click.Argument) else None) or ""
    return metavar.strip("[].")


def _is_flag(name: str, context: click.Context | None) -> bool:
    parameters = context.command.params if context else []
    return any(
        name in (*p.opts, *p.secondary_opts) and getattr(p, "is_flag", False) for p in parameters
    )


def _failed(error: Exception, *, verbose: bool) -> int:
    from mikas.errors import (
        EcuRefused,
        LineError,
        MikasError,
        NoConnection,
        NotConfirmed,
        UsageError,
    )

    if not isinstance(error, MikasError):
        kind = f"{type(error).__name__}: {error}"
        _print_error(
            tr(
                f"This is a bug in mikas ({kind}). Please report it with the output of the same "
                "command with -v.",
                f"Это ошибка в программе mikas ({kind}). Сообщите о ней, приложив вывод той же "
                "команды с ключом -v.",
            )
        )
        if verbose:
            import traceback

            traceback.print_exception(error)
        return BUG
    from mikas.cli.advice import ADVICE

    text = localized(ADVICE.text(error))
    ours = error.what.en.startswith("{problem}") or not error.what.en.startswith("{")
    if ours and re.match(r"[^\W\d_]+[ ,]", text):  # a word, not a file's name or a value
        text = capital(text)
    _print_error(text)
    if verbose and error.__cause__:
        _print_error(
            f"  ({type(error).__name__} ← {type(error.__cause__).__name__}: {error.__cause__})"
        )
    for tree, status in (
        (UsageError, USAGE),
        (NoConnection, NO_CONNECTION),
        (LineError, LINE),
        (EcuRefused, REFUSED),
        (NotConfirmed, NOT_CONFIRMED),
    ):
        if isinstance(error, tree):
            return status
    return BUG
