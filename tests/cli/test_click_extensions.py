"""Help in both languages, its examples, and how little has to be loaded to show it."""

from __future__ import annotations

import json
import re
import shlex
import subprocess
import sys
from pathlib import Path

import click
import pytest
from cli_harness import is_russian

from mikas.catalog import shipped
from mikas.cli.commands.recordings.causes import COMPLAINTS
from mikas.cli.main import cli
from mikas.client import METHODS
from mikas.virtual.fault_injector import LineFault


def commands(group: click.Group = cli, path: tuple[str, ...] = ()):
    """Every command with the words that call it."""
    yield path, group
    context = click.Context(group)
    for name in group.list_commands(context):
        command = group.get_command(context, name)
        if isinstance(command, click.Group):
            yield from commands(command, (*path, name))
        else:
            yield (*path, name), command


ALL = list(commands())
ROOT = Path(__file__).parents[2]


@pytest.mark.parametrize(("path", "command"), ALL, ids=[" ".join(p) or "mikas" for p, _ in ALL])
def test_help_has_examples_is_in_both_languages_and_fits_80_columns(mikas, path, command):
    english = mikas(*path, "--help")
    assert (english.status, english.err) == (0, "")
    assert english.out.startswith(f"Usage: {' '.join(('mikas', *path))} [OPTIONS]")
    assert "Examples:" in english.out
    assert not re.search("[а-яА-Я]", english.out)
    assert max(map(len, english.lines)) <= 80 or "--line-fault" in english.out
    for option in ("--port", "--echo", "--timeout", "--inter-byte", "--pause", "--retries",
                   "--checksum", "--strict", "--capture", "--interpretation", "--lang", "--json",
                   "--verbose"):  # fmt: skip
        assert option in english.out

    russian = mikas("--lang", "ru", *path, "--help")
    assert mikas(*path, "--help", "--lang", "ru").out == russian.out
    assert "Примеры:" in russian.out
    head, _, examples = russian.out.partition("Примеры:")
    assert examples == english.out.partition("Examples:")[2]
    is_russian(head, names=(*path, *names(command)))


@pytest.mark.parametrize("page", ["docs/reference/cli.md", "docs/ru/reference/cli.md"])
@pytest.mark.parametrize(("path", "command"), ALL, ids=[" ".join(p) or "mikas" for p, _ in ALL])
def test_each_option_stands_on_the_page_of_the_command_line(path, command, page):
    named = set(re.findall(r"(?<![\w-])--?[a-z][a-z0-9-]*", (ROOT / page).read_text("utf-8")))
    options = [each for each in command.params if isinstance(each, click.Option)]
    missing = [each.opts for each in options if not named & {*each.opts, *each.secondary_opts}]
    assert not missing, f"{page} does not name these options of `{' '.join(('mikas', *path))}`"


def names(command: click.Command):
    """Words that are the same in every language: options, their values, commands."""
    yield from (
        "stderr",
        "pty",
        *METHODS,
        *(line_fault.value for line_fault in LineFault),
        "missing",
        *("mergecap", "cat"),
        "stroke",
        *("ram", "xram", "code", "sfr"),
        "healthy",
        *COMPLAINTS,
    )
    yield from getattr(command, "homes", ())
    for parameter in command.params:
        yield from (opt.lstrip("-") for opt in parameter.opts)
        yield from re.findall(r"[\w.-]+", parameter.metavar or "")


def test_the_contract_s_commands_are_all_there():
    paths = {" ".join(path) for path, _ in ALL}
    assert {
        "ports", "doctor", "info", "params", "read", "scan", "watch", "log", "faults", "write",
        "list set", "list read", "mem read", "mem write", "mem dump", "mem verify", "mem diff",
        "mem restore", "mem goto", "raw", "decode", "export", "find", "split", "test", "sim",
        "dash", "demo", "survey", "report", "causes", "help", "completion",
    } <= paths  # fmt: skip


EXAMPLES = [example for _, command in ALL for example in command.examples]


@pytest.mark.parametrize("example", EXAMPLES)
def test_every_example_parses(mikas, tmp_path, example):
    for name in (
        "drive.pcapng",
        "merged.pcapng",
        "monday.pcapng",
        "tuesday.pcapng",
        "code.bin",
        "part.bin",
        "xram.bin",
        "before.bin",
        "after.bin",
        "a.bin",
        "b.bin",
    ):
        (tmp_path / name).touch()
    program, *argv = shlex.split(example)
    if ">" in argv:  # the shell's
        argv = argv[: argv.index(">")]
    assert program == "mikas"
    parse(cli, "mikas", argv)


def parse(command: click.Command, name: str, argv: list[str], parent=None) -> None:
    with command.make_context(name, argv, parent=parent) as context:
        if isinstance(command, click.Group):
            rest = [*context._protected_args, *context.args]  # noqa: SLF001
            found, inner, left = command.resolve_command(context, rest)
            parse(inner, found, left, context)


def test_without_a_command_the_help_is_shown(mikas):
    ran = mikas()
    assert (ran.status, ran.out) == (2, "")
    assert "Commands:" in ran.err


def test_version_prints_the_packages_version(mikas):
    import mikas as package

    assert mikas("--version").out == f"mikas {package.__version__}\n"


@pytest.mark.parametrize(
    "argv", [["--help"], ["--lang", "ru", "--help"], ["nosuch"], ["--version"]]
)
def test_help_loads_nothing_heavy(tmp_path, argv):
    program = (
        "import json, sys\n"
        "from mikas.cli.main import run\n"
        f"status = run({argv!r})\n"
        "print(json.dumps(sorted(sys.modules)))\n"
    )
    environment = {"HOME": str(tmp_path), "MIKAS_CONFIG": str(tmp_path / "none.toml"), "PATH": ""}
    if sys.platform == "win32":
        import os

        environment |= {"SYSTEMROOT": os.environ["SYSTEMROOT"]}
    ran = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, encoding="utf-8",
        env=environment, check=True,
    )  # fmt: skip
    loaded = set(json.loads(ran.stdout.splitlines()[-1]))
    heavy = {"mikas.catalog", "mikas.client", "mikas.link", "serial", "rich", "asyncio", "numpy",
             "tomllib", "platformdirs"}  # fmt: skip
    assert not loaded & heavy


_TAKE_NAMES = {"demo", "log", "watch"}


def test_the_names_in_the_examples_exist():
    named = set()
    for path, command in ALL:
        for example in (
            getattr(command, "examples", ()) if _TAKE_NAMES.intersection(path[-1:]) else ()
        ):
            named |= set(re.findall(r"(?<= )[A-Z][A-Z_]+(?=/|\s|$)", example))
    assert {"FREQ", "FUEL_FLOW"} <= named
    for name in named:
        shipped().channel(name)
