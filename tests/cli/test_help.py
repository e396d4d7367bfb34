"""Help pages of whole words at any width, `-h`, and `mikas help`."""

from __future__ import annotations

import click
import pytest
from cli_harness import is_one_short_paragraph, is_russian

from mikas.cli.click_extensions import LocalizedGroup
from mikas.cli.main import cli
from tester.tester_rig import case


def paths(group=cli, path=()):
    yield path
    for name in group.homes:
        inner = group.get_command(click.Context(group), name)
        if isinstance(inner, LocalizedGroup):
            yield from paths(inner, (*path, name))
        else:
            yield (*path, name)


PATHS = list(paths())


@pytest.fixture
def page(mikas, monkeypatch):
    """Returns the lines of a help page on a terminal of `columns`."""

    def show(path, language, columns):
        monkeypatch.setenv("COLUMNS", str(columns))
        ran = mikas(*path, "--help", "--lang", language)
        assert (ran.status, ran.err) == (0, "")
        return ran.lines

    return show


@pytest.mark.parametrize("language", ["en", "ru"])
def test_no_word_is_broken_or_left_out_and_no_line_is_too_wide(page, language):
    for path in PATHS:
        narrow, usual, wide = (page(path, language, columns) for columns in (60, 80, 120))
        with case(path):
            # Where an example is continued, the shell's sign stands between its words.
            words = [[word for word in " ".join(lines).split() if word != "\\"]
                     for lines in (narrow, usual, wide)]  # fmt: skip
            assert words[0] == words[1] == words[2]
            assert max(map(len, narrow)) <= 60
            assert max(map(len, usual)) <= 80
            assert max(map(len, wide)) <= 120
            assert not any("..." in word for word in words[0] if not word.endswith("]...")
                           and word not in ("NAME...", "FOLDER...", "FILE..."))  # fmt: skip


def test_no_line_begins_with_a_dash(page):
    for path in PATHS:
        assert not [it for it in page(path, "ru", 60) if it.lstrip().startswith("— ")]


def test_a_continued_example_is_the_same_command_line(page):
    begin = page(("sim",), "en", 60).index("Examples:")
    written = "\n".join(page(("sim",), "en", 60)[begin:])
    assert " \\\n      --line-fault damaged=0.01" in written
    assert max(map(len, written.splitlines())) <= 58


@pytest.mark.parametrize("path", [(), ("mem",), ("list",), ("fleet",)])
def test_commands_stand_before_the_options(page, path):
    for language, commands, options in (
        ("en", "Commands:", "Options:"),
        ("ru", "Команды:", "Ключи:"),
    ):
        lines = page(path, language, 80)
        assert lines.index(commands) < lines.index(options)


def test_every_command_of_the_program_stands_under_a_title():
    titled = cli.listed()
    assert None not in dict(titled)
    assert [name.strip() for _, rows in titled for name, _ in rows] == list(cli.homes)
    assert len(titled) > 4


@pytest.mark.parametrize("path", PATHS, ids=" ".join)
def test_h_and_the_command_help_show_what_help_shows(mikas, path):
    said = mikas(*path, "--help").out
    assert mikas(*path, "-h").out == said
    assert mikas("help", *path).out == said
    russian = mikas(*path, "--help", "--lang", "ru").out
    assert mikas("--lang", "ru", "help", *path).out == russian != said


def test_help_names_the_nearest_of_an_unknown_command(mikas):
    for argv, nearest in (
        (("help", "raed"), "read"), (("help", "mem", "dumb"), "dump"),
        (("help", "nosuch"), "doctor"), (("help", "read", "TWAT"), "mikas read --help"),
    ):  # fmt: skip
        with case(argv):
            english, russian = mikas(*argv), mikas(*argv, "--lang", "ru")
            assert (english.status, english.out) == (2, "")
            assert nearest in english.err
            is_one_short_paragraph(english.err)
            is_russian(russian.err)


def test_help_of_an_action_is_that_of_its_command(mikas):
    assert mikas("help", "faults", "erase").out == mikas("faults", "--help").out


def test_help_as_json_is_one_object(mikas):
    ran = mikas("help", "mem", "dump", "--json")
    assert ran.object["command"] == "mikas mem dump"
    assert ran.object["help"] == mikas("mem", "dump", "-h").out.rstrip("\n")
