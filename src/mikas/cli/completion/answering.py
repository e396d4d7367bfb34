"""The answer to a shell that completes a line (the package's docstring has the form)."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import redirect_stderr, suppress
from io import StringIO
from typing import Final

import click
from click.shell_completion import CompletionItem, ShellComplete, split_arg_string

from mikas.cli.completion.scripts import script
from mikas.cli.language import detect_language, set_language
from mikas.cli.render.terminal import write_machine

VARIABLE: Final = "_MIKAS_COMPLETE"


def is_asked() -> bool:
    """Return whether a shell asks for completion, or for its script."""
    return VARIABLE in os.environ


def answer(cli: click.Command) -> int:
    """Print what the shell asks for; return the exit status. An error completes nothing."""
    shell, _, action = os.environ[VARIABLE].partition("_")
    # PowerShell reads UTF-8 here, whatever the console's own encoding is.
    encoding = "utf-8" if shell == "powershell" else None
    with suppress(Exception), redirect_stderr(StringIO()):
        if action == "source":
            write_machine(script(shell), encoding)
            return 0
        if action == "complete":
            offers = "".join(f"{line}\n" for line in _offers(cli, _words(shell)))
            write_machine(offers, encoding)
            return 0
    return 1


def _words(shell: str) -> list[str]:
    """Return the words of the line up to the cursor; the last one, maybe empty, is incomplete."""
    if shell == "bash":
        line = os.environ["COMP_LINE"]
        words = split_arg_string(line)
        return words if len(split_arg_string(f"{line}x")) == len(words) else [*words, ""]
    *words, last = os.environ["COMP_WORDS"].split("\n")
    if shell == "fish":  # the last one as it is written
        last = "".join(split_arg_string(last))
    return [*words, last]


def _offers(cli: click.Command, words: list[str]) -> Iterator[str]:
    given, word = words[1:-1], words[-1]
    set_language(detect_language(given))
    # click leaves the option of `--port=COM3` out of the values.
    begin = word[: word.find("=") + 1] if word.startswith("-") and "--" not in given else ""
    yield f"word\t{word}"
    for it in ShellComplete(cli, {}, "mikas", VARIABLE).get_completions(given, word):
        yield _line(it, begin)


def _line(item: CompletionItem, begin: str) -> str:
    if item.type in ("file", "dir"):  # the value: endings of names; the rest: what is before a name
        return f"{item.type}\t{item.value}\t{begin}{item.begin or ''}"
    return f"{item.type}\t{begin}{item.value}\t{item.help or ''}"
