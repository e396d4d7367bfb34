"""The manual: a page of each command in both languages, which groff sets without a warning."""

from __future__ import annotations

import os
import re
import shutil
import subprocess

import click
import pytest
from tools.package import manual
from tools.package.wheel import write_manual

from mikas.cli.click_extensions import LocalizedGroup
from mikas.cli.language import current_language
from mikas.cli.main import cli
from mikas.cli.options.common import common_options
from tester.tester_rig import case

REQUIRED = bool(os.environ.get("MIKAS_REQUIRE_LINTIAN"))  # it needs man-db, which needs groff
needs_groff = pytest.mark.skipif(
    not REQUIRED and not shutil.which("groff"), reason="groff is not installed"
)


def commands(group=cli, name="mikas"):
    yield name, group
    for word in group.homes:
        inner = group.get_command(click.Context(group), word)
        if isinstance(inner, LocalizedGroup):
            yield from commands(inner, f"{name}-{word}")
        else:
            yield f"{name}-{word}", inner


@pytest.fixture(scope="module")
def pages():
    return {language: manual.pages(language) for language in ("en", "ru")}


def shown(page):
    """The text of a page, without the fonts and signs of roff."""
    plain = re.sub(r"\\f[BIR]", "", page)
    for escape, sign in (
        (r"\-", "-"), (r"\(aq", "'"), (r"\(dq", '"'), (r"\(ti", "~"), (r"\(ga", "`"), (r"\&", ""),
    ):  # fmt: skip
        plain = plain.replace(escape, sign)
    return " ".join(plain.split())


def test_every_command_has_a_page_with_its_options_and_examples(pages):
    assert set(pages["en"]) == set(pages["ru"]) == {name for name, _ in commands()}
    for name, command in commands():
        for language in ("en", "ru"):
            with case(name, language):
                text = shown(pages[language][name])
                assert command.text.to(language).replace("`", "") in text
                for each in command.params:
                    common = each.opts in [it.opts for it in common_options()]
                    if isinstance(each, click.Option) and (not common or name == "mikas"):
                        assert all(opt in text for opt in each.opts)
                        assert each.text.to(language).replace("`", "") in text
                assert all(example in text for example in command.examples)
    assert "mikas-mem-dump(1)" in shown(pages["en"]["mikas-mem"])
    assert current_language() == "en"


def test_english_pages_are_english_and_russian_ones_have_russian_titles(pages):
    for name in pages["en"]:
        assert not re.search("[а-яА-Я]", pages["en"][name])
        titles = re.findall(r"^\.S[HS] (.*)", pages["ru"][name], re.MULTILINE)
        assert all(re.search("[а-яА-Я]", title) for title in titles), titles


def test_no_sign_is_left_that_roff_would_change(pages):
    for name, page in [*pages["en"].items(), *pages["ru"].items()]:
        for line in page.splitlines():
            with case(name, line):
                if line.startswith("."):
                    assert re.match(r"\.(TH|SH|SS|TP|PP|nf|fi|nh|ad)\b", line)
                else:
                    assert not re.search(r"(?<!\\)-|['`^~\"]", line)
                    assert not re.search(r"\\(?!-|e|&|f[BIR]|\((aq|dq|ga|ha|ti))", line)


@needs_groff
def test_groff_sets_every_page_without_a_warning_and_breaks_no_word(tmp_path):
    write_manual(tmp_path)
    files = sorted(tmp_path.rglob("*.1"))
    assert len(files) == 2 * len(dict(commands()))
    for file in files:
        command = ["groff", "-Tutf8", "-Kutf8", "-man", "-ww", "-z", file]
        ran = subprocess.run(command, capture_output=True, text=True, check=True)
        assert (ran.stdout, ran.stderr) == ("", ""), file
    sim = tmp_path / "man/man1/mikas-sim.1"
    command = ["groff", "-Tutf8", "-Kutf8", "-man", "-rLL=60n", "-P-c", "-P-b", "-P-u", sim]
    text = subprocess.run(command, capture_output=True, encoding="utf-8", check=True).stdout
    assert "missing-byte," in text.split()
    assert "--line-fault damaged=0.01" in text
