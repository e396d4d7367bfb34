"""A person's own file that is wrong: refused, with its line and in words."""

from __future__ import annotations

from pathlib import Path

import pytest
from catalog_harness import FREE, NEW, Write, assert_refused, refused

from mikas.catalog import shipped
from mikas.catalog.loading.fields import FAMILIES
from mikas.catalog.loading.source import parse_source
from mikas.errors import UsageError
from mikas.i18n import Text


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
         ("unknown key `zzz`; known are parameter, derived, instrument, fault, model, "
          "erratum, unit, version")),
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
