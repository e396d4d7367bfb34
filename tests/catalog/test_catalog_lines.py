"""Lines of keys, in whatever shape valid TOML writes them."""

from __future__ import annotations

import json
import tomllib

from hypothesis import given
from hypothesis import strategies as st

from mikas.catalog.loading.source import lines_of

# each line with the paths that first appear on it
AWKWARD: list[tuple[str, list[str]]] = [
    ("# [not.a.table]", []),
    ('version = "[nor = this]" # x = 1', ["version"]),
    ('[parameter.TWAT] # "quotes and [brackets', ["parameter", "parameter/TWAT"]),
    ("code=0x1A", ["parameter/TWAT/code"]),
    (
        r""" "text" = { en = "a = {b}, \"c\"", 'ru' = 'it"s' } """,
        ["parameter/TWAT/text", "parameter/TWAT/text/en", "parameter/TWAT/text/ru"],
    ),
    ("long = '''", ["parameter/TWAT/long"]),
    ("[not.this]", []),
    ("code = 2'''", []),
    ("other = '''''two quotes more at both ends'''''", ["parameter/TWAT/other"]),
    ('rest = """', ["parameter/TWAT/rest"]),
    (r'x = "y" \""" = z', []),
    ('"""""', []),
    ("list = [ # a ] list", ["parameter/TWAT/list"]),
    ('  "a]", [1.5, 2e3], # ]', []),
    ("  {deep={er=1}}, {},", ["parameter/TWAT/list/deep", "parameter/TWAT/list/deep/er"]),
    ("  { again = 2, more = [{}] },", ["parameter/TWAT/list/again", "parameter/TWAT/list/more"]),
    ("]", []),
    ("after = 1979-05-27T07:32:00.5Z", ["parameter/TWAT/after"]),
    ("", []),
    ("""[ "parameter" . 'B.C' ]""", ["parameter/B.C"]),
    ("empty = {}", ["parameter/B.C/empty"]),
    (
        "a.b . c = -1_000",
        ["parameter/B.C/a", "parameter/B.C/a/b", "parameter/B.C/a/b/c"],
    ),
    ("[[many]]", ["many"]),
    ("first = true", ["many/first"]),
    ("[[many]]", []),
    ("second = []", ["many/second"]),
    (r'["\u0066ault".13]', ["fault", "fault/13"]),
    ('text.en = "x"', ["fault/13/text", "fault/13/text/en"]),
]


def test_lines_are_found_in_awkward_but_valid_files() -> None:
    text = "\n".join(line for line, _ in AWKWARD)
    tomllib.loads(text)
    assert lines_of(text) == {
        tuple(path.split("/")): number
        for number, (_, paths) in enumerate(AWKWARD, 1)
        for path in paths
    }


keys = st.text(st.characters(codec="utf-8", exclude_characters="\r"), max_size=6)
values = st.recursive(
    st.integers() | st.booleans() | st.text(st.characters(codec="utf-8"), max_size=8),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(keys, inner, max_size=3),
    max_leaves=8,
)


def quoted(text: str) -> str:
    return json.dumps(text).replace("\x7f", r"\u007F") if text.isascii() else escaped(text)


def escaped(text: str) -> str:
    return '"' + "".join(f"\\U{ord(letter):08X}" for letter in text) + '"'


def inline(value: object) -> str:
    if isinstance(value, dict):
        pairs = (f"{quoted(key)} = {inline(each)}" for key, each in value.items())
        return "{" + ", ".join(pairs) + "}"
    if isinstance(value, list):
        return "[" + "\n,".join(map(inline, value)) + "]"
    if isinstance(value, str):
        return quoted(value)
    return str(value).lower()


@given(st.dictionaries(keys, st.dictionaries(keys, values, max_size=4), max_size=4))
def test_lines_of_tables_and_keys_of_any_text_are_found(
    tables: dict[str, dict[str, object]],
) -> None:
    lines: list[str] = []
    expected: dict[tuple[str, ...], int] = {}
    for name, table in tables.items():
        expected[name,] = len(lines) + 1
        lines.append(f"[{quoted(name)}]")
        for key, value in table.items():
            expected[name, key] = len(lines) + 1
            lines += f"{quoted(key)} = {inline(value)}".split("\n")
    text = "\n".join(lines)
    assert tomllib.loads(text) == tables
    found = lines_of(text)
    assert {path: line for path, line in found.items() if len(path) <= 2} == expected
