"""What each clause, command, channel and fault rests on, put together."""

from __future__ import annotations

import pytest

from mikas.catalog import Confidence, grounds, load, shipped
from mikas.catalog import evidence as evidence_module
from mikas.catalog.evidence import Agreement, EvidenceTable, Sighting
from mikas.catalog.grounds import GroundsPart, grounds_of, named, parameter_grounds
from mikas.commands import COMMANDS_BY_CODE
from mikas.errors import UsageError
from mikas.i18n import Text

EVERY = grounds_of(shipped())
BY_NAME = {each.name: each for each in EVERY}


def names(*words):
    return [each.name for each in named(EVERY, words)]


def test_everything_that_is_known_has_its_grounds_once() -> None:
    catalog = shipped()
    assert len(BY_NAME) == len(EVERY)
    by_kind = {}
    for each in EVERY:
        by_kind.setdefault(each.kind, []).append(each.name)
    assert {kind: len(found) for kind, found in by_kind.items()} == {
        "clause": 16,
        "decision": 17,
        "command": len(COMMANDS_BY_CODE),
        "erratum": len(catalog.errata),
        "parameter": len(catalog.parameters),
        "channel": len(catalog.derived) + len(catalog.instruments),
        "fault": len(catalog.faults),
        "model": len(catalog.models),
    }
    for each in EVERY:
        assert each.text.en
        assert each.text.ru
        assert each.source.en or each.confidence, each.name


def test_a_parameter_has_its_clause_s_words_and_the_catalog_s_confidence() -> None:
    found = BY_NAME["UACC"]
    assert found.source.en == "letter of the formula; the type is impossible"
    assert "5.2 + b/20" in found.siblings.en
    assert found.confidence is Confidence.REPORTED
    assert found.parts == (
        GroundsPart("reference", Confidence.UNCONFIRMED),
        GroundsPart("limits", Confidence.REPORTED, "S1, faults 25 and 26"),
        GroundsPart("meaning", Confidence.UNCONFIRMED, "own knowledge"),
    )
    assert parameter_grounds(shipped().parameter("UACC")) == found
    assert BY_NAME["UGB"].parts == ()


def test_a_fault_a_model_and_a_channel_have_those_of_their_entries() -> None:
    fault = BY_NAME["fault 13"]
    assert (fault.sources, fault.confidence) == (("S1",), Confidence.REPORTED)
    assert fault.parts == (GroundsPart("check", Confidence.UNCONFIRMED),)
    assert BY_NAME["model 0A"].source.en == "§3"
    duty = BY_NAME["DUTY"]
    assert duty.source.en == "facts: arithmetic"
    assert duty.parts == (GroundsPart("limits", Confidence.UNCONFIRMED, "arithmetic"),)
    assert shipped().instruments
    for name, channel in shipped().instruments.items():
        assert BY_NAME[name].source.en == channel.source
        assert BY_NAME[name].confidence is channel.confidence


def test_an_entry_of_the_user_s_own_rests_on_the_file(tmp_path) -> None:
    own = tmp_path / "own.toml"
    own.write_text(
        '[parameter.BOOST]\ncode = 0x33\nsize = 1\ntext = "Boost"\n[fault.99]\ntext = "Own"\n'
        '[parameter.UACC]\nscale = "1/20"\nsource = "own.toml"\n',
        "utf-8",
    )
    by_name = {each.name: each for each in grounds_of(load(own))}
    for name in ("BOOST", "UACC"):
        assert by_name[name].source == Text("own.toml", "own.toml")
        assert by_name[name].siblings.en == ""
    assert by_name["fault 99"].parts == ()
    assert by_name["fault 99"].confidence is Confidence.UNCONFIRMED


def test_what_a_unit_has_shown_stands_with_what_it_concerns(monkeypatch) -> None:
    known = evidence_module.evidence()
    seen = tuple(
        Sighting((of,), "0A, 2026-12-05", Agreement.AGREES, Text("seen", "видели"))
        for of in ("D11", "UACC", "fault 13", "model 0A", "61")
    )
    table = EvidenceTable(known.bases, known.titles, known.sources, seen)
    monkeypatch.setattr(grounds, "evidence", lambda: table)
    found = {each.name: each for each in grounds_of(shipped()) if each.sightings}
    assert list(found) == ["61", "D11", "UACC", "fault 13", "model 0A"]
    assert found["D11"].as_json()["seen"] == [
        {"unit": "0A, 2026-12-05", "agreement": "agrees", "text": {"en": "seen", "ru": "видели"}}
    ]


def test_names_are_found_as_people_write_them() -> None:
    assert names("d11", "§2.1", "2.2", "twat") == ["§2.1", "§2.2", "D11", "TWAT"]
    assert names("13") == ["13", "fault 13"]
    assert names("fault 13") == ["fault 13"]
    assert names("§4") == ["§4", "§4.1", "§4.2"]
    assert names("0a") == ["model 0A"]


@pytest.mark.parametrize(("word", "near"), [("TWTA", "; the nearest is TWAT"), ("quite else", "")])
def test_a_name_that_there_is_not_is_refused_with_the_nearest(word, near) -> None:
    with pytest.raises(UsageError, match=f"Nothing is named “{word}”{near}. There are"):
        list(named(EVERY, [word]))
