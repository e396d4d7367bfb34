"""Formulas: what is let in, and what it means for a number and for a column."""

from __future__ import annotations

import math
import pickle
import warnings
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mikas.catalog.formula_syntax import DEEPEST, FUNCTIONS, LONGEST, Operation, Term, parse
from mikas.catalog.formulas import Calculation
from mikas.errors import FormulaError, UsageError

NAN = math.nan


def number(formula: str, constants: dict[str, float] | None = None, **values: float) -> float:
    return Calculation(parse(formula, constants or {})).number(values)


def same(a: float, b: float) -> bool:
    return a == b or (math.isnan(a) and math.isnan(b))


@pytest.mark.parametrize(
    ("formula", "x", "y", "value"),
    [
        ("x + y * 2 - 1", 3, 4, 10),
        ("X / y", 3, 4, 0.75),
        ("-x ** 2", 3, 0, -9),
        ("+x", 3, 0, 3),
        ("(x + y)\n  * 2", 3, 4, 14),
        ("2 ** 0.5 + 0 * x", 0, 0, 2**0.5),
        ("True + x", 1, 0, 2),
        ("1_000 + 0x1A + x", 0, 0, 1026),
        ("min(x, y, 2)", 3, 4, 2),
        ("max(x, y, 2)", 3, 4, 4),
        ("min(x, y)", 3, 3, 3),
        ("abs(x)", -3, 0, 3),
        ("sqrt(x)", 9, 0, 3),
        ("sqrt(x)", 0.25, 0, 0.5),
        ("sqrt(x)", 0, 0, 0),
        ("clip(x, 0, y)", -3, 4, 0),
        ("clip(x, 0, y)", 5, 4, 4),
        ("clip(x, 0, y)", 3, 4, 3),
        ("where(x > y, x, y)", 3, 4, 4),
        ("x if x > y else y", 5, 4, 5),
        *((f"x {sign} y", 3, 3, value) for sign, value in
          [("<", 0), ("<=", 1), (">", 0), (">=", 1), ("==", 1), ("!=", 0)]),
        ("x and y", 2, 3, 3),
        ("x and y", 0, 3, 0),
        ("x or y", 2, 3, 1),
        ("x or y", 0, 3, 3),
        ("0 or x and 1 and y or 0", 2, 3, 1),
        ("not x", 0, 0, 1),
        ("not x", 2, 0, 0),
        # no value
        ("x / y", 3, 0, NAN),
        ("sqrt(x)", -1, 0, NAN),
        ("x ** 0.5", -8, 0, NAN),
        ("y ** x", -1, 0, NAN),
        ("9**9**9 + x", 0, 0, NAN),
        ("1e308 * 10 * x", 1, 0, NAN),
        ("1 / (1e308 * 10 * x)", 1, 0, NAN),
        ("-1e308 - 1e308 + x", 1, 0, NAN),
        ("x / y > 1", 3, 0, NAN),
        ("1 < x / y", 3, 0, NAN),
        ("not x / y", 3, 0, NAN),
        ("(x / y) ** 0", 3, 0, NAN),
        ("1 ** (x / y)", 3, 0, NAN),
        ("min(x / y, 1)", 3, 0, NAN),
        ("min(1, x / y)", 3, 0, NAN),
        ("max(x / y, 1)", 3, 0, NAN),
        ("max(1, x / y)", 3, 0, NAN),
        ("clip(1, 0, x / y)", 3, 0, NAN),
        ("abs(x / y)", 3, 0, NAN),
        ("sqrt(x / y)", 3, 0, NAN),
        ("x / y and 0", 3, 0, NAN),
        ("where(x / y, 1, 2)", 3, 0, NAN),
        # is ignored
        ("where(y > 0, x / y, -1)", 3, 0, -1),
        ("x / y if y else -1", 3, 0, -1),
        ("y > 0 and x / y > 1", 3, 0, 0),
        ("y == 0 or x / y > 1", 3, 0, 1),
        ("y > 0 and x / y > 1 and x", 3, 0, 0),
        ("y == 0 or x / y > 1 or x", 3, 0, 1),
        # an input that is not there is not ignored
        ("where(1, x, y)", 3, NAN, NAN),
        ("where(1, x, y)", 3, math.inf, NAN),
    ],
)  # fmt: skip
def test_a_formula_means_the_same_for_a_number_and_a_column(
    formula: str, x: float, y: float, value: float
) -> None:
    calculation = Calculation(parse(formula, {}))
    assert same(calculation.number({"X": x, "Y": y}), value)
    column = calculation.column({"X": np.array([x, x], float), "Y": np.array([y, y], float)})
    assert column.dtype == np.float64
    assert column.shape == (2,)
    assert all(same(each, value) for each in column)


