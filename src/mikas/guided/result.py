"""The result of a test: its verdict with rules, numbers and doubt. Also as JSON, and as text.

The JSON is a note of a recording and a file of the state folder, so anything may be in it: `read`
bounds every part, and returns None if the JSON is not a result.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, is_dataclass, replace
from functools import partial
from math import isfinite
from typing import Any, Final, get_args, get_type_hints

from mikas.cleaning import clean_line, clean_text, is_in_calendar
from mikas.guided.definition import Certainty, VerdictKind
from mikas.i18n import Language, Text, joined, unit_after
from mikas.json_values import json_of
from mikas.recording.formatting import digits

_LONGEST: Final = 4000  # characters of a text
_MOST: Final = 60  # steps, numbers, findings
_MOST_CURVES: Final = 12
MOST_POINTS: Final = 400  # of a curve


@dataclass(frozen=True, slots=True)
class Number:
    """A measure. `value` None: not measured, for the reason `why`. `count`: the readings that it is
    made of; `rate`: those a second, 0: unknown.
    """

    name: str
    text: Text
    value: float | None
    unit: Text
    decimals: int
    count: int
    rate: float
    why: Text

    @property
    def shown(self) -> Text:
        """The value with its unit; a dash without one."""
        if self.value is None:
            return Text("—", "—")
        number = digits(self.value, self.decimals)
        units = unit_after(number, self.unit)
        spaced = Text(*(f" {unit}" if unit not in ("", "°") else unit for unit in units))
        return joined("", (number, spaced))


@dataclass(frozen=True, slots=True)
class Finding:
    """A rule that holds: its formula, and its texts with the values filled in."""

    rule: str
    formula: str
    outcome: VerdictKind
    text: Text
    check: Text
    doubt: Text
    confidence: Certainty

    @property
    def grounds(self) -> Text:
        """The rule, how sure it is, and what speaks against it."""
        sure = _SURE[self.confidence]
        filled = _GROUNDS.filled(formula=self.formula, sure=sure, doubt=self.doubt)
        return Text(*map(str.rstrip, filled))


@dataclass(frozen=True, slots=True)
class StepDone:
    """A step and its time. `skipped`: by the user, so its numbers are missing."""

    name: str
    text: Text
    began: float
    ended: float
    skipped: bool


@dataclass(frozen=True, slots=True)
class Curve:
    """A channel over the test: lowest and highest value from each of `times` to the next."""

    name: str
    text: Text
    unit: Text
    times: tuple[float, ...]
    lows: tuple[float, ...]
    highs: tuple[float, ...]

    def __post_init__(self) -> None:
        if not len(self.times) == len(self.lows) == len(self.highs):
            raise ValueError("columns of different lengths")


@dataclass(frozen=True, slots=True)
class TestResult:
    """A finished test. `missing`: why rules could not be decided."""

    __test__ = False  # for pytest

    test: str
    title: Text
    began: float
    ended: float
    outcome: VerdictKind
    findings: tuple[Finding, ...]
    missing: tuple[Text, ...]
    numbers: tuple[Number, ...]
    steps: tuple[StepDone, ...]
    curves: tuple[Curve, ...]

    def moved(self, seconds: float) -> TestResult:
        """Return the result that is `seconds` later."""
        steps = tuple(
            replace(it, began=it.began + seconds, ended=it.ended + seconds) for it in self.steps
        )
        curves = tuple(
            replace(it, times=tuple(time + seconds for time in it.times)) for it in self.curves
        )
        began, ended = self.began + seconds, self.ended + seconds
        return replace(self, began=began, ended=ended, steps=steps, curves=curves)

    @property
    def verdict(self) -> Text:
        """The verdict in a sentence."""
        leading = [each.text for each in self.findings if each.outcome is self.outcome]
        if leading:
            return leading[0]
        return Text(
            "Can't tell: the data do not decide it.", "Нельзя сказать: по этим данным не решить."
        )

    def as_json(self) -> dict[str, Any]:
        """Return the result as JSON values."""
        form: dict[str, Any] = json_of(self)
        return form

    def as_text(self) -> Text:
        """Return the result as lines of text, for a message or a terminal."""
        return Text("\n".join(self._lines("en")), "\n".join(self._lines("ru")))

    def _lines(self, language: Language) -> list[str]:
        def words(text: Text) -> str:
            return text.to(language)

        lines = [f"{words(self.title)}: {words(OUTCOMES[self.outcome])}", words(self.verdict)]
        lines += [
            words(each.text)
            for each in self.findings
            if each.text != self.verdict and each.outcome is not VerdictKind.GOOD
        ]
        for each in self.findings:
            if each.check.en:
                lines.append(f"{words(CHECK)} {words(each.check)}")
        lines += [f"{words(MISSING)} {words(each)}" for each in self.missing]
        lines += [
            f"{words(each.text)}: {words(each.shown)}"
            + (f" ({words(each.why)})" if each.value is None else "")
            for each in self.numbers
        ]
        return [*lines, *(words(each.grounds) for each in self.findings)]


OUTCOMES: Final[Mapping[VerdictKind, Text]] = {
    VerdictKind.GOOD: Text("good", "в порядке"),
    VerdictKind.ATTENTION: Text("attention", "обратите внимание"),
    VerdictKind.BAD: Text("bad", "неисправно"),
    VerdictKind.UNKNOWN: Text("can't tell", "нельзя сказать"),
}
_SURE: Final[Mapping[Certainty, Text]] = {
    Certainty.HIGH: Text("confidence: high", "уверенность: высокая"),
    Certainty.MEDIUM: Text("confidence: medium", "уверенность: средняя"),
    Certainty.LOW: Text("confidence: low", "уверенность: низкая"),
}
CHECK: Final = Text("Check next:", "Проверьте дальше:")
MISSING: Final = Text("Not decided:", "Не решено:")
_GROUNDS: Final = Text("Rule: {formula}; {sure}. {doubt}", "Правило: {formula}; {sure}. {doubt}")


def read(data: object) -> TestResult | None:
    """Return the result in JSON values from a file; None for anything else."""
    try:
        found: TestResult = _read(TestResult, data)
    except (KeyError, TypeError, ValueError, OverflowError):
        return None
    return found


def _read(kind: Any, value: Any) -> Any:  # noqa: ANN401  (any JSON)
    """Return a value of a type: a dataclass with each field by its name or its type, or a tuple."""
    if kind in _BY_TYPE:
        return _BY_TYPE[kind](value)
    if isinstance(kind, type) and is_dataclass(kind):
        readers = {
            name: _BY_NAME.get(name) or partial(_read, of)
            for name, of in get_type_hints(kind).items()
        }
        return kind(**{name: read(value[name]) for name, read in readers.items()})
    return tuple(_read(get_args(kind)[0], each) for each in _list(value))


def _list(value: object) -> list[Any]:
    if not isinstance(value, list):
        raise TypeError("no list")
    return value[:_MOST]


def _line(value: object) -> str:
    if not isinstance(value, str):
        raise TypeError("no text")
    return clean_line(value, _LONGEST)


def _both(value: Any) -> Text:  # noqa: ANN401  (any JSON)
    en, ru = value["en"], value["ru"]
    if not isinstance(en, str) or not isinstance(ru, str):
        raise TypeError("no text")
    return Text(clean_text(en, _LONGEST), clean_text(ru, _LONGEST))


def _number(value: object) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not isfinite(value):
        raise TypeError("no number")
    return float(value)


def _time(value: object) -> float:
    time = _number(value)
    if not is_in_calendar(abs(time)):
        raise ValueError("no time of the calendar")
    return time


_BY_NAME: Final[Mapping[str, Callable[[Any], Any]]] = {
    "began": _time,
    "ended": _time,
    "decimals": lambda value: min(4, max(0, int(value))),
    "curves": lambda value: _read(tuple[Curve, ...], _list(value)[:_MOST_CURVES]),
}
_BY_TYPE: Final[Mapping[object, Callable[[Any], Any]]] = {
    str: _line,
    Text: _both,
    bool: lambda value: value is True,
    int: lambda value: int(min(1e9, max(0.0, _number(value)))),
    float: _number,
    float | None: lambda value: None if value is None else _number(value),
    tuple[float, ...]: lambda value: tuple(map(_number, value[:MOST_POINTS])),
    VerdictKind: VerdictKind,
    Certainty: Certainty,
}
