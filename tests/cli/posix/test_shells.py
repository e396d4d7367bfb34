"""The Tab key in real shells: what a line becomes, and what is shown."""

from __future__ import annotations

import os
import shutil
import subprocess

import pytest
from shell_rig import ROOT, Shell, program

from mikas.cli.completion import script
from tester.tester_rig import case

pytestmark = pytest.mark.realtime
REQUIRED = bool(os.environ.get("MIKAS_REQUIRE_SHELLS"))
FILES = ("drive.pcapng", "my drive.pcapng", "notes.txt", "a.csv", "recs/x.pcapng", "sets/a/b")


def needs(shell):
    there = REQUIRED or shutil.which(shell)
    return pytest.param(
        shell, marks=pytest.mark.skipif(not there, reason=f"{shell} is not installed")
    )


@pytest.fixture
def folder(tmp_path):
    home = tmp_path / "home"
    for name in FILES:
        (home / name).parent.mkdir(parents=True, exist_ok=True)
        (home / name).touch()
    return home


# A line up to Tab, then the words that it becomes.
BECOMES = {
    "mikas rep": "mikas report",
    "mikas read twat": "mikas read TWAT",
    "mikas read --port sim:?scenario=ci": "mikas read --port sim:?scenario=city",
    "mikas decode dr": "mikas decode drive.pcapng",
    "mikas decode 'my": "mikas decode my drive.pcapng",
    "mikas read --capture=dr": "mikas read --capture=drive.pcapng",
    "mikas read --port replay:dr": "mikas read --port replay:drive.pcapng",
    "mikas read обороты_хх": "mikas read обороты_хх",
    "mikas nosuch dr": "mikas nosuch dr",
}
# A line, and words that Tab shows, and one that it does not.
SHOWS = (
    ("mikas re", ("read", "report"), "params"),
    ("mikas export drive.pcapng -o ", ("a.csv", "recs/"), "notes.txt"),
    ("mikas fleet sql ", ("recs/", "sets/"), "notes.txt"),
    ("mikas mem read ", ("ram", "xram", "code", "sfr"), "notes.txt"),
)


@pytest.mark.parametrize("name", [needs("bash"), needs("zsh")])
def test_the_tab_key_completes_a_line(folder, tmp_path, name):
    shell = Shell(name, folder, program(tmp_path))
    try:
        for line, wanted in BECOMES.items():
            became, shown = shell.complete(line)
            with case(line, shown):
                assert became == wanted
                assert "rror" not in shown
        for line, words, other in SHOWS:
            _, shown = shell.complete(line)
            with case(line, shown):
                assert all(word in shown for word in words)
                assert other not in shown
    finally:
        shell.close()


@pytest.mark.parametrize("name", [needs("fish")])
def test_fish_is_offered_the_same(folder, tmp_path, name):
    run = program(tmp_path)
    (folder / "mikas.fish").write_text(script(name), "utf-8")
    environment = {
        "PATH": f"{run.parent}:{os.environ['PATH']}", "HOME": str(folder), "LC_ALL": "C.UTF-8",
        "PYTHONPATH": str(ROOT / "src"), "MIKAS_LANG": "en",
    }  # fmt: skip

    def offered(line):
        typed = line.replace("\\", "\\\\").replace("'", "\\'")
        ran = subprocess.run(
            [name, "-c", f"source mikas.fish; complete -C '{typed}'"],
            cwd=folder, env=environment, capture_output=True, text=True, check=True,
        )  # fmt: skip
        assert ran.stderr == ""
        return [each.split("\t")[0] for each in ran.stdout.splitlines()]

    for line, wanted in BECOMES.items():
        if "'" in line or "nosuch" in line:  # fish finishes a quoted word only on a terminal
            continue
        with case(line):
            assert wanted.removeprefix(line[: line.rfind(" ") + 1]) in offered(line)
    assert offered("mikas nosuch dr") == []
    for line, words, other in SHOWS:
        with case(line):
            found = offered(line)
            assert set(words) <= set(found)
            assert other not in found