def test_constants_are_put_in() -> None:
    assert number("x * x_max + X", {"x_max": 10}, X=2) == 22
    assert parse("a * b", {"b": 1}).inputs == ("A",)


def test_inputs_are_listed_as_they_appear() -> None:
    assert parse("b + a - B * max(c, a)", {}).inputs == ("B", "A", "C")


@pytest.mark.parametrize(
    ("formula", "part"),
    [
        ("  x +\n  y % 2", "%"),
        ("(x) // (2)", "//"),
        ("x @ y", "x @ y"),
        ("\tx + foo(1)", "foo"),
        ("x + min(1)", "min(1)"),
        ("x < y <\n 3", "x < y <\n 3"),
        ("x y", "y"),
        ("x + 'ы' + y[0]", "'ы'"),
        ("ы + y[0]", "y[0]"),
    ],
)
def test_a_mistake_has_its_place(formula: str, part: str) -> None:
    with pytest.raises(FormulaError) as caught:
        parse(formula, {})
    assert caught.value.span is not None
    assert formula[slice(*caught.value.span)] == part


def test_a_channel_has_its_first_place() -> None:
    formula = " ы1 +\n freq * FREQ"
    parsed = parse(formula, {})
    assert [formula[slice(*place)] for place in parsed.places] == ["ы1", "freq"]


TOO_DEEP = (
    "-" * (DEEPEST + 1) + "x",
    "not " * (DEEPEST + 1) + "x",
    " and ".join("x" * (DEEPEST + 1)),
    f"not ({' or '.join('x' * DEEPEST)})",
)


@pytest.mark.parametrize(
    ("formula", "problem"),
    [
        ("", "is not a formula: invalid syntax"),
        ("x +", "is not a formula: invalid syntax (character 4)"),
        ("x y", "is not a formula: invalid syntax (character 3)"),
        ("x = 1", "is not a formula"),
        ("x; y", "is not a formula"),
        ("import os", "is not a formula"),
        ("x) + (y", "is not a formula: unmatched ')'"),
        ("x\0", "is not a formula"),
        ("x + \ud800", "is not a formula"),
        ("(" * 300 + "x" + ")" * 300, "is not a formula: too many nested parentheses"),
        (
            "-[" * 199 + "lambda:" * 57 + "x" + "]" * 199,
            "is not a formula",
        ),  # Python runs out of stack
        ("x # y\n+ 1", "has a “#” in it"),
        ("1 + 2", "names no parameter"),
        ("x" * (LONGEST + 1), f"is longer than {LONGEST} signs"),
        ("x + " * 240 + "x", f"is nested more than {DEEPEST} levels deep"),
        ("-" * 900 + "x", f"is nested more than {DEEPEST} levels deep"),
        *((text, f"is nested more than {DEEPEST} levels deep") for text in TOO_DEEP),
        ("1e999 * x", "has a number that is too large"),
        ("9" * 900 + " * x", "has a number that is too large"),
        ("x < y < 3", "has a chain of comparisons"),
        # what is not arithmetic
        ("x.real", "has “x.real” in it; there are numbers, names, "),
        ("x.__class__.__mro__", "has “x.__class__.__mro__” in it"),
        ("x[0]", "has “x[0]” in it"),
        ("'a' * 999999999 + x", "has “'a'” in it"),
        ("b'a'", "has “b'a'” in it"),
        ("f'{x:>99999999}'", "in it"),
        ("'\\d'", r"has a “\” in it"),
        ("1if x else 0", "a sign or a space is missing after “1”"),
        ("x > 0x1for y", "a sign or a space is missing after “0x1f”"),
        ("2x", "a sign or a space is missing after “2”"),
        ("x + 1e5or y", "a sign or a space is missing after “1e5”"),
        ("1j * x", "has “1j” in it"),
        ("None", "has “None” in it"),
        ("...", "has “...” in it"),
        ("[x] * 9", "has “[x]” in it"),
        ("(x, 1)", "has “(x, 1)” in it"),
        ("{x: 1}", "has “{x: 1}” in it"),
        ("[y for y in x]", "has “[y for y in x]” in it"),
        ("lambda: x", "has “lambda: x” in it"),
        ("(x := 1)", "has “x := 1” in it"),
        ("yield x", "is not a formula"),
        ("(yield x)", "has “yield x” in it"),
        ("await x", "has “await x” in it"),
        ("x % 2", "has “%” in it"),
        ("x // 2", "has “//” in it"),
        ("x & 2", "has “&” in it"),
        ("x | 2", "has “|” in it"),
        ("x ^ 2", "has “^” in it"),
        ("1 << 99 << 99", "has “1 << 99 << 99” in it"),
        ("x @ y", "has “x @ y” in it"),
        ("~x", "has “~x” in it"),
        ("x is y", "has “x is y” in it"),
        ("x in y", "has “x in y” in it"),
        ("температура.x" + ".x" * 50, "has “температура.x.x"),
        # calls
        ("eval(x)", "calls “eval”, which there is not; there is min, max, abs, sqrt, where, clip"),
        ("mim(x, 1)", "calls “mim”, which there is not; there is min"),
        ("x(1)", "calls “x”"),
        ("min(x)(1)", "has “min(x)(1)” in it"),
        ("min(x, key=abs)", "has “min(x, key=abs)” in it"),
        ("min(*x, *y)", "has “*x” in it"),
        ("min(x, **y)", "has “min(x, **y)” in it"),
        ("min(x)", "gives “min” 1 argument(s); it takes 2+"),
        ("sqrt(x, 1)", "gives “sqrt” 2 argument(s); it takes 1"),
        ("where(x, 1)", "gives “where” 2 argument(s); it takes 3"),
    ],
)
def test_a_wrong_formula_is_refused_with_its_problem(formula: str, problem: str) -> None:
    with pytest.raises(UsageError) as caught:
        parse(formula, {})
    assert problem in caught.value.reason.en
    assert any("а" <= letter <= "я" for letter in caught.value.reason.ru)
    assert len(caught.value.reason.en) < 300


