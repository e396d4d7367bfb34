"""From measures to a verdict: the rules in their order, and how sure each is.

Every rule that holds is a finding, and the worst decides. A rule whose measures are missing can't
be decided, and where a rule of verdict `unknown` holds nothing can: then nothing is called good. A
rule that lacks only measures of optional steps that were not done is left out. A value within one
step of its channel from a limit lowers the confidence of what it decides.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import replace
from math import nan
from typing import Final, TypeAlias

from mikas.catalog.formulas import Calculation
from mikas.catalog.ignition_only import DEAD, SAID
from mikas.guided.definition import GuidedTest, Measure, Rule, VerdictKind
from mikas.guided.measuring import holds
from mikas.guided.result import Finding, Number
from mikas.i18n import Text, joined, unit_after
from mikas.recording.formatting import digits

_ORDER: Final = tuple(VerdictKind)


Verdict: TypeAlias = tuple[VerdictKind, tuple[Finding, ...], tuple[Text, ...]]
"""The outcome, the rules that hold, and why others could not be decided."""


def judge(
    test: GuidedTest,
    numbers: Mapping[str, Number],
    done: Collection[str],
    *,
    ignition_only: bool = False,
) -> Verdict:
    """Apply the rules of `test` to the numbers of its measures, with the steps that were `done`.

    On a unit that controls the ignition alone, rules over its dead channels are left out.
    """
    values = {name: nan if it.value is None else it.value for name, it in numbers.items()}
    found: list[Finding] = []
    good: list[Finding] = []
    missing: dict[Text, None] = {}
    near_limit: dict[Text, None] = {}
    left_out = {step.name for step in test.steps if step.optional and step.name not in done}
    dead = {it.name for it in test.measures.values() if ignition_only and _is_dead(it)}
    for rule in test.rules:
        calculation = Calculation(rule.when)
        if rule.ignition_only and not ignition_only:
            continue
        if not dead.isdisjoint(calculation.inputs):
            continue
        lacking = [numbers[name] for name in calculation.inputs if numbers[name].value is None]
        if lacking:
            if all(test.measures[it.name].step in left_out for it in lacking):
                continue
            missing |= {joined(": ", (it.text, it.why)): None for it in lacking}
            continue
        near = list(_near(calculation, values, test.measures))
        if rule.outcome is not VerdictKind.GOOD:
            near_limit |= dict.fromkeys(near)
        if not holds(calculation, values):
            continue
        if rule.outcome is VerdictKind.UNKNOWN:
            missing |= {_finding(rule, numbers, []).text: None}
        else:
            kept = good if rule.outcome is VerdictKind.GOOD else found
            kept.append(_finding(rule, numbers, near))
    if found:
        worst = max((it.outcome for it in found), key=_ORDER.index)
        return (worst, tuple(found), tuple(missing))
    if missing:
        return (VerdictKind.UNKNOWN, (), tuple(missing))
    if good:
        return (VerdictKind.GOOD, (_doubted(good[0], near_limit),), ())
    return (VerdictKind.UNKNOWN, (), (SAID if ignition_only else _NO_RULE,))


def _is_dead(measure: Measure) -> bool:
    """Whether a measure is made of channels that mean nothing on a unit without injection."""
    return any(not DEAD.isdisjoint(formula.inputs) for formula in measure.formulas)


def _finding(rule: Rule, numbers: Mapping[str, Number], near: list[Text]) -> Finding:
    shown = {name: it.shown for name, it in numbers.items()}
    made = Finding(
        rule=rule.name,
        formula=rule.formula,
        outcome=rule.outcome,
        text=rule.text.filled(**shown),
        check=rule.check.filled(**shown),
        doubt=rule.doubt.filled(**shown),
        confidence=rule.confidence,
    )
    return _doubted(made, dict.fromkeys(near))


def _doubted(finding: Finding, near: Mapping[Text, None]) -> Finding:
    """Return the finding with less confidence if values are `near` a limit."""
    more = [text for text in near if text.en not in finding.doubt.en]
    if not more:
        return finding
    doubt = joined(" ", [text for text in (finding.doubt, *more) if text.en])
    return replace(finding, doubt=doubt, confidence=finding.confidence.less)


def _near(
    calculation: Calculation, values: Mapping[str, float], measures: Mapping[str, Measure]
) -> Iterator[Text]:
    """Yield the measures by which the rule would turn over, one step of the channel away."""
    now = holds(calculation, values)
    for name in calculation.inputs:
        measure = measures[name]
        step = measure.resolution
        moved = ({**values, name: values[name] + sign * step} for sign in (-0.5, 0.5))
        if step and any(holds(calculation, each) is not now for each in moved):
            number = digits(step, measure.decimals)
            units = Text(*(f" {unit}" if unit else "" for unit in unit_after(number, measure.unit)))
            steps = joined("", (number, units))
            yield _NEAR.filled(text=measure.text, step=steps)


_NEAR: Final = Text(
    "“{text}” is within one step of its channel ({step}) from a limit of the rules.",
    "«{text}» отличается от границы правила меньше чем на один шаг канала ({step}).",
)
_NO_RULE: Final = Text(
    "no rule of the test fits these numbers", "к этим числам не подходит ни одно правило"
)
