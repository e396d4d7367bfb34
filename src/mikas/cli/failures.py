"""The end of a command by an error: status, and paragraph or JSON (docs/reference/cli.md).

A `FailureReport` is made of an error of mikas, a wrong command line (click's errors), or a bug.
Nothing heavy is imported here.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, replace

import click

from mikas import errors
from mikas.cli.language import capital, localized, tr
from mikas.cli.render.terminal import OutputError
from mikas.json_values import picked

DONE, BUG, USAGE, NO_CONNECTION, LINE, REFUSED, NOT_CONFIRMED = range(7)
INTERRUPTED = 130
_IMPORTING = "<frozen importlib._bootstrap_external>"


@dataclass(frozen=True, slots=True)
class FailureReport:
    """`status`: of the process. `text`: all of it as a paragraph for a person."""

    status: int
    code: str
    message: str
    text: str
    advice: tuple[str, ...] = ()
    sent: bytes | None = None
    received: bytes | None = None

    def changed(self, change: Callable[[str], str]) -> FailureReport:
        """Return the same with other texts."""
        advice = tuple(map(change, self.advice))
        return replace(self, message=change(self.message), text=change(self.text), advice=advice)

    def as_json(self) -> dict[str, object]:
        """Return `{"error": {"code", "message", "sent", "received", "advice"}}`."""
        return {"error": picked(self, "code", "message", "sent", "received", "advice")}


def failure_of(error: Exception) -> FailureReport:
    """Describe `error`; an error of neither mikas nor click is a bug."""
    if isinstance(error, errors.MikasError):
        return _expected(error)
    if isinstance(error, click.ClickException):
        return _wrong_command_line(error)
    if isinstance(error, OutputError):
        reason = localized(errors.reason_of(error))
        message = tr(f"The output can't be written: {reason}.", f"Вывод не записать: {reason}.")
        return FailureReport(USAGE, "OutputError", message, message)
    if (refusal := errors.refusal_of(error)) is not None:
        message = f"{capital(localized(refusal))}."
        return FailureReport(USAGE, "SystemRefused", message, message)
    if (compiled := _damaged_compiled_file(error)) is not None:
        message = tr(
            f"{compiled} is damaged, as after a full disk or a power cut.",
            f"{compiled}: файл повреждён, так бывает после нехватки места или отключения питания.",
        )
        advice = tr(
            "Delete this file, Python makes it anew; if that does not help, reinstall mikas.",
            "Удалите его, Python создаст новый; если не поможет, переустановите mikas.",
        )
        return FailureReport(USAGE, "DamagedFile", message, f"{message} {advice}", (advice,))
    kind = f"{type(error).__name__}: {error}"
    message = tr(f"This is a bug in mikas ({kind}).", f"Это ошибка в программе mikas ({kind}).")
    advice = tr(
        "Please report it with the output of the same command with -v.",
        "Сообщите о ней, приложив вывод той же команды с ключом -v.",
    )
    return FailureReport(BUG, "InternalError", message, f"{message} {advice}", (advice,))


def _damaged_compiled_file(error: Exception) -> str | None:
    """Return the compiled file of Python (.pyc) at whose import `error` was raised, or None."""
    if isinstance(error, ImportError):  # it holds no code; such an error has no frames of importlib
        return error.path if (error.path or "").endswith(".pyc") else None
    trace = error.__traceback__
    while trace is not None and trace.tb_next is not None:
        trace = trace.tb_next
    if trace is None or trace.tb_frame.f_code.co_filename != _IMPORTING:
        return None
    path = trace.tb_frame.f_locals.get("bytecode_path")
    return path if isinstance(path, str) else None


_STATUSES: tuple[tuple[type[errors.MikasError], int], ...] = (
    (errors.UsageError, USAGE),
    (errors.NoConnection, NO_CONNECTION),
    (errors.LineError, LINE),
    (errors.EcuRefused, REFUSED),
    (errors.NotConfirmed, NOT_CONFIRMED),
)


def _expected(error: errors.MikasError) -> FailureReport:
    from mikas.cli.advice import ADVICE

    text, message = localized(ADVICE.text(error)), localized(error.reason)
    ours = error.what.en.startswith("{problem}") or not error.what.en.startswith("{")
    if ours and re.match(r"[^\W\d_]+[ ,]", text):  # a word, not a file's name or a value
        text, message = capital(text), capital(message)
    return FailureReport(
        next((status for kind, status in _STATUSES if isinstance(error, kind)), BUG),
        type(error).__name__,
        message,
        text,
        tuple(localized(part) for part in ADVICE.parts(error)),
        error.request,
        error.received,
    )


def _wrong_command_line(error: click.ClickException) -> FailureReport:
    context = getattr(error, "ctx", None)
    path = context.command_path if context else "mikas"
    message = _message(error)
    message = message if message.endswith((".", "?")) else f"{message}."
    advice = [tr(f"Help: {path} --help", f"Справка: {path} --help")]
    examples = getattr(context and context.command, "examples", ())
    if examples and isinstance(error, click.MissingParameter):
        advice.insert(0, tr(f"For example: {examples[0]}.", f"Например: {examples[0]}."))
    return FailureReport(USAGE, "UsageError", message, " ".join([message, *advice]), (*advice,))


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
