"""A conclusion: the verdict on one question, drawn from measured figures."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from mikas.i18n import Text
from mikas.survey.answers import SurveyVerdict
from mikas.survey.steps.step import CarState, Measured


class Conclusion(NamedTuple):
    """The verdict, the answer in words, and as JSON values."""

    verdict: SurveyVerdict
    text: Text
    value: Any = None


Conclude = Callable[[Measured], Conclusion]


def found(value: object, en: str, ru: str) -> Conclusion:
    """Return an answer that the unit has given."""
    return Conclusion(SurveyVerdict.FOUND, Text(en, ru), value)


def is_open(en: str, ru: str, value: object = None) -> Conclusion:
    """Return an open question with its reason. `value`: the part of the answer that is known."""
    return Conclusion(SurveyVerdict.OPEN, Text(en, ru), value)


def not_asked(en: str, ru: str) -> Conclusion:
    """Return a question that was not asked, with the reason."""
    return Conclusion(SurveyVerdict.NOT_ASKED, Text(en, ru))


def unmeasured(measured: Measured, state: CarState) -> Conclusion:
    """Return the conclusion where a step of this state of the car has not been done."""
    for each in CarState:
        if (why := measured.get("skipped", {}).get(each.value)) is not None:
            return Conclusion(SurveyVerdict.NOT_ASKED, Text(why["en"], why["ru"]))
        if each is state:
            break
    return is_open(
        "the unit gave nothing to measure it by, or the survey was ended before",
        "блок не дал, по чему это измерить, или обследование прервано раньше",
    )


def no_codes() -> Conclusion:
    """Return the conclusion for a unit that answers no code."""
    return is_open(
        "command 61 gave no value, which this needs",
        "команда 61 не дала ни одного значения, а без этого не проверить",
    )


def milliseconds(seconds: float) -> tuple[str, str]:
    """Return a time as `2.1 ms`, `2,1 мс`."""
    number = f"{seconds * 1000:.3g}"
    return f"{number} ms", f"{number.replace('.', ',')} мс"


def ru(number: str) -> str:
    """Return a number with a decimal comma."""
    return number.replace(".", ",")
