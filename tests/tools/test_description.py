"""The description of the package: README.md, for an index that has none of its files."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from hatchling.metadata.core import ProjectMetadata
from hatchling.plugin.manager import PluginManager

import mikas

ROOT = Path(__file__).parents[2]
TAG = f"v{mikas.__version__}"
FILES = f"https://raw.githubusercontent.com/mikas-diagnostics/mikas/{TAG}/"
PAGES = f"https://github.com/mikas-diagnostics/mikas/blob/{TAG}/"
README = (ROOT / "README.md").read_text("utf-8")


@pytest.fixture(scope="module")
def description():
    return ProjectMetadata(str(ROOT), PluginManager()).core.readme


def addresses(text):
    return re.findall(r"(!?)\[[^\]]*\]\(([^)]+)\)", text)


def test_each_address_is_whole_and_leads_to_a_file(description):
    assert len(addresses(description)) == len(addresses(README)) > 40
    for picture, address in addresses(description):
        home = FILES if picture else PAGES
        assert address.startswith(home), address
        assert (ROOT / address.removeprefix(home).partition("#")[0]).exists(), address


def test_nothing_else_is_changed(description):
    assert description.replace(FILES, "").replace(PAGES, "").strip() == README.strip()
