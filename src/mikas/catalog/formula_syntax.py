"""The text of a formula, checked and converted into its plain form before any computation.

A formula is a Python expression of numbers, names, `+ - * / **`, comparisons, `and or not`,
`a if c else b`, and calls of `FUNCTIONS`; `и или не` are read as `and or not`. Anything else is
refused, and so is a formula that is too long or too deep. All numbers become 64-bit floats, so the
length bounds the computing time.

In the plain form every condition is a call of `where`, so that it works on arrays too:
`a if c else b` is `where(c, a, b)`, `a and b` is `where(a, b, 0)`, `a or b` is `where(a, 1, b)`,
`not a` is `where(a, 0, 1)`.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import isfinite
from typing import TypeAlias

from mikas.errors import FormulaError
from mikas.i18n import Text
from mikas.options import nearest

LONGEST = 1000  # characters
DEEPEST = 60  # levels of nesting; `a + b + c` has two

FUNCTIONS: Mapping[str, tuple[int, int]] = {
    "min": (2, LONGEST),
    "max": (2, LONGEST),
    "abs": (1, 1),
    "sqrt": (1, 1),
    "where": (3, 3),
    "clip": (3, 3),
}
"""Each function with its fewest and most arguments."""

_OPERATORS: Mapping[type[ast.AST], str] = {
    ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/", ast.Pow: "**",
    ast.USub: "negative", ast.UAdd: "positive",
    ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">=", ast.Eq: "==", ast.NotEq: "!=",
}  # fmt: skip

_HABITS: tuple[tuple[re.Pattern[str], Callable[[str], str]], ...] = (
    (re.compile(r"\b(?:AND|OR|NOT|IF|ELSE)\b"), str.lower),
    (re.compile(r"&&"), lambda _: "and"),
    (re.compile(r"\|\|"), lambda _: "or"),
    (re.compile(r"<>"), lambda _: "!="),
    (re.compile(r"\?"), lambda _: "a if c else b"),
    (re.compile(r"(?<![<>=!:])=(?!=)"), lambda _: "=="),
    (re.compile(r"(?<=\d),(?=\d)"), lambda _: "."),
)
"""What other programs write, and how it is written here."""

_RUSSIAN = {"и": "and", "или": "or", "не": "not"}
_RUSSIAN_WORDS = re.compile(rf"\b(?:{'|'.join(_RUSSIAN)})\b", re.IGNORECASE)

_TOKENS = re.compile(
    r"[^\W\d]\w*"  # a name, which may have digits in it
    r"|(?P<number>0[xX][0-9a-fA-F_]+|0[oO][0-7_]+|0[bB][01_]+"
    r"|(?:[0-9][0-9_]*\.?[0-9_]*|\.[0-9][0-9_]*)(?:[eE][+-]?[0-9][0-9_]*)?[jJ]?)"
)

_TRIES = 4

_SIGNS = {ast.Mod: "%", ast.FloorDiv: "//", ast.BitAnd: "&", ast.BitOr: "|", ast.BitXor: "^"}


@dataclass(frozen=True, slots=True)
class Operation:
    """An operator or a function, by its sign or name, and what it is applied to."""

    name: str
    operands: tuple[Term, ...]


Term: TypeAlias = "float | str | Operation"
"""A plain form: a number, a channel by its name in capitals, or an operation."""


@dataclass(frozen=True, slots=True)
class Parsed:
    """The plain form, and its channels (in capitals, in order of appearance).

    `places`: the first and the next character of each channel's first appearance. `text`: the
    formula with the names in `inputs`.
    """

    plain: Term
    inputs: tuple[str, ...]
    places: tuple[tuple[int, int], ...]
    text: str = ""


def parse(
    text: str, constants: Mapping[str, float], channel_of: Callable[[str], str] = str.upper
) -> Parsed:
    """Check a formula and insert its constants; any other name is a channel's, in any case.

    `channel_of`: returns the channel that a name means (`Catalog.channel_of`).
    FormulaError: not a formula, or one without a channel; the loader adds file and line.
    """
    if len(text) > LONGEST:
        raise _too_long()
    # One line, in which each sign keeps its place behind those that are left out at the begin.
    line = "".join(" " if sign.isspace() else sign for sign in text).strip()
    begin = len(text) - len(text.lstrip())
    typed, (line, typed_at) = line, _with_english_words(line)
    try:
        syntax = _syntax(line, typed_at)
        form = _PlainForm(line, constants, channel_of)
        plain = form.expression(syntax, 0)
    except FormulaError as error:
        if error.span is not None:
            first, after = error.span
            error.span = (begin + typed_at[first], begin + typed_at[after])
        raise
    if not form.inputs:
        raise _wrong(
            "names no parameter, so it has no time and no value",
            "не называет ни одного параметра, значит, нет ни времени, ни значения",
        )
    places = (
        (begin + typed_at[first], begin + typed_at[after]) for first, after in form.inputs.values()
    )
    named = text if line == typed else " " * begin + line
    for (first, after), name in sorted(form.names.items(), reverse=True):
        named = f"{named[: begin + first]}{name}{named[begin + after :]}"
    if len(named) > LONGEST:
        raise _too_long()
    return Parsed(plain, tuple(form.inputs), tuple(places), named)


def _with_english_words(line: str) -> tuple[str, list[int]]:
    """Return the formula with its Russian words in English, and where each sign was typed.

    The end has a place as well, and so has a sign that is missing there.
    """
    words: list[str] = []
    places: list[int] = []
    end = 0
    for match in _RUSSIAN_WORDS.finditer(line):
        word = _RUSSIAN[match[0].lower()]
        words += [line[end : match.start()], word]
        places += range(end, match.start())
        places += (min(match.start() + at, match.end()) for at in range(len(word)))
        end = match.end()
    places += range(end, len(line) + 2)
    return "".join((*words, line[end:])), places


def _wrong(en: str, ru: str, span: tuple[int, int] | None = None) -> FormulaError:
    return FormulaError(Text(en, ru), span)


def _too_long() -> FormulaError:
    return _wrong(
        f"is longer than {LONGEST} signs; split it into several channels",
        f"длиннее {LONGEST} знаков; разделите на несколько каналов",
    )


def tree_of(line: str) -> ast.expr:
    """Return Python's tree of an expression. Raises as `ast.parse`.

    Python 3.11 counts the depth of all threads' trees in one place, so two that parse at the same
    time may fail (“AST constructor recursion depth mismatch”): then it is parsed again.
    """
    for _ in range(_TRIES):
        try:
            return ast.parse(line, mode="eval").body
        except (SystemError, RecursionError):
            continue
    return ast.parse(line, mode="eval").body


def _syntax(line: str, typed_at: list[int]) -> ast.expr:
    if "#" in line:  # a comment would hide the rest of the joined lines
        at = line.index("#")
        raise _wrong("has a “#” in it", "содержит «#»", (at, at + 1))
    _refuse_warned(line)
    try:
        return tree_of(line)
    except SyntaxError as error:
        if habit := _habit(line):
            raise habit from None
        place = error.offset or len(line) + 1  # no place: the end is missing
        raise _wrong(
            f"is not a formula: {error.msg} (character {typed_at[place - 1] + 1})",
            f"ошибка в записи (знак {typed_at[place - 1] + 1})",
            (place - 1, place),
        ) from None
    except (ValueError, RecursionError, MemoryError, SystemError) as error:
        raise _wrong(f"is not a formula: {error}", "ошибка в записи") from None


def _refuse_warned(line: str) -> None:
    """Refuse the text of which Python's parser would print a warning: `1if FREQ else 0`, `"\\d"`.

    To silence warnings is no way: their filters are those of all threads.
    """
    if (at := line.find("\\")) >= 0:
        raise _wrong("has a “\\” in it", "содержит «\\»", (at, at + 1))
    for found in _TOKENS.finditer(line):
        number, behind = found["number"], line[found.end() : found.end() + 1]
        if number and behind.isidentifier():
            raise _habit(line) or _wrong(
                f"is not a formula: a sign or a space is missing after “{number}”",
                f"ошибка в записи: после «{number}» не хватает знака или пробела",
                found.span(),
            )


def _habit(line: str) -> FormulaError | None:
    """Return what to write instead of the first thing that only other programs understand."""
    for pattern, instead in _HABITS:
        if found := pattern.search(line):
            seen, right = found[0], instead(found[0])
            return _wrong(
                f"is not a formula: “{seen}” is written “{right}”",
                f"ошибка в записи: вместо «{seen}» пишут «{right}»",
                found.span(),
            )
    return None


class _PlainForm:
    """Builds the plain form of an expression, of known nodes only."""

    def __init__(
        self, line: str, constants: Mapping[str, float], channel_of: Callable[[str], str]
    ) -> None:
        self._line = line.encode()
        self._constants = constants
        self._channel_of = channel_of
        self.names: dict[tuple[int, int], str] = {}
        """The channel at each place where another name of it stands."""
        self.inputs: dict[str, tuple[int, int]] = {}
        """The channels, each with its first place."""

    def expression(self, node: ast.expr, depth: int) -> Term:
        if depth > DEEPEST:
            raise _wrong(
                f"is nested more than {DEEPEST} levels deep; split it into several channels",
                f"вложенность больше {DEEPEST} уровней; разделите на несколько каналов",
            )
        match node:
            case ast.Constant(value=int() | float()):
                return _number(node)
            case ast.Name():
                return self._name(node)
            case ast.BinOp(op=operator) if sign := _OPERATORS.get(type(operator)):
                return self._operation(sign, [node.left, node.right], depth)
            case ast.UnaryOp(op=ast.Not()):
                return _where(self.expression(node.operand, depth + 1), 0.0, 1.0)
            case ast.UnaryOp(op=operator) if sign := _OPERATORS.get(type(operator)):
                return self._operation(sign, [node.operand], depth)
            case ast.Compare(ops=[operator]) if sign := _OPERATORS.get(type(operator)):
                return self._operation(sign, [node.left, *node.comparators], depth)
            case ast.Compare(ops=[_, _, *_]):
                raise _wrong(
                    "has a chain of comparisons; write “a < b and b < c”",
                    "содержит цепочку сравнений; пишите «a < b and b < c»",
                    self._span(node),
                )
            case ast.BoolOp():
                return self._bool_op(node, depth)
            case ast.IfExp():
                return self._operation("where", [node.test, node.body, node.orelse], depth)
            case ast.Call(func=ast.Name(id=name), keywords=[]):
                return self._call(name, node, depth)
        raise self._not_allowed(node)

    def _operation(self, name: str, nodes: list[ast.expr], depth: int) -> Term:
        return Operation(name, tuple(self.expression(each, depth + 1) for each in nodes))

    def _name(self, node: ast.Name) -> Term:
        if (constant := self._constants.get(node.id)) is not None:
            return float(constant)
        name, span = self._channel_of(node.id), self._span(node)
        if name != node.id.upper():
            self.names[span] = name
        self.inputs.setdefault(name, span)
        return name

    def _bool_op(self, node: ast.BoolOp, depth: int) -> Term:
        # From the right: each value becomes the condition of the next one. So the depth of the
        # plain form is the number of values.
        *before, last = (self.expression(it, depth + len(node.values)) for it in node.values)
        for value in reversed(before):
            is_and = isinstance(node.op, ast.And)
            last = _where(value, last, 0.0) if is_and else _where(value, 1.0, last)
        return last

    def _call(self, name: str, node: ast.Call, depth: int) -> Term:
        arguments = node.args
        if name not in FUNCTIONS:
            close = nearest(name, FUNCTIONS)
            known = close[0] if close else ", ".join(FUNCTIONS)
            raise _wrong(
                f"calls “{name}”, which there is not; there is {known}",
                f"функции «{name}» нет; есть {known}",
                self._span(node.func),
            )
        fewest, most = FUNCTIONS[name]
        if not fewest <= len(arguments) <= most:
            count = f"{fewest}" if fewest == most else f"{fewest}+"
            raise _wrong(
                f"gives “{name}” {len(arguments)} argument(s); it takes {count}",
                f"аргументов у «{name}»: {len(arguments)}, а нужно {count}",
                self._span(node),
            )
        return self._operation(name, arguments, depth)

    def _span(self, node: ast.expr) -> tuple[int, int]:
        """Return the first and the next character of `node`, whose offsets count bytes."""
        ends = (node.col_offset, node.end_col_offset or len(self._line))
        first, after = (len(self._line[:end].decode()) for end in ends)
        return first, after

    def _not_allowed(self, node: ast.expr) -> FormulaError:
        if isinstance(node, ast.Tuple) and (habit := _habit(self._line.decode())):
            return habit
        span = self._span(node)
        part = self._line[node.col_offset : node.end_col_offset].decode()
        part = part if len(part) <= 40 else f"{part[:40]}…"
        if isinstance(node, ast.BinOp) and (sign := _SIGNS.get(type(node.op))):
            part, behind = sign, self._span(node.left)[1]
            at = self._line.decode().find(sign, behind)
            span = (at, at + len(sign))
        return _wrong(
            f"has “{part}” in it; there are numbers, names, + - * / **, comparisons, and, or, not, "
            f"if … else, {', '.join(FUNCTIONS)}",
            f"содержит «{part}»; есть числа, имена, + - * / **, сравнения, and, or, not, "
            f"if … else, {', '.join(FUNCTIONS)}",
            span,
        )


def _number(node: ast.Constant) -> float:
    try:
        number = float(node.value)  # type: ignore[arg-type]  # its caller matched a number
    except OverflowError:
        number = float("inf")
    if isfinite(number):
        return number
    raise _wrong("has a number that is too large", "содержит слишком большое число")


def _where(condition: Term, then: Term, otherwise: Term) -> Term:
    return Operation("where", (condition, then, otherwise))
