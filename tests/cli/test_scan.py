"""`mikas scan`: the codes that a unit answers, and the catalog file made from them."""

from __future__ import annotations

import pytest
from cli_harness import is_one_short_paragraph, is_russian

from mikas.client import Ecu
from mikas.errors import LinkLost

SCENARIO = """
name = "odd"
duration = 3600
text = { en = "odd codes", ru = "странные коды" }

[raw]
"0x33" = "0D"
"0x80" = "01"
"0x90:2" = "40 0D"
"0xA0:4" = "01 02 03 04"
"""
# The five codes of the scenario in addition to those of §4.
ODD = {"33": (1, "0D"), "80": (1, "01"), "90": (2, "400D"), "A0": (4, "01020304")}


@pytest.fixture
def odd(mikas, tmp_path):
    (tmp_path / "odd.toml").write_text(SCENARIO, "utf-8")
    return f"&scenario={tmp_path / 'odd.toml'}"


@pytest.mark.parametrize("unknown", ["silent", "01"])
@pytest.mark.parametrize("max_list", ["255", "1"])
def test_a_scan_finds_codes_sizes_and_values_beside_the_promise(mikas, odd, unknown, max_list):
    ran = mikas("scan", "--json", sim=f"{odd}&unknown={unknown}&max_list={max_list}")
    assert ran.status == 0
    codes = {c["code"]: (c["size"], c["raw"]) for c in ran.object["codes"]}
    unclear = {"80"} if (unknown, max_list) == ("01", "1") else set()
    assert {c: codes[c] for c in ODD if c not in unclear} == {
        c: v for c, v in ODD.items() if c not in unclear
    }
    assert len(codes) == 21 + len(ODD) - len(unclear)
    assert unclear <= set(ran.object["unclear"])
    assert (ran.object["promised"], ran.object["requested"]) == (25, 256)
    names = {c["code"]: c["name"] for c in ran.object["codes"]}
    assert (names["1A"], names["07"], names["33"]) == ("TWAT", "RXX BITPOW RDET", None)


def test_the_file_serves_as_a_catalog(mikas, odd):
    ran = mikas("scan", "-o", "mine.toml", sim=odd)
    assert ran.status == 0
    assert "33\t1\t0D\t\t13" in ran.lines
    assert "mine.toml: 4 codes" in ran.err
    read = mikas("--catalog", "mine.toml", "read", "CODE_33", "CODE_90", "TWAT", "--json")
    values = {name: r["value"] for name, r in read.object["readings"].items()}
    assert (values["CODE_33"], values["CODE_90"]) == (13, 0x0D40)
    again = mikas("scan", "-o", "mine.toml")
    assert again.status == 2
    is_one_short_paragraph(again.err)
    nowhere = mikas("scan", "-o", "nosuch/mine.toml")
    assert (nowhere.status, nowhere.out) == (2, "")  # before ten minutes of requests


def test_a_scan_speaks_russian(mikas, odd):
    ran = mikas("scan", "--lang", "ru", "-o", "a.toml", sim=f"{odd}&max_list=1&unknown=01")
    is_russian(ran.err, names=("a.toml",))
    assert "Неясно" in ran.err


def test_a_unit_without_61_is_status_5_and_has_no_codes(mikas):
    ran = mikas("scan", "--json", sim="&missing=61&unknown=01")
    assert ran.status == 5
    assert '"codes": []' in ran.lines[0]


@pytest.mark.parametrize(
    ("end", "status"), [(KeyboardInterrupt, 130), (LinkLost(url="sim:", problem="out"), 3)]
)
def test_what_was_found_is_shown_however_it_ends(mikas, monkeypatch, tmp_path, end, status):
    scan = Ecu.scan

    def some(self):
        for number, each in enumerate(scan(self)):
            if number == 10:
                raise end
            yield each

    monkeypatch.setattr(Ecu, "scan", some)
    ran = mikas("scan", "-o", "part.toml")
    assert ran.status == status
    assert "Stopped: 10 of 256 codes" in ran.err
    assert len(ran.lines) == 11
    assert "Incomplete: 246 codes" in (tmp_path / "part.toml").read_text("utf-8")
