"""A catalog file made from a scan loads, and adds the unknown codes and nothing else."""

from __future__ import annotations

from hypothesis import given, settings
from hypothesis import strategies as st

from mikas.catalog import load, shipped
from mikas.catalog.starter import names_of, starter_catalog

DATA = st.dictionaries(st.integers(0, 0xFF), st.binary(min_size=1, max_size=5))


@settings(max_examples=25)
@given(DATA, st.lists(st.text(), max_size=3), st.sampled_from(["en", "ru"]))
def test_it_loads_and_has_every_code_that_can_be_an_entry(tmp_path_factory, data, heading, lang):
    file = tmp_path_factory.mktemp("catalog") / "scan.toml"
    text = starter_catalog(data, shipped(), heading, lang)
    file.write_text(text, "utf-8", errors="replace")
    catalog = load(file)
    new = {c: len(raw) for c, raw in data.items() if len(raw) <= 2 and not shipped().size_of(c)}
    assert {code: catalog.size_of(code) for code in new} == new
    added = [p for p in catalog.parameters if p.name not in {p.name for p in shipped().parameters}]
    assert [p.code for p in added] == sorted(new)
    for parameter in added:
        raw = data[parameter.code]
        assert parameter.conversion.decode(raw) == int.from_bytes(raw, "little")
        assert parameter.text.en != parameter.text.ru
    assert all(f"{code:02X}" in text for code in data)


def test_a_starter_file_is_written_as_expected():
    data = {
        0x35: b"\xab\xcd",
        0x3F: b"\1\2",
        0x33: b"\0",
        0x07: b"\4",
        0x1A: b"\1\2",
        0x90: b"\xab\0\0\0",
    }
    assert starter_catalog(data, shipped(), ["Scan\n2"], "en") == (
        "# Scan 2\n"
        "# Defined already: 07 RXX BITPOW RDET, 3F INJ\n"
        "# 1A: bytes here: 2, in the catalog: 1; it keeps the catalog's definition\n"
        "# 90: 4 bytes, more than an entry can have (AB 00 00 00)\n"
        "\n"
        "[parameter.CODE_33]  # at the scan: 00\n"
        "code = 0x33\n"
        "size = 1\n"
        'text = { en = "code 33", ru = "код 33" }\n'
        "\n"
        "[parameter.CODE_35]  # at the scan: AB CD\n"
        "code = 0x35\n"
        "size = 2\n"
        'text = { en = "code 35", ru = "код 35" }\n'
    )
    russian = starter_catalog(data, shipped(), [], "ru")
    assert russian.startswith("# Уже описаны: 07 RXX BITPOW RDET, 3F INJ\n")
    assert "# 1A: здесь байтов 2, в каталоге 1; остаётся описание каталога\n" in russian
    assert "[parameter.CODE_33]  # при опросе: 00\n" in russian
    assert starter_catalog({}, shipped(), [], "en") == ""


def test_a_code_of_another_size_stays_as_the_catalog_has_it(tmp_path):
    text = starter_catalog({0x1A: b"\x01\x02", 0x90: bytes(4)}, shipped(), ["x"], "en")
    assert "1A: bytes here: 2, in the catalog: 1" in text
    assert "90: 4 bytes, more than an entry can have (00 00 00 00)" in text
    (tmp_path / "c").write_text(text, "utf-8")
    assert load(tmp_path / "c").parameters == shipped().parameters


def test_a_code_is_shown_with_the_names_that_share_it():
    assert names_of(shipped(), 0x07) == "RXX BITPOW RDET"
    assert names_of(shipped(), 0x33) == ""