@pytest.mark.parametrize(
    ("formula", "seen", "right"),
    [
        ("x AND y", "AND", "and"),
        ("x > 1 && y", "&&", "and"),
        ("x || y", "||", "or"),
        ("NOT x", "NOT", "not"),
        ("x <> 1", "<>", "!="),
        ("x > 1 ? 2 : 3", "?", "a if c else b"),
        ("x = 1", "=", "=="),
        ("x >= 1 and y = 1", "=", "=="),
        ("1,5 * x", ",", "."),
        ("x > 1,5", ",", "."),
        ("x and y > 1,5 y", ",", "."),
    ],
)
def test_the_notation_of_other_programs_is_answered_with_ours(
    formula: str, seen: str, right: str
) -> None:
    with pytest.raises(FormulaError) as caught:
        parse(formula, {})
    assert f"“{seen}” is written “{right}”" in caught.value.reason.en
    assert f"вместо «{seen}» пишут «{right}»" in caught.value.reason.ru
    first, after = caught.value.span
    assert formula[first:after] == seen


def test_what_is_not_allowed_is_shown_in_full_up_to_40_signs() -> None:
    for name, shown in (("x" * 38, f"“{'x' * 38}.y”"), ("x" * 39, f"“{'x' * 39}.…”")):
        with pytest.raises(UsageError) as caught:
            parse(f"{name}.y", {})
        assert f"has {shown} in it" in caught.value.reason.en


@pytest.mark.parametrize(
    ("name", "fewest", "most"),
    [("min", 2, 9), ("max", 2, 9), ("abs", 1, 1), ("sqrt", 1, 1), ("where", 3, 3), ("clip", 3, 3)],
)
def test_a_function_takes_its_number_of_arguments_and_no_other(
    name: str, fewest: int, most: int
) -> None:
    for count in range(10):
        formula = f"{name}({', '.join('x' * count)})"
        if fewest <= count <= most:
            assert parse(formula, {}).inputs == ("X",)
        else:
            with pytest.raises(UsageError, match=f"gives “{name}” {count} argument"):
                parse(formula, {})


@pytest.mark.parametrize(("formula", "takes"), [("sqrt(x, 1)", "1"), ("min(x)", "2+")])
def test_the_refusal_says_how_many_it_takes(formula: str, takes: str) -> None:
    with pytest.raises(UsageError) as caught:
        parse(formula, {})
    assert caught.value.reason.en.endswith(f"it takes {takes}")
    assert caught.value.reason.ru.endswith(f"нужно {takes}")


