"""Each rule of `python -m tools.docs.check` finds what it is for."""

from __future__ import annotations

from pathlib import PurePosixPath

import pytest
from tools.docs.checking import built, examples, links, named, sessions, structure
from tools.docs.checking.virtual_unit import as_written, on_virtual_unit
from tools.docs.markdown import Code

import mikas
from mikas.cli.language import set_language
from tools.docs import pages

OURS = PurePosixPath("docs/ours.md")


@pytest.fixture
def repository(tmp_path, monkeypatch):
    """Write files into a repository of the test's own."""
    for module in (pages, links, named, structure):
        monkeypatch.setattr(module, "ROOT", tmp_path, raising=False)
    for cache in (pages.document, named.exists_in_repository):
        cache.cache_clear()

    def write(files):
        for name, text in files.items():
            (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
            (tmp_path / name).write_text(text, "utf-8")
        return tmp_path

    yield write
    pages.document.cache_clear()
    named.exists_in_repository.cache_clear()


def told(findings):
    return [(each.line, each.text) for each in findings]


def test_links_that_lead_nowhere_are_reported(repository):
    repository(
        {
            "docs/ours.md": "[a](there.md#one)\n[b](there.md#two)\n[c](gone.md)\n[d](#e)\n"
            "[f](https://g)\n[h](https://i.example/j)\n[k](../../l.md)\n[m](../src/)",
            "docs/there.md": "# One\n",
            "src/n.py": "",
        }
    )
    assert told(links.findings(OURS)) == [
        (2, "there.md#two: no such heading"),
        (3, "gone.md: no such file"),
        (4, "#e: no such heading"),
        (5, "https://g: no valid address"),
        (7, "../../l.md: ../../l.md leads out of the repository"),
    ]


def test_paths_and_names_that_do_not_exist_are_reported(repository):
    repository(
        {
            "docs/ours.md": "`src/n.py` `src/o.py` `src/NAME/p.py`\n`mikas read`, mikas.Ecu.read\n"
            "mikas.Ecu.guess",
            "src/n.py": "",
        }
    )
    assert told(named.findings(OURS)) == [
        (1, "src/o.py: no such file"),
        (3, "mikas.Ecu.guess: no such name"),
    ]


def test_files_of_another_release_are_reported(repository):
    repository({"docs/ours.md": f"`mikas-{mikas.__version__}.tar.gz` mikas_0.0.9_amd64.deb\n"})
    assert told(named.findings(OURS)) == [(1, f"0.0.9: the version is {mikas.__version__}")]


ENGLISH = """\
# Page
[a](other.md#second) ![p](pictures/en/p.png)
```console
$ mikas read  # all of them
TWAT
```
```python
b.read("A")  # once
print("no answer", b.text.en)
```
## More
"""
RUSSIAN = """\
# Страница
[а](other.md#второй) ![п](../pictures/ru/p.png)
```console
$ mikas read --lang ru  # все
ТОЖ
```
```python
b.read("A")  # раз
print("нет ответа", b.text.ru)
```
## Ещё
"""


def translated(repository, russian):
    repository(
        {
            "docs/ours.md": ENGLISH,
            "docs/other.md": "# First\n## Second\n",
            "docs/ru/ours.md": russian,
            "docs/ru/other.md": "# Первый\n## Второй\n",
        }
    )
    return [
        each.text.split(":")[0]
        for each in structure.translated(OURS, PurePosixPath("docs/ru/ours.md"))
    ]


@pytest.mark.parametrize(
    ("change", "found"),
    [
        (("", ""), []),
        (("## Ещё", "### Ещё"), ["headings"]),
        (("mikas read", "mikas info"), ["code"]),
        (("```console", "```text"), ["code"]),
        (('b.read("A")  # раз', 'b.read("B")'), ["code"]),
        (("нет ответа", "другой текст"), []),
        (("p.png", "q.png"), ["pictures"]),
        (("#второй", "#первый"), ["links"]),
        (("[а](other.md#второй) ", ""), ["links"]),
    ],
)
def test_a_translation_is_built_like_the_original(repository, change, found):
    assert translated(repository, RUSSIAN.replace(*change)) == found


def test_a_session_and_a_list_are_split_into_steps():
    session = "$ mikas read \\\n    TWAT\na\n…\n$ ls\n"
    assert [(step.command, step.shown, step.ours) for step in sessions.steps(session)] == [
        ("mikas read TWAT", ("a", "…"), True),
        ("ls", (), False),
    ]
    listed = "# first\nmikas ports  # a cable?\nMIKAS_PORT=sim: mikas dash\n"
    assert [step.words for step in sessions.steps(listed)] == [
        ["mikas", "ports"],
        ["mikas", "dash"],
    ]


@pytest.mark.parametrize(
    ("command", "ends"),
    [
        ("mikas log -o a.pcapng FREQ", False),
        ("mikas --lang ru watch FREQ", False),
        ("mikas watch FREQ --count 3", True),
        ("mikas log -o a.pcapng --duration 5", True),
        ("mikas read FREQ", True),
        ("mikas dash", False),
    ],
)
def test_what_does_not_end_by_itself_is_not_run(command, ends):
    assert sessions.Step(command, (), 0, session=True).ends is ends


@pytest.mark.parametrize(
    ("shown", "printed", "same"),
    [
        (["a", "b"], ["a", "b"], True),
        (["a"], ["a", "b"], False),
        (["a", "…"], ["a", "b", "c"], True),
        (["a", "…"], ["a"], True),
        (["…", "c"], ["a", "b", "c"], True),
        (["a … c"], ["a b c"], True),
        (["a … d"], ["a b c"], False),
        (["a.c"], ["abc"], False),
    ],
)
def test_an_ellipsis_stands_for_anything(shown, printed, same):
    assert sessions.matches(shown, printed) is same


@pytest.mark.posix  # by a shell
def test_other_programs_are_run_where_they_are_installed(tmp_path, monkeypatch):
    assert console("$ tshark -r absent.pcapng\n", "console no-run") == []
    program = tmp_path / "tshark"
    program.write_text("#!/bin/sh\necho read $2; exit $1\n")
    program.chmod(0o755)
    monkeypatch.setenv("PATH", f"{tmp_path}:/usr/bin:/bin")
    monkeypatch.chdir(tmp_path)
    assert console("$ tshark 0 a\nread a\n$ ls absent\n") == []
    assert console("$ tshark 0 a\nread b\n") == ["tshark 0 a: prints something else:"]
    assert console("$ tshark 2 a\n") == ["tshark 2 a: status 2: read a"]


def console(text, info="console"):
    return [problem.split("\n")[0] for _, problem in sessions.problems(Code(info, text, 1))]


@pytest.mark.parametrize(
    ("command", "found"),
    [
        ("mikas read TWAT", ""),
        ("mikas read TWAT | grep °C > file", ""),
        ("mikas decode not-here.pcapng", ""),
        ("mikas dash --host-port 8071", ""),
        ("mikas raed", "“raed”"),
        ("mikas read --fast", "No such option"),
        ("mikas mem read", "Missing argument"),
    ],
)
def test_a_command_is_one_of_ours_even_where_it_is_not_run(command, found):
    set_language("ru")  # as a test before this one may have left it
    problems = console(command) + console(f"$ {command}\n", "console no-run")
    assert len(problems) == 2 * bool(found)
    assert all(found in problem for problem in problems)


def ran(repository, text):
    repository({"docs/ours.md": text, "drive.pcapng": "none"})
    return told(examples.findings(OURS, pages.ROOT / "drive.pcapng"))


@pytest.mark.posix  # an alarm clock for each block
def test_a_session_prints_what_it_shows(repository):
    good = "```console\n$ mikas read TWAT --port /dev/ttyUSB0\nTWAT  86 °C\n```\n"
    ((line, problem),) = ran(repository, good.replace("86 °C", "85 °C … reading"))
    assert (line, problem.split(":")[1].strip()) == (2, "prints something else")


@pytest.mark.posix  # an alarm clock for each block
def test_python_is_run_and_json_and_toml_are_read(repository):
    text = (
        '```python\nimport mikas\n\nwith mikas.connect("COM3") as ecu:\n    '
        'assert ecu.read("TWAT")["TWAT"].value == 86\n```\n'
        "```python\nname = ecu.model.text.en\nassert name == 1\n```\n"
        "```python no-run\nwhile True: pass\n```\n"
        "```python\nfor\n```\n"
        '```json\n{"a": 1,}\n```\n```json\n{"a": …}\n```\n'
        "```toml\na = \n```\n"
    )
    problems = ran(repository, text)
    assert [line for line, _ in problems] == [9, 15, 18, 23]
    assert problems[0][1] == "AssertionError: "


def test_commands_stand_in_a_block_that_is_checked(repository):
    text = "```\nmikas raed\n```\n\n    tshark -r a\n\n```text\nmikas says\n```\n\n    TWAT 86\n"
    problem = "commands without ```console: they are not checked"
    assert ran(repository, text) == [(1, problem), (5, problem)]


@pytest.mark.posix  # an alarm clock for each block
def test_sql_is_run(repository):
    text = "```sql\n-- one\nSELECT 1;\nSELECT nothing;\n```\n"
    ((line, problem),) = ran(repository, text)
    assert line == 4
    assert "nothing" in problem


def test_ports_become_the_virtual_unit():
    for written, port in (
        ("mikas read --port COM3 TWAT", "mikas read --port sim:?clock=simulated TWAT"),
        ('"sim:"', '"sim:?clock=simulated"'),
        ("sim:?seed=1", "sim:?clock=simulated&seed=1"),
        ("sim:?seed=1&clock=simulated", "sim:?seed=1&clock=simulated"),
    ):
        assert on_virtual_unit(written) == port
    assert as_written("at sim:?clock=simulated&seed=1") == "at sim:?seed=1"


def test_wrong_links_of_the_built_site_are_reported(tmp_path):
    (tmp_path / "en").mkdir()
    (tmp_path / "en" / "a.html").write_text(
        '<a href="b.html#one">\n<a href="b.html#two">\n<img src="c.png">\n<a href="/b.html">'
        '<a href="../../d.html"><a href="https://e.example/f"><a href="#top"><p id="top">'
    )
    (tmp_path / "en" / "b.html").write_text('<h1 id="one">')
    assert told(built.findings(tmp_path)) == [
        (2, "b.html#two: no such anchor"),
        (3, "c.png: no such file"),
        (4, "/b.html: does not work below another address"),
        (4, "../../d.html: leads out of the site"),
    ]
