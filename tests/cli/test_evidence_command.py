"""`mikas evidence` without a file: what everything rests on."""

from __future__ import annotations

from mikas.catalog import shipped
from mikas.catalog.grounds import grounds_of
from mikas.cli.failures import USAGE


def test_everything_is_listed_without_a_port(mikas):
    ran = mikas("evidence", "--json", sim="&supplied=0")
    listed = ran.object["evidence"]
    assert [each["name"] for each in listed] == [each.name for each in grounds_of(shipped())]
    by_name = {each["name"]: each for each in listed}
    assert set(by_name["E3"]) == {
        "name", "kind", "text", "source", "siblings", "sources", "confidence", "parts", "seen",
    }  # fmt: skip
    assert by_name["E3"]["source"] == {"en": "letter; odd", "ru": "буква; странная"}
    assert by_name["fault 13"]["sources"] == ["S1"]
    assert "apk76.ru" in ran.object["sources"]["S1"]["en"]
    assert by_name["UACC"]["parts"][1] == {
        "name": "limits", "confidence": "reported", "source": "S1, faults 25 and 26",
    }  # fmt: skip


def test_in_text_a_name_has_a_line_and_one_for_each_statement_of_its_own(mikas):
    ran = mikas("evidence", "uacc", "13")
    rows = [line.split("\t") for line in ran.lines]
    assert [row[0] for row in rows] == ["name", "13", "UACC", "", "", "", "fault 13", ""]
    assert rows[2][2:] == [
        "letter of the formula; the type is impossible",
        "5.2 + b/20, another formula. A voltmeter settles it: 12.0 V is 120 here, 136 there",
        "no",
        "one source",
    ]
    assert rows[3][1:] == ["warm idle", "", "", "", "unconfirmed"]
    assert rows[6][2] == "S1"
    assert "S1: apk76.ru" in ran.err
    assert "\tмолчит\t" in mikas("evidence", "D11", "--lang", "ru").out


def test_everything_in_text_has_one_line_each(mikas):
    assert len(mikas("evidence").lines) == len(grounds_of(shipped())) + 1


def test_a_name_that_there_is_not_is_wrong_usage(mikas):
    ran = mikas("evidence", "TWTA")
    assert ran.status == USAGE
    assert "the nearest is TWAT" in ran.err
