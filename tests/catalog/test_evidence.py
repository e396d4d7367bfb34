"""What clauses, commands, parameters and errata rest on: the shipped file, and wrong files."""

from __future__ import annotations

import re

import pytest
from tools.docs.pages import DOCS, RUSSIAN, document

from mikas.catalog import shipped
from mikas.catalog.evidence import Agreement, evidence, read_evidence
from mikas.commands import COMMANDS_BY_CODE
from mikas.errors import CatalogError

HOMES = {"en": DOCS, "ru": RUSSIAN}
BASIS = '[[basis]]\nof = ["D11"]\nsource = { en = "silent", ru = "молчит" }\n'
SEEN = """[[sighting]]
of = ["D11", "61"]
unit = "0A, 2026-12-05"
agreement = "agrees"
text = { en = "16 codes", ru = "16 кодов" }
"""


def read(text):
    return read_evidence("evidence.toml", text.encode())


def test_every_clause_command_parameter_and_erratum_has_one_basis() -> None:
    names = [name for basis in evidence().bases for name in basis.of]
    assert len(names) == len(set(names))
    assert set(names) == {
        *evidence().titles,
        *shipped().errata,
        *(f"{code:02X}" for code in COMMANDS_BY_CODE),
        *(each.name for each in shipped().parameters if each.source == "§4"),
    }


def test_every_source_of_a_fault_has_its_page() -> None:
    named = {key for fault in shipped().faults.values() for key in fault.sources}
    assert named == set(evidence().sources)


@pytest.mark.parametrize("language", HOMES)
def test_the_titles_are_the_headings_of_the_protocols_page(language) -> None:
    page = document(HOMES[language] / "protocol.md").text
    headings = dict(re.findall(r"^#+ (?:<a id=[^>]+></a>)+(§[\d.]+) (.+)$", page, re.MULTILINE))
    headings |= dict(re.findall(r"\*\*\[(D\d+)\]\(#d\d+\) ([^*]+?)\.?\*\*", page))
    own = {"D6", "D7", "D8", "D9"}  # stand in the table of the commands, without a heading
    titles = {name: each.to(language) for name, each in evidence().titles.items()}
    assert {name: text for name, text in titles.items() if name not in own} == {
        name: text for name, text in headings.items() if name not in {"§6", "§7"}
    }


def test_the_basis_of_a_name_is_that_of_its_group() -> None:
    basis = evidence().basis_of("D11")
    assert basis is evidence().basis_of("D12")
    assert basis.source.en == "silent"
    assert evidence().basis_of("TWTA") is None
    assert evidence().sightings_of("D11") == ()


def test_a_sighting_belongs_to_its_names() -> None:
    known = read(BASIS + SEEN)
    (seen,) = known.sightings_of("D11", "D12")
    assert (seen.unit, seen.agreement, seen.text.en) == (
        "0A, 2026-12-05", Agreement.AGREES, "16 codes",
    )  # fmt: skip
    assert seen.of == ("D11", "61")
    assert known.sightings_of("61") == (seen,)
    assert known.sightings_of("D12") == ()
    assert known.basis_of("D11").siblings.en == ""


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[[bases]]\n", "unknown key `bases`; the nearest is `basis`"),
        ("[basis]\n", "`basis` is a list: [[basis]]"),
        ("basis = [1]\n", "`basis` must be a table"),
        ('[[basis]]\nof = ["D1"]\n', "`basis` has no `source`"),
        ('[[basis]]\nsource = { en = "a", ru = "b" }\n', "`basis` has no `of`"),
        (BASIS + "source_of = 1\n", "unknown key `source_of`"),
        (SEEN.replace('"agrees"', '"maybe"'), "agreement` must be one of"),
        (SEEN.replace("unit", "units"), "unknown key `units`; the nearest is `unit`"),
        (SEEN.replace('unit = "0A, 2026-12-05"\n', ""), "`sighting` has no `unit`"),
        ('[title]\nD1 = { en = "echo" }\n', "has no `ru`"),
        ("[source\n", "this is not TOML"),
    ],
)
def test_a_wrong_file_is_refused_with_its_reason(text, message) -> None:
    with pytest.raises(CatalogError, match=re.escape(message)) as refused:
        read(text)
    assert "evidence.toml" in str(refused.value)
