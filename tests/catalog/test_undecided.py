"""The readings of RCOK and RCOD beside each other (E3)."""

from __future__ import annotations

import pytest

from mikas.catalog import INTERPRETATIONS, load, shipped
from mikas.catalog.undecided import READING_NAMES, otherwise, values_otherwise


def test_every_interpretation_has_a_word() -> None:
    assert set(READING_NAMES) == set(INTERPRETATIONS)


@pytest.mark.parametrize(
    ("raw", "letter", "alternative", "family"),
    [(0, -1, -0.5, 0.5), (128, -0.5, 0, 1), (255, -0.00390625, 0.49609375, 1.49609375)],
)
def test_rcok_has_three_readings(raw, letter, alternative, family) -> None:
    rcok, data = shipped().parameter("RCOK"), bytes([raw])
    assert rcok.decode(data) == letter
    assert values_otherwise(rcok, data) == {"alternative": alternative, "family": family}
    assert values_otherwise(rcok, data, "family") == {
        "literal": letter, "alternative": alternative,
    }  # fmt: skip


def test_rcod_has_two_and_what_is_certain_has_none() -> None:
    assert list(otherwise(shipped().parameter("RCOD"))) == ["alternative"]
    assert list(otherwise(shipped().parameter("RCOD"), "alternative")) == ["literal"]
    for parameter in shipped().parameters:
        if parameter.name not in ("RCOK", "RCOD"):
            assert otherwise(parameter) == {}
            assert values_otherwise(parameter, bytes(parameter.size), "literal") == {}


def test_a_user_s_own_formula_leaves_the_others_beside_it(tmp_path) -> None:
    own = tmp_path / "own.toml"
    own.write_text("[parameter.RCOK]\nbias = -128\noffset = 0\nliteral = { bias = 128 }\n", "utf-8")
    rcok = load(own).parameter("RCOK")
    assert rcok.decode(b"\x80") == 1
    assert values_otherwise(rcok, b"\x80") == {"literal": 0}
    assert values_otherwise(rcok, b"\x80", "literal") == {"alternative": 1}
