"""The description of the package: README.md, for an index that has none of its files."""

from __future__ import annotations

import re
from pathlib import Path

from tools.hatch_build import described

ROOT = Path(__file__).parents[2]
HOME = "https://github.com/someone/mikas/"
FILES = "https://raw.githubusercontent.com/someone/mikas/v1.2/"


def test_each_address_is_whole_and_leads_to_a_file():
    text = described((ROOT / "README.md").read_text("utf-8"), HOME, "v1.2/")
    for picture, address in re.findall(r"(!?)\[[^\]]*\]\(([^)]+)\)", text):
        home = FILES if picture else f"{HOME}blob/v1.2/"
        assert address.startswith(home), address
        assert (ROOT / address.removeprefix(home).partition("#")[0]).exists(), address


def test_other_addresses_stay():
    text = "[a](https://b.example) ![c](https://d.example/e.png) [f](#g) `h(i)`"
    assert described(text, HOME, "v1.2/") == text
