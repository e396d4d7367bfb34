"""A person's own files: what they add and override, and how a wrong one is reported."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from catalog_harness import ALSO_FREE, FREE, Write, assert_refused, refused

import mikas.catalog
from mikas.catalog import Catalog, Confidence, load, shipped
from mikas.catalog.loading.fields import FAMILIES
from mikas.catalog.loading.source import parse_source
from mikas.errors import UsageError
from mikas.i18n import Text

NEW = f'[parameter.P]\ncode = {FREE}\nsize = 1\ntext = "p"\n'


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
        "Fault", "Lamp", "Level", "Meaning", "Model", "Parameter", "load", "shipped",
    ]  # fmt: skip


# --- wrong files


@pytest.mark.parametrize(
    ("text", "line", "problem"),
    [
        # syntax
        ("[parameter.P\n", 1, "this is not TOML: Expected ']'"),
        (NEW + "scale = \n", 5, "this is not TOML: Invalid value"),
        (NEW + "scale = [1,\n\n", 7, "this is not TOML: "),
        (NEW + 'unit = "\n', 5, "this is not TOML: "),
        (NEW + "scale = " + "9" * 5000, 5, "a name or a number is longer than 200 characters"),
        (NEW + "scale = " + "[" * 9000, 5, "brackets are nested more than 32 levels deep"),
        (NEW + f"text.{'a.' * 20_000}b = 1", 5, "a name has more than 16 parts between dots"),
        (NEW + f'unit = "{"u" * 4001}"', 5, "is longer than 4000 characters; shorten it"),
        (NEW + f'errata = ["{"E" * 4001}"]', 5, "is longer than 4000 characters; shorten it"),
        ("[unit]\n" + "".join(f'u{n} = {{ text = "t" }}\n' for n in range(2001)), 2002,
         "`unit.u2000` is more than the 2000 entries that a file may have of a kind"),
        # names and keys
        ("\n[parametr.P]\n", 2, "unknown key `parametr`; the nearest is `parameter`"),
        ("\nzzz = 1\n", 2,
         "unknown key `zzz`; known are parameter, derived, fault, model, erratum, unit, version"),
        (NEW + "scal = 2\n", 5, "unknown key `scal`; the nearest is `scale`"),
        (NEW + '"sсаle" = 2\n', 5, "the nearest is `scale`"),
        (NEW + "literal = {\tscal = 2 }\n", 5, "unknown key `scal`; the nearest is `scale`"),
        (NEW + "\n[parameter.P.literal]\n#\nsize = 2\n", 8, "unknown key `size`"),
        (NEW + 'text.de = "x"\n', 5, "this is not TOML"),
        (NEW + "[fault.1.text]\nde = 'x'\n", 6, "unknown key `de`; known are en, ru"),
        ("parameter = 3\n", 1, "`parameter` must be a table, as [parameter.NAME]"),
        ("[[parameter]]\n", 1, "`parameter` must be a table, as [parameter.NAME]"),
        ("[parameter]\nP = 1\n", 2, "`parameter.P` must be a table, as [parameter.P]"),
        (NEW + "literal = 1", 5, "`parameter.P.literal` must be a table, as [parameter.P.literal]"),
        (NEW + 'literal = "s"', 5, "`parameter.P.literal` must be a table"),
        ("[fault.1]\ntext = 1\n", 2, "`fault.1.text` must be a table, as [fault.1.text]"),
        ("[parameter.0x33]\n", 1, "`parameter.0x33` is no name of Latin letters"),
        ('[parameter."ТWАТ"]\n', 1, "is no name of Latin letters"),
        ("[fault.256]\n", 1, "is not named by a number from 0 to 255"),
        ("[fault.013]\n", 1, "is not named by a number from 0 to 255"),
        ("[model.x]\n", 1, "is not named by a number from 0 to 255"),
        ('[fault."1\u0663"]\n', 1, "is not named by a number from 0 to 255"),  # an Arabic 3
        (NEW + "[parameter.p]\n", 5, "`parameter.p` is there twice"),
        (NEW + NEW, 5, "this is not TOML: Cannot declare ('parameter', 'P') twice"),
        ("[fault.13]\n\n[fault.0x0D]\n", 3, "`fault.0x0D` is there twice"),
        ("version = 1\n", 1, "`version` must be a text in quotes"),
        # missing keys
        ("\n[parameter.P]\nsize = 1\ntext = ''\n", 2, "`parameter.P` has no `code`"),
        ("\n[parameter.P]\ncode = 1\ntext = ''\n", 2, "`parameter.P` has no `size`"),
        ("\n[parameter.P]\ncode = 1\nsize = 1\n", 2, "`parameter.P` has no `text`"),
        ("\n[fault.1]\nsources = []\n", 2, "`fault.1` has no `text`"),
        ("[fault.1]\ntext = { en = '' }\n", 2, "`fault.1.text` has no `ru`"),
        ("[fault.1]\ntext = ''\n[fault.1.check]\nru = ''\n", 3, "`fault.1.check` has no `en`"),
        ("[model.1]\n", 1, "`model.1` has no `text`"),
        ("[unit.x]\n", 1, "`unit.x` has no `text`"),
        ("[erratum.X]\ntitle = ''\nreason = ''\n", 1, "`erratum.X` has no `default`"),
        # values
        (NEW.replace(FREE, "256"), 2, "code` must be a whole number from 0 to 255"),
        (NEW.replace(FREE, "-1"), 2, "code` must be a whole number from 0 to 255"),
        (NEW.replace(FREE, "true"), 2, "code` must be a whole number from 0 to 255"),
        (NEW.replace(FREE, "1.0"), 2, "code` must be a whole number from 0 to 255"),
        (NEW.replace("size = 1", "size = 3"), 3, "size` must be a whole number from 1 to 2"),
        (NEW.replace("size = 1", "size = 0"), 3, "size` must be a whole number from 1 to 2"),
        (NEW + "unit = 1", 5, "`parameter.P.unit` must be a text in quotes"),
        (NEW + "signed = 1", 5, "`parameter.P.signed` must be true or false"),
        (NEW + 'errata = "E1"', 5, "`parameter.P.errata` must be a list of texts"),
        (NEW + "errata = [1]", 5, "`parameter.P.errata` must be a list of texts"),
        (NEW + "scale = 0", 5, "`parameter.P.scale` must not be 0"),
        (NEW + "scale = 0e500", 5, "`parameter.P.scale` must not be 0"),
        (NEW + 'scale = "0/5"', 5, "`parameter.P.scale` must not be 0"),
        (NEW + 'scale = "\u0661/2"', 5, "`parameter.P.scale` must be a number, as 0.5, or a"),
        (NEW + 'scale = "1/0"', 5, "`parameter.P.scale` must be a number, as 0.5, or a fraction"),
        (NEW + 'scale = "b * 2"', 5, "`parameter.P.scale` must be a number, as 0.5, or a fraction"),
        (NEW + "scale = nan", 5, "`parameter.P.scale` must be a number"),
        (NEW + "scale = inf", 5, "`parameter.P.scale` must be a number"),
        (NEW + "scale = 1e400", 5, "`parameter.P.scale` must be a number"),
        (NEW + "scale = 1e-40", 5, "`parameter.P.scale` must be a number"),
        (NEW + "scale = 1e-20", 5, "`parameter.P.scale` is too fine, or too large"),
        (NEW + "scale = 1e99999999999999999999", 5, "`parameter.P.scale` must be a number"),
        (NEW + "scale = false", 5, "`parameter.P.scale` must be a number"),
        (NEW + "\n\nscale = 1e14", 7, "`parameter.P.scale` is too fine, or too large"),
        (NEW + 'offset = "1/999999999999999"\nscale = "1/3"', 6, "scale` is too fine"),
        (NEW + "offset = 1e14\nliteral.scale = 1e-9", 6, "`parameter.P.literal.scale` is too fine"),
        (NEW + "scale = 2\nliteral.offset = 1e-15", 6, "`parameter.P.literal.offset` is too fine"),
        (NEW + "range = [2, 1]", 5, "`parameter.P.range` has its low end 2 above its high end 1"),
        (NEW + "reference = [0.5, 0.25]", 5, "has its low end 0.5 above its high end 0.25"),
        (NEW + "range = [1]", 5, "`parameter.P.range` must be two numbers, [low, high]"),
        (NEW + "range = [1, true]", 5, "`parameter.P.range` must be two numbers"),
        (NEW + "range = [1, inf]", 5, "`parameter.P.range` must be two numbers"),
        (NEW + "range = 5", 5, "`parameter.P.range` must be two numbers"),
        (NEW + "range = [0, 1e15]", 5, "`parameter.P.range` must be two numbers"),
        (NEW + "range = [-1_000_000_000_000_000, 0]", 5, "must be two numbers"),
        (NEW + "range = [0, 9.9e-31]", 5, "`parameter.P.range` must be two numbers"),
        (NEW + 'confidence = "sure"', 5, 'must be one of "confirmed", "reported", "unconfirmed"'),
        (NEW + 'confidence = "unknown"', 5, "must be one of"),
        (NEW + "confidence = []", 5, "must be one of"),
        ("[erratum.E1]\nselected_by = 'corrected'", 2, '"literal", "alternative", "family"'),
        # flags
        (NEW + "mask = 0x100", 5, "`parameter.P.mask` has bits that do not fit its size (1)"),
        (NEW + "literal = { mask = 0x100 }", 5, "`parameter.P.literal.mask` has bits that do"),
        (NEW + "mask = 1\nscale = 2", 6, "`parameter.P.scale` makes no sense for a flag"),
        (NEW + "mask = 1\nunit = 'V'", 6, "`parameter.P.unit` makes no sense for a flag"),
        (NEW + "range = [0, 1]\nmask = 1", 5, "`parameter.P.range` makes no sense for a flag"),
        (NEW + "mask = 1\nreference = [0, 1]", 6, "`parameter.P.reference` makes no sense for a"),
        (NEW + "mask = 1\ndecimals = 1", 6, "`parameter.P.decimals` makes no sense for a flag"),
        (NEW + "mask = 1\nliteral.bias = 1", 6, "`parameter.P.literal.bias` makes no sense"),
        ("[parameter.DET]\nunit = 'V'", 2, "`parameter.DET.unit` makes no sense for a flag"),
        # what does not fit the rest
        (NEW + 'errata = ["E9"]', 5, "`parameter.P.errata` names E9, which does not exist"),
        ('[fault.1]\ntext = ""\nparameters = ["TWAX"]', 3, "does not exist; the nearest is TWAT"),
        (NEW.replace(FREE, "0x1A").replace("size = 1", "size = 2"), 3,
         "`parameter.P.size` makes code 0x1A of two sizes in bytes: TWAT has 1, P has 2"),
        ("#\n[parameter.RXX]\nsize = 2", 3,
         "`parameter.RXX.size` makes code 0x07 of two sizes in bytes: RXX has 2, BITPOW has 1"),
        ("[parameter.INJ]\ncode = 0x1A", 2,
         "`parameter.INJ.code` makes code 0x1A of two sizes in bytes: TWAT has 1, INJ has 2"),
    ],
)  # fmt: skip
def test_a_wrong_file_is_refused_with_its_line(
    write: Write, text: str, line: int, problem: str
) -> None:
    assert_refused(write(text), line, problem)


@pytest.mark.parametrize(
    ("family", "key", "low", "high"),
    [
        ("parameter", "code", 0, 0xFF),
        ("parameter", "size", 1, 2),
        ("parameter", "mask", 0, 0xFFFF),
        ("parameter", "bias", -0xFFFF, 0xFFFF),
        ("parameter", "decimals", 0, 6),
        ("derived", "decimals", 0, 6),
    ],
)
def test_whole_numbers_have_bounds(family: str, key: str, low: int, high: int) -> None:
    read = FAMILIES[family].schema[key]
    assert callable(read)
    assert (read(low), read(high)) == (low, high)
    for outside in (low - 1, high + 1):
        with pytest.raises(UsageError, match=f"from {low} to {high}"):
            read(outside)


def test_the_file_that_is_wrong_is_named(write: Write) -> None:
    good, bad = write(NEW), write("[parameter.P]\nsize = 1\nliteral.scale = 1e14\n")
    assert refused(good, bad).file == str(bad)
    assert refused(bad, good).file == str(bad)
    conflicting = write(f"#\n\n[parameter.Q]\ncode = {FREE}\nsize = 2\ntext = ''\n")
    error = refused(good, conflicting)
    assert (error.file, error.line) == (str(conflicting), 5)
    error = refused(conflicting, good)
    assert (error.file, error.line) == (str(good), 3)


def test_a_partial_entry_that_overrides_nothing_lacks_its_code(write: Write) -> None:
    error = refused(write("[parameter.TWATT]\nreference = [1, 2]\n"))
    assert (error.line, error.problem.en) == (1, "`parameter.TWATT` has no `code`")
    assert error.problem.ru == "`parameter.TWATT`: нет `code`"


def test_the_nearest_name_is_given_in_both_languages(write: Write) -> None:
    problem = refused(write('[fault.1]\ntext = ""\nparameters = ["TWAX", "TWAT"]')).problem
    assert (
        problem.en == "`fault.1.parameters` names TWAX, which does not exist; the nearest is TWAT"
    )
    assert problem.ru == "`fault.1.parameters`: имени TWAX нет; ближайшее — TWAT"


def test_a_missing_file_is_refused_with_the_systems_reason(tmp_path: Path) -> None:
    error = refused(tmp_path / "none.toml")
    assert error.line == 0
    assert "the file can't be read: No such file" in error.problem.en
    assert "файл не читается" in error.problem.ru
    assert "can't be read" in refused(tmp_path).problem.en


def test_a_file_that_is_not_utf_8_is_refused_with_its_line(tmp_path: Path) -> None:
    path = tmp_path / "cp1251.toml"
    path.write_bytes(("\n" + NEW + '# three\n[unit."кПа"]\n').encode("cp1251"))
    error = refused(path)
    assert error.line == 7
    assert "UTF-8" in error.problem.en


def test_a_place_that_the_text_does_not_have_is_line_0() -> None:
    source = parse_source("x.toml", b"a = 1\n")
    assert source.wrong(("b", "c"), Text("x", "x")).line == 0
    assert source.wrong(("a", "c"), Text("x", "x")).line == 1


def test_nothing_of_a_wrong_file_stays(write: Write) -> None:
    refused(write(NEW + "scale = 0"))
    assert shipped().size_of(int(FREE, 16)) is None