def test_whole_numbers_are_computed_as_64_bit_floats() -> None:
    """2**53 + 1 is not one of them, so adding 1 and taking it away again loses it."""
    assert number("x + y - x", X=2**53, Y=1) == 0
    assert number("k + one - k + 0 * x", {"k": 2**53, "one": 1}, X=0) == 0
    column = Calculation(parse("x * x", {})).column({"X": np.array([2**40])})
    assert (column.dtype, list(column)) == (np.float64, [2.0**80])


def test_a_formula_of_the_greatest_length_is_parsed_and_a_longer_one_refused() -> None:
    document = (Path(__file__).parents[2] / "docs" / "reference" / "catalog.md").read_text(
        encoding="utf-8"
    )
    assert f"It has at most {LONGEST} characters." in document
    assert parse("x" * LONGEST, {}).inputs == ("X" * LONGEST,)


def test_the_deepest_that_is_allowed_is_computed() -> None:
    assert number("-" * DEEPEST + "x", X=1) == 1
    assert number("not " * DEEPEST + "x", X=1) == 1
    assert number(" + ".join("x" * DEEPEST), X=1) == DEEPEST
    assert number(" and ".join("x" * DEEPEST), X=1) == 1


def computed_or_refused(text: str) -> None:
    with warnings.catch_warnings(record=True) as printed:
        warnings.simplefilter("always")
        try:
            inputs = parse(text, {}).inputs
        except UsageError:
            return
        finally:
            assert not printed  # Python's parser warns of some texts
    assert isinstance(number(text, **dict.fromkeys(inputs, 1.5)), float)


@given(st.text(max_size=60))
def test_any_text_is_a_formula_or_refused(text: str) -> None:
    computed_or_refused(text)


@given(
    st.lists(
        st.sampled_from(
            [*"xy01.+-*/()<>=,# _e'\\", "**", "and", "and ", "min(", " if ", "if", "else ", "in"]
        )
    )
)
def test_any_jumble_is_a_formula_or_refused(parts: list[str]) -> None:
    computed_or_refused("".join(parts))


def formulas() -> st.SearchStrategy[str]:
    leaves = st.sampled_from(["x", "y", "k", "0", "1", "-2", "0.5", "1e200", "3.7"])

    def grown(inner: st.SearchStrategy[str]) -> st.SearchStrategy[str]:
        signs = ["+", "-", "*", "/", "**", "<", "<=", ">", ">=", "==", "!=", "and", "or"]
        calls = st.sampled_from([name for name, (fewest, _) in FUNCTIONS.items() for _ in "ab"])
        return st.one_of(
            st.tuples(inner, st.sampled_from(signs), inner).map(" ".join).map("({})".format),
            st.tuples(inner, inner, inner).map(lambda each: "({} if {} else {})".format(*each)),
            inner.map("(not {})".format),
            inner.map("(-{})".format),
            st.tuples(calls, inner, inner, inner).map(
                lambda each: f"{each[0]}({', '.join(each[1:][: FUNCTIONS[each[0]][0]])})"
            ),
        )

    return st.recursive(leaves, grown, max_leaves=12)


numbers = st.sampled_from([0.0, 1.0, -1.0, 0.1, 850.0, NAN, math.inf]) | st.floats(width=64)


@given(formulas(), st.lists(st.tuples(numbers, numbers), max_size=5))
def test_a_column_is_its_numbers(formula: str, rows: list[tuple[float, float]]) -> None:
    try:
        calculation = Calculation(parse(formula, {"k": 0.3}))
    except UsageError as error:
        assert "names no parameter" in error.reason.en
        return
    one_by_one = [calculation.number({"X": x, "Y": y}) for x, y in rows]
    columns = np.array(rows, float).reshape(-1, 2)
    column = calculation.column({"X": columns[:, 0], "Y": columns[:, 1]})
    assert not any(map(math.isinf, one_by_one))
    np.testing.assert_array_equal(column, np.array(one_by_one))


@given(formulas())
def test_the_plain_form_is_no_longer_than_its_text(formula: str) -> None:
    def operations(plain: Term) -> int:
        return 1 + sum(map(operations, plain.operands)) if isinstance(plain, Operation) else 0

    try:
        plain = parse(formula, {"k": 0.3}).plain
    except UsageError:
        return
    assert operations(plain) <= len(formula)


def test_a_parsed_formula_can_be_pickled() -> None:
    parsed = pickle.loads(pickle.dumps(parse("x + 1", {})))
    assert Calculation(parsed).number({"X": 1}) == 2
