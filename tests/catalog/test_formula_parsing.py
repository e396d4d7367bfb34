"""Formulas: what a parsed one costs, and threads that parse at the same time."""

from __future__ import annotations

import ast

import pytest

from mikas.catalog.formula_syntax import parse, tree_of
from mikas.catalog.formulas import POWER, Calculation
from mikas.errors import FormulaError


def test_threads_that_parse_at_the_same_time_do_not_disturb_each_other(monkeypatch) -> None:
    """Python 3.11 raises so now and then."""
    found, failures = ast.parse, [SystemError("recursion depth mismatch"), RecursionError()]

    def disturbed(*args: str, **more: str) -> ast.AST:
        if failures:
            raise failures.pop()
        return found(*args, **more)

    monkeypatch.setattr(ast, "parse", disturbed)
    assert parse("FREQ + 1", {}).inputs == ("FREQ",)
    assert not failures


@pytest.mark.parametrize(
    ("formula", "cost"),
    [("x", 0), ("x + 1", 1), ("min(x, y, 1)", 2), ("-x", 1), ("x ** 2 + y", POWER + 1)],
)
def test_a_formula_has_a_cost(formula: str, cost: int) -> None:
    assert Calculation(parse(formula, {})).cost == cost


def test_a_tree_that_python_could_not_parse_beside_others_is_parsed_again(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    failures = [SystemError("AST constructor recursion depth mismatch")] * 10
    original = ast.parse

    def parsed(line: str, mode: str) -> ast.AST:
        if failures:
            raise failures.pop()
        return original(line, mode=mode)

    monkeypatch.setattr(ast, "parse", parsed)
    with pytest.raises(SystemError):
        tree_of("1 + 1")
    failures[2:] = []
    assert isinstance(tree_of("1 + 1"), ast.BinOp)


def test_russian_words_join_conditions_and_errors_keep_their_places() -> None:
    channels = {"ОБОРОТЫ": "FREQ", "ДЕТОНАЦИЯ": "DET"}
    formula = "  Обороты > 3000 и НЕ Детонация или FREQ < 5"
    parsed = parse(formula, {}, lambda word: channels.get(word.upper(), word.upper()))
    english = parse("FREQ > 3000 and not DET or FREQ < 5", {})
    assert (parsed.plain, parsed.inputs) == (english.plain, english.inputs)
    assert [formula[first:after] for first, after in parsed.places] == ["Обороты", "Детонация"]
    assert parsed.text.strip() == "FREQ > 3000 and not DET or FREQ < 5"
    with pytest.raises(FormulaError) as caught:
        parse("Обороты > 3000 и )", {})
    assert caught.value.span == (17, 18)
    assert "(знак 18)" in caught.value.text.ru
    assert parse("ионы > 1", {}).inputs == ("ИОНЫ",)
