"""A dataclass whose fields have the rules of a file's keys, as guided tests are."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import pytest

from mikas.catalog.loading.fields import between, made, read_table, schema_of, string
from mikas.catalog.loading.source import parse_source
from mikas.errors import CatalogError


@dataclass(frozen=True, slots=True)
class Part:
    name: str
    hold: Annotated[float, between(0, 3600)] = 0.5
    outcome: Annotated[str, string, "verdict"] = "unknown"


def part(text: str) -> Part:
    source = parse_source("part.toml", text.encode())
    keys = read_table(source, (), source.tables, schema_of(Part))
    return made(Part, keys, name="first", outcome=keys.get("verdict", "none"))


def test_a_field_with_a_rule_is_a_key_by_its_name_or_another() -> None:
    assert list(schema_of(Part)) == ["hold", "verdict"]
    assert part('hold = 5\nverdict = "good"\n') == Part("first", 5.0, "good")
    assert part("") == Part("first", 0.5, "none")


@pytest.mark.parametrize("wrong", ["hold = 3601", "hold = -1"])
def test_a_number_out_of_its_range_is_refused(wrong: str) -> None:
    with pytest.raises(CatalogError, match="must be a number from 0 to 3600"):
        part(wrong)


def test_a_field_without_a_rule_is_no_key() -> None:
    with pytest.raises(CatalogError, match="unknown key `name`; known are hold, verdict"):
        part('name = "second"')
