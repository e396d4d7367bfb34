"""CITATION.cff says of the program and of the protocol's text what they say of themselves."""

from __future__ import annotations

import re
from datetime import date
from pathlib import Path

import pytest
import yaml

import mikas

ROOT = Path(__file__).parents[1]
CITATION = yaml.safe_load((ROOT / "CITATION.cff").read_text("utf-8"))
(PROTOCOL,) = CITATION["references"]
PAGES = [ROOT / "docs/protocol.md", ROOT / "docs/ru/protocol.md"]


def test_it_has_what_version_1_2_0_of_the_format_requires():
    assert CITATION["cff-version"] == "1.2.0"
    assert {"message", "title", "authors"} <= set(CITATION)
    assert {"type", "title", "authors"} <= set(PROTOCOL)
    for each in (CITATION, PROTOCOL):
        assert all(set(author) <= {"name"} for author in each["authors"])
        assert isinstance(each["date-released"], date)
        assert isinstance(each["version"], str)


def test_the_program_is_of_this_version_and_of_its_date():
    assert CITATION["version"] == mikas.__version__
    changes = (ROOT / "CHANGELOG.md").read_text("utf-8")
    assert f"## [{mikas.__version__}] – {CITATION['date-released']}" in changes
    assert CITATION["license"] == "MIT"
    assert (ROOT / "LICENSE").read_text("utf-8").startswith("MIT License")


@pytest.mark.parametrize("page", PAGES, ids=["en", "ru"])
def test_the_protocol_is_of_this_version_and_of_its_date(page):
    text = page.read_text("utf-8")
    latest = re.search(r"^\| ([\d.]+) \| (\d{4}-\d{2}-\d{2}) \| ", text, re.MULTILINE)
    assert latest.groups() == (PROTOCOL["version"], str(PROTOCOL["date-released"]))
    released = PROTOCOL["date-released"]
    row = next(line for line in text.splitlines() if f"**{PROTOCOL['version']}**" in line)
    assert re.findall(r"\d+", row.partition("**")[2].rpartition("(")[0]) == [
        *PROTOCOL["version"].split("."), str(released.day), str(released.year)
    ]  # fmt: skip
    assert f"version {PROTOCOL['version']}, {released.year}" in text
    assert PROTOCOL["title"] in text


def test_the_licence_of_the_protocols_text_is_here():
    assert PROTOCOL["license"] == "CC-BY-4.0"
    licence = (ROOT / "docs/CC-BY-4.0.txt").read_text("utf-8")
    assert licence.startswith("Creative Commons Attribution 4.0 International Public License")
    for page in PAGES:
        assert "CC-BY-4.0.txt)" in page.read_text("utf-8")
