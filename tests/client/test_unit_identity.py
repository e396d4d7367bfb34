"""Whether two identities are of one unit."""

from __future__ import annotations

from mikas.client.identity import Passport, UnitIdentity

WHOLE = Passport(("A", "B", "C"), ("1", "2", "3", "4", "5"))
PART = Passport(("A", "B", "C"), (None,) * 5)
NONE = Passport((None,) * 3, (None,) * 5)


def may_be(one: tuple, other: tuple) -> bool:
    result = UnitIdentity(*one).may_be(UnitIdentity(*other))
    assert UnitIdentity(*other).may_be(UnitIdentity(*one)) is result
    return result


def test_a_lost_piece_makes_no_other_unit() -> None:
    assert may_be((9, WHOLE), (9, PART))
    assert may_be((9, NONE), (9, NONE))
    assert may_be((9, None), (9, None))


def test_another_version_or_piece_makes_another_unit() -> None:
    assert not may_be((9, WHOLE), (10, WHOLE))
    assert not may_be((9, PART), (9, Passport(("A", "B", "D"), (None,) * 5)))


def test_without_a_common_piece_nothing_says_that_it_is_the_same() -> None:
    assert not may_be((9, NONE), (9, PART))
    assert not may_be((9, PART), (9, Passport((None,) * 3, WHOLE.data)))
    assert not may_be((9, None), (9, WHOLE))


def test_only_a_difference_contradicts() -> None:
    whole = UnitIdentity(9, WHOLE)
    assert not whole.contradicts(UnitIdentity(9, NONE))
    assert not whole.contradicts(UnitIdentity(9, None))
    assert whole.contradicts(UnitIdentity(9, Passport(("D",), ())))
    assert whole.contradicts(UnitIdentity(10, WHOLE))


def test_missing_pieces_are_filled_from_the_same_unit() -> None:
    assert UnitIdentity(9, PART).filled_from(UnitIdentity(9, WHOLE)) == (9, WHOLE)
    assert UnitIdentity(9, Passport(("A",), ())).filled_from(UnitIdentity(9, WHOLE)) == (9, WHOLE)
