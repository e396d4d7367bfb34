"""`mikas`: the entry point; an error ends it with a message and a status.

Nothing heavy is imported here: `mikas --help` must appear at once.
"""

from __future__ import annotations

import gc
import itertools
import os
import sys
from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import Final

import click

from mikas import unkept
from mikas.cli import completion, desktop
from mikas.cli.click_extensions import LocalizedGroup
from mikas.cli.commands import COMMANDS, TITLES
from mikas.cli.failures import BUG, DONE, INTERRUPTED, failure_of
from mikas.cli.given_secrets import hider_of
from mikas.cli.language import detect_language, localized, set_language
from mikas.cli.options.common import LocalizedOption
from mikas.cli.render import terminal
from mikas.errors import MikasError
from mikas.i18n import Text

_OBJECTS_BEFORE_COLLECTION = 50_000
"""Python's own 700 traverses the imported modules over and over: 4 % of the start of `dash`."""


def _version(ctx: click.Context, _: click.Parameter, value: bool) -> None:
    if value and not ctx.resilient_parsing:
        import mikas

        terminal.write_out(f"mikas {mikas.__version__}\n")
        ctx.exit()


cli: Final = LocalizedGroup(
    "mikas",
    homes=COMMANDS,
    titles=TITLES,
    en="Diagnostics for the Mikas 5.4 and 7.1 engine control units over K-Line. "
    "No cable at hand? Try: mikas demo",
    ru="Диагностика блоков управления Микас 5.4 и 7.1 по K-Line. "
    "Нет кабеля под рукой? Попробуйте: mikas demo",
    examples=("mikas doctor", "mikas read TWAT FREQ", "mikas watch --port sim:"),
    params=[
        LocalizedOption(
            ["--version"],
            is_flag=True,
            is_eager=True,
            expose_value=False,
            callback=_version,
            en="show the version",
            ru="показать версию программы",
        ),
    ],
)


def main(argv: Sequence[str] | None = None) -> None:
    """Run the `mikas` command and end the process with the status of docs/reference/cli.md."""
    gc.set_threshold(_OBJECTS_BEFORE_COLLECTION)
    # numpy's linear algebra is not used. Its threads would be started all the same, in each worker
    # too, and where the system allows no further ones it writes to the terminal.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    terminal.make_writable()
    sys.exit(run(sys.argv[1:] if argv is None else list(argv)))


def desktop_main() -> None:
    """Run `mikas dash --desktop` with the arguments of this process, as `mikas-dashboard`."""
    main(["dash", desktop.FLAG, *sys.argv[1:]])


def run(argv: list[str]) -> int:
    """Run one command line; return the exit status."""
    hide = hider_of(argv)
    with terminal.escaping(hide), unkept.said_to(_say):
        return _run(argv, hide)


def _say(sentence: Text) -> None:
    with suppress(OSError, ValueError):  # a broken stderr ends no work
        terminal.write_above(terminal.cell_text(localized(sentence)))


def _run(argv: list[str], hide: Callable[[str], str]) -> int:
    try:
        set_language(detect_language(argv))
        if completion.is_asked():
            return completion.answer(cli)
        # `cli.main` would end the process when a pipe's reader is gone. click empties the list.
        with cli.make_context("mikas", [*argv]) as context:
            result = cli.invoke(context)
        terminal.flush_out()
        return result if isinstance(result, int) else DONE
    except click.exceptions.Exit as ended:
        return ended.exit_code
    except (KeyboardInterrupt, click.Abort):  # the user's wish, so no error
        _print_error("")
        return INTERRUPTED
    except MikasError as error:  # of a connection or a file; it may be a BrokenPipeError as well
        return _failed(error, argv, hide)
    except BrokenPipeError:
        # The reader of stdout has closed it: no error, not at exit either.
        terminal.discard_output()
        return DONE
    except Exception as error:  # of mikas or click, or a bug
        return _failed(error, argv, hide)


def _failed(error: Exception, argv: list[str], hide: Callable[[str], str]) -> int:
    """Report `error` without the secrets that `hide` leaves out; return the exit status.

    Stderr hides them by itself.
    """
    failure = failure_of(error).changed(hide)
    if isinstance(error, terminal.OutputError):
        terminal.discard_output()
        _print_error(failure.text)
    elif "--json" in itertools.takewhile(lambda word: word != "--", argv):
        from mikas.cli.render.output import Output

        try:
            Output(json=True).data(failure.as_json())
        except BrokenPipeError:
            pass
        except terminal.OutputError as unwritten:
            return _failed(unwritten, argv, hide)
    else:
        # A paragraph, whatever lines a file's name has.
        _print_error(terminal.cell_text(failure.text), terminal.write_note)
    if desktop.FLAG in argv:
        details = hide(_traceback(error)) if failure.status == BUG else ""
        desktop.show_failure(failure.text, details)
    if any(word in ("-v", "-vv", "--verbose") for word in argv):
        if failure.status == BUG:
            _print_error(_traceback(error))
        elif cause := error.__cause__:
            _print_error(f"  ({type(error).__name__} ← {type(cause).__name__}: {cause})")
    return failure.status


def _write_line(text: str) -> None:
    terminal.write_error(f"{text}\n")


def _traceback(error: Exception) -> str:
    import traceback

    return "".join(traceback.format_exception(error)).rstrip("\n")


def _print_error(text: str, write: Callable[[str], None] = _write_line) -> None:
    try:
        terminal.flush_out()
        write(text)
    except (BrokenPipeError, terminal.OutputError):
        terminal.discard_output()
