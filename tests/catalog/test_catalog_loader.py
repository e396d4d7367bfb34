"""A person's own files: what they add and override."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from catalog_harness import ALSO_FREE, FREE, NEW, Write, refused

import mikas.catalog
from mikas.catalog import Catalog, Confidence, load, shipped
from mikas.catalog.loading.fields import FAMILIES
from mikas.catalog.loading.loader import load_changed
from mikas.errors import CatalogError
from mikas.i18n import Text

# --- adding and overriding


def test_five_lines_add_a_parameter(write: Write) -> None:
    documented = (Path(__file__).parents[2] / "docs" / "reference" / "catalog.md").read_text(
        encoding="utf-8"
    )
    first, second, *_ = re.findall(r"```toml\n(.*?)```", documented, re.DOTALL)
    assert len(first.splitlines()) == 5
    catalog = load(write(first), write(second))
    boost = catalog.parameter("boost")
    assert catalog.parameters[-1] is boost
    assert catalog.codes[-1] == (0x33, 1)
    assert (boost.code, boost.size, boost.unit, boost.formula()) == (0x33, 1, "kPa", "b")
    assert boost.unit_text == shipped().units.get("kPa", Text("kPa", "kPa"))
    assert boost.text == Text("Boost pressure", "Давление наддува")
    assert boost.decode(b"\x80") == 128
    assert (boost.source, boost.confidence) == ("own1.toml", Confidence.UNCONFIRMED)
    assert (boost.range, boost.range_kind, boost.decimals) == ((0, 255), "representable", 0)
    assert catalog.parameter("TWAT").reference == (82, 97)
    assert catalog.fault(55).text == Text(
        "Speed sensor", "Датчик скорости (на этой машине не установлен)"
    )
    assert catalog.fault(55).check == shipped().fault(55).check


def test_a_text_of_ones_own_replaces_the_shipped_short_one(write: Write) -> None:
    shipped_one = shipped().parameter("FSM")
    assert shipped_one.short == Text("Idle valve, position", "РДВ (РХХ), положение")
    assert shipped().parameter("DET").short == shipped().parameter("DET").text
    renamed = load(write('[parameter.FSM]\ntext.en = "Air valve"\n')).parameter("FSM")
    assert renamed.short == renamed.text == Text("Air valve", shipped_one.text.ru)
    both = load(write('[parameter.FSM]\nshort = "V"\ntext.en = "Air valve"\n')).parameter("FSM")
    assert both.short == Text("V", "V")


def test_a_changed_text_of_a_shipped_file_takes_its_place() -> None:
    models = '[model.0x09]\ntext = { en = "Nine", ru = "Девять" }\n'
    changed = load_changed({"models.toml": models})
    assert changed.model(0x09).text.en == "Nine"
    assert not changed.model(0x0A).known
    assert changed.parameters == shipped().parameters
    with pytest.raises(CatalogError, match=r"models\.toml:1: `model.0x999`"):
        load_changed({"models.toml": "[model.0x999]\n"})


def test_the_docstring_shows_the_same_five_lines() -> None:
    from mikas.catalog.loading import loader

    documented = (Path(__file__).parents[2] / "docs" / "reference" / "catalog.md").read_text(
        encoding="utf-8"
    )
    shown = re.findall(r"```toml\n(.*?)```", documented, re.DOTALL)[0]
    assert loader.__doc__ is not None
    assert "".join(f"    {line}\n" for line in shown.splitlines()) in loader.__doc__


def test_the_document_names_every_key() -> None:
    documented = (Path(__file__).parents[2] / "docs" / "reference" / "catalog.md").read_text(
        encoding="utf-8"
    )
    for family, rules in FAMILIES.items():
        assert f"### `[{family}." in documented or f", `[{family}." in documented
        for key in rules.schema:
            assert re.search(rf"[`, ]{key}\b", documented), key


def test_one_key_overrides_one_key(write: Write) -> None:
    catalog = load(write('[parameter.uacc]\nunit = "mV"\nscale = 100\n'))
    changed, before = catalog.parameter("UACC"), shipped().parameter("UACC")
    assert (changed.unit, changed.decode(b"\x8e")) == ("mV", 14200)
    assert changed.decode(b"\x8e", "literal") == -11400  # inherits what it does not say
    assert (changed.text, changed.errata) == (before.text, before.errata)
    assert [each.name for each in catalog.parameters] == [
        each.name for each in shipped().parameters
    ]


def test_a_later_file_wins(write: Write) -> None:
    one = write('[fault.99]\ntext = "one"\nparameters = ["twat", "P"]\n' + NEW)
    two = write('[fault.0x63]\ntext.ru = "два"\nconfidence = "reported"\nsources = ["me"]\n')
    fault = load(one, two).fault(99)
    assert fault.text == Text("one", "два")
    assert fault.check == Text("", "")
    assert fault.parameters == ("TWAT", "P")
    assert (fault.confidence, fault.sources) == (Confidence.REPORTED, ("me",))
    assert load(two, one).fault(99).text == Text("one", "one")


def test_faults_have_the_numbers_of_a_byte(write: Write) -> None:
    catalog = load(write('[fault.0]\ntext = "first"\n[fault.0xFF]\ntext = "last"\n'))
    assert [catalog.fault(code).text.en for code in (0, 255)] == ["first", "last"]


def test_models_errata_and_units_can_be_added(write: Write) -> None:
    catalog = load(
        write(
            '[model.0x0B]\ntext = "Mikas 11"\n'
            '[erratum.X1]\ntitle = "t"\nreason = "r"\ndefault = "d"\nalternative = "a"\n'
            '[unit.kPa]\ntext = { en = "kPa", ru = "кПа" }\n'
            + NEW
            + 'unit = "kPa"\nerrata = ["x1", "E1"]\n'
        )
    )
    assert catalog.model(0x0B).text == Text("Mikas 11", "Mikas 11")
    assert catalog.model(0x0B).known
    assert catalog.errata["X1"].selected_by == ""
    assert catalog.errata["X1"].source == "own1.toml"
    assert catalog.parameter("P").unit_text == Text("kPa", "кПа")
    assert catalog.parameter("P").errata == ("X1", "E1")


@pytest.mark.parametrize(
    ("lines", "formula", "decimals"),
    [
        ("scale = 0.5", "b / 2", 1),
        ('scale = " 1 / 125 "\noffset = -0.25', "b/125 − 0.25", 3),
        ('scale = "-2"', "−b · 2", 0),
        ('scale = "-1/2"', "−b / 2", 1),
        ("scale = 0.095", "b · 19 / 200", 2),
        ("scale = 1e-2\nsigned = true", "s / 100", 2),
        ("bias = 128\nscale = 0.0001", "(b − 128)/10000", 3),
        ("offset = 0.5", "b + 0.5", 1),
        ("decimals = 5", "b", 5),
        ("mask = 0x30", "b & 0x30", 0),
    ],
)
def test_the_conversion_of_a_number_follows_its_keys(
    write: Write, lines: str, formula: str, decimals: int
) -> None:
    parameter = load(write(NEW + lines)).parameter("P")
    assert (parameter.formula(), parameter.decimals) == (formula, decimals)


def test_range_and_reference_are_kept_with_their_confidence(write: Write) -> None:
    parameter = load(
        write(NEW + 'range = [-1.5, 2]\nreference = [0.0, 0]\nreference_confidence = "reported"')
    ).parameter("P")
    assert (parameter.range, parameter.range_kind) == ((-1.5, 2), "plausible")
    assert [type(end) for end in parameter.range or ()] == [float, int]
    assert (parameter.reference, parameter.reference_confidence) == ((0, 0), Confidence.REPORTED)
    widest = load(write(NEW + "range = [-999_999_999_999_999, 999999999999999.5]")).parameter("P")
    assert widest.range == (-999_999_999_999_999, 999999999999999.5)
    assert load(write(NEW + "range = [-1e-30, 0]")).parameter("P").range == (-1e-30, 0)
    unsaid = load(write(NEW + "reference = [1, 2]")).parameter("P")
    assert unsaid.reference_confidence is Confidence.UNCONFIRMED


def test_a_number_becomes_a_flag_and_a_flag_a_number(write: Write) -> None:
    catalog = load(write("[parameter.THR]\nmask = 1\n[parameter.DET]\nmask = 0\nscale = 2\n"))
    throttle, knock = catalog.parameter("THR"), catalog.parameter("DET")
    assert throttle.decode(b"\x01") is True
    assert (throttle.range, throttle.reference, throttle.unit) == (None, None, "")
    assert knock.decode(b"\x03") == 6


def test_a_flag_may_be_a_bit_of_two_bytes(write: Write) -> None:
    flag = load(write(NEW.replace("size = 1", "size = 2") + "mask = 0x8000")).parameter("P")
    assert (flag.decode(b"\x00\x80"), flag.decode(b"\xff\x7f")) == (True, False)


def test_an_interpretation_can_be_a_flag(write: Write) -> None:
    parameter = load(write(NEW + "scale = 2\nalternative = { mask = 1 }\n")).parameter("P")
    assert parameter.decode(b"\x03") == 6
    assert parameter.decode(b"\x03", "alternative") is True


def test_windows_line_ends_and_a_byte_order_mark_do_not_move_the_line(tmp_path: Path) -> None:
    path = tmp_path / "own.toml"
    path.write_bytes(b"\xef\xbb\xbf" + NEW.replace("\n", "\r\n").encode() + b"size2 = 1\r\n")
    assert refused(path).line == 5


# --- the version


def test_the_version_names_what_was_loaded(write: Write) -> None:
    plain = shipped().version
    assert re.fullmatch(r"1\+[0-9a-f]{8}", plain)
    one, two = write(NEW), write(NEW.replace(FREE, ALSO_FREE))
    versions = {each.version for each in (load(one), load(two), load(one, two), load(two, one))}
    assert len(versions | {plain}) == 5
    assert load(one).version == load(one).version
    two.write_bytes(NEW.replace("\n", "\r\n").encode())
    assert load(two).version == load(one).version
    assert load(write('version = "my car"\n' + NEW)).version.startswith("my car+")


def test_shipped_is_made_once() -> None:
    assert load() is shipped()
    assert isinstance(shipped(), Catalog)


def test_the_public_names_are_those_of_the_list() -> None:
    assert mikas.catalog.__all__ == [
        "INTERPRETATIONS", "AlarmLimits", "Catalog", "Confidence", "Conversion", "Derived",
        "Erratum",
        "Fault", "InstrumentChannel", "Interpretation", "Lamp", "Level", "Meaning", "Model",
        "Parameter",
        "load", "shipped",
    ]  # fmt: skip
