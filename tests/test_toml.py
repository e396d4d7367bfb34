"""TOML files of the user: what is refused before the parser sees it, and what is not."""

from __future__ import annotations

import os
import re
import tomllib
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mikas import toml
from mikas.catalog.loading.source import read_source
from mikas.errors import CatalogError
from mikas.toml import TomlError, parse

SHIPPED = [*(Path(toml.__file__).parent).rglob("*.toml")]


@pytest.mark.parametrize(
    ("text", "line", "problem"),
    [
        ("\n\n" + ".".join("a" * 20_000) + " = 1", 3, "16 parts"),
        ("# a\n[" + " . ".join("a" * 20_000) + "]", 2, "16 parts"),
        ("[a]\nx = { " + ".".join("a" * 17) + " = 1 }", 2, "16 parts"),
        ("a = \n" + "[" * 200_000, 2, "32 levels"),
        ("a = " + "{ a = " * 33, 1, "32 levels"),
        ("a = " + "[[{a=" * 400, 1, "32 levels"),
        ("a = 0x" + "f" * 200, 1, "longer than 200"),
        ("a = 1." + "9" * 500_000, 1, "longer than 200"),
        ("a" * 201 + " = 1", 1, "longer than 200"),
        ('\n"' + "a" * 201 + '" = 1', 2, "longer than 200"),
        ("'" + "a" * 201 + "'.b = 1", 1, "longer than 200"),
        ('x = """\n"""\n["' + "a" * 201 + '"]', 3, "longer than 200"),
        ('x = [1]\n[a."' + "a" * 201 + '"]', 2, "longer than 200"),
        ("\n".join(f"k{n} = 1" for n in range(2001)), 2001, "20000 names"),
        ("[[a]]\n" * 2001, 2001, "20000 names"),
        ("x = [" + "1," * 5000 + "]", 1, "200000 values"),
    ],
)
def test_what_is_too_large_never_reaches_the_parser(
    text: str, line: int, problem: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delattr(tomllib, "loads")
    monkeypatch.setattr(toml, "MOST_KEYS", 2000)
    monkeypatch.setattr(toml, "MOST_VALUES", 5000)
    with pytest.raises(TomlError, match=problem) as caught:
        parse(text)
    assert caught.value.line == line
    assert re.search("[А-яЁё]", caught.value.problem.ru)


@pytest.mark.parametrize(
    "text",
    [
        "a = " + "[" * 32 + "]" * 32,
        ".".join("a" * 16) + " = 1",
        f"{'a' * 200} = 1",
        f'a = "{"x" * 100_000}"',
        f"a = ['{'x' * 100_000}']",
        f"a = '''{'[' * 100}{'a.' * 100}'''",
        f'a = """{"[" * 100}{"a." * 100}"""',
        f"a = '{'[' * 100}{'a.' * 100}' # {'[' * 100}{'a.' * 100}",
        "a = [1.5, 2.5,\n" + "1.5, " * 100 + "]",
        "a = [[1]]\n" + "\n".join(f"[t{n}]\nx.y = 1" for n in range(100)),
    ],
)
def test_what_is_not_too_large_is_parsed_as_by_tomllib(text: str) -> None:
    assert parse(text) == tomllib.loads(text)


def test_the_shipped_files_are_far_below_the_bounds() -> None:
    assert len(SHIPPED) > 12
    for file in SHIPPED:
        data = toml.read_bytes(file)
        assert parse(toml.text_of(data)) == tomllib.loads(data.decode())


@pytest.mark.parametrize(
    "unclosed", ['"""\\"', '"\\"', "'''a", '"', "'", "\\", '"""\\', '\\\n"', "''' \"\"\"", "#", "."]
)
def test_the_check_looks_at_each_character_once(unclosed: str) -> None:
    """Every token that begins is taken, so what is searched never overlaps."""
    text = unclosed * 3000
    end = 0
    for match in toml._TOKEN.finditer(text):  # noqa: SLF001
        assert match.start() >= end
        assert not set(text[end : match.start()]) & set("[]{}=,.\n\"'#")
        assert match.end() > match.start()
        end = match.end()
    assert not set(text[end:]) & set("[]{}=,.\n\"'#")


@settings(max_examples=50)
@given(st.lists(st.sampled_from([*"[]{}=.,\n\"'#\\ab1 ", '"""', "'''"]), max_size=30))
def test_the_check_refuses_no_small_file(parts: list[str]) -> None:
    """Whatever brackets, quotes and comments do: it is the parser that says what TOML is."""
    text = "".join(parts)
    try:
        expected = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        with pytest.raises(TomlError) as caught:
            parse(text)
        assert str(error) in caught.value.problem.en
    else:
        assert parse(text) == expected


def test_a_file_of_more_than_a_megabyte_is_not_read(tmp_path: Path) -> None:
    file = tmp_path / "own.toml"
    with file.open("wb") as out:
        out.truncate(1 << 40)  # a terabyte, with no block on the disk
    with pytest.raises(CatalogError, match="larger than 1024 KB"):
        read_source(file)


@pytest.mark.posix
def test_a_pipe_or_a_device_is_no_catalog(tmp_path: Path) -> None:
    pipe, link = tmp_path / "pipe.toml", tmp_path / "link.toml"
    os.mkfifo(pipe)
    link.symlink_to("/dev/zero")
    for file in (pipe, link, Path("/dev/zero")):
        with pytest.raises(CatalogError, match="a pipe or a device; only a file") as caught:
            read_source(file)
        assert (caught.value.file, caught.value.line) == (str(file), 0)
    with pytest.raises(CatalogError, match="a folder"):
        read_source(tmp_path)
    (tmp_path / "file.toml").write_text('version = "1"')
    link.unlink()
    link.symlink_to("file.toml")  # the user named it, so it is meant
    assert read_source(link).tables == {"version": "1"}
