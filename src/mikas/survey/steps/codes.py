"""The codes 00–FF that 61 answers, and samples of their data in each state of the car (§4, D10)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from mikas.client import Answer
from mikas.client.parameters.data import COMMON
from mikas.client.scanning import Scan
from mikas.survey.person import Prompter
from mikas.survey.steps.step import Measured
from mikas.survey.steps.timing import slowest
from mikas.survey.unit import SurveyedUnit

_ROUNDS = 4  # samples of each code in one state
_APART = 0.25  # s


def scan(unit: SurveyedUnit, measured: Measured, person: Prompter) -> None:
    """Request every code once. Each result is kept at once, for a survey that is stopped."""
    found = measured.setdefault("codes", {})
    known = [*(datum.code for datum in COMMON), *(code for code, _ in unit.catalog.codes)]
    left = {code for code in range(0x100) if f"{code:02X}" not in found}
    order = dict.fromkeys([code for code in known if code in left])
    with unit.hasty(slowest(measured)):
        _scan(unit, found, person, [*order, *sorted(left - order.keys())])


def scan_again(unit: SurveyedUnit, measured: Measured, person: Prompter) -> None:
    """Request the codes again that were silent or unclear: with the engine running some may come.

    Without an engine it is their second request. Codes of the catalog that stay silent are asked
    for without haste: the line may have lost both requests.
    """
    again = measured.setdefault("codes_again", {})
    left = [
        int(code, 16)
        for code, each in measured["codes"].items()
        if each["answer"] in (Answer.SILENT.value, Answer.UNCLEAR.value) and code not in again
    ]
    if left:  # the first one shows how the unit is to be asked
        known = [code for code in unit.sizes if unit.sizes[code] == 1][:1]
        with unit.hasty(slowest(measured)):
            _scan(unit, again, person, [*known, *left], once=True)
        named = [code for code in left if unit.catalog.size_of(code) and _is_silent(again, code)]
        if named:
            _scan(unit, again, person, [*known, *named], once=True)


def _is_silent(found: dict[str, Any], code: int) -> bool:
    return bool(found[f"{code:02X}"]["answer"] == Answer.SILENT.value)


def _scan(
    unit: SurveyedUnit,
    found: dict[str, Any],
    person: Prompter,
    codes: Sequence[int],
    *,
    once: bool = False,
) -> None:
    """Request `codes`; `once`: as of `Scan`."""
    for done, each in enumerate(Scan(unit.tester, codes, (), once=once).codes(), 1):
        found[f"{each.code:02X}"] = {"answer": each.answer.value, "raw": each.raw.hex().upper()}
        if each.answer is Answer.DATUM:
            unit.sizes[each.code] = each.size
        person.progress(min(done, len(codes)), len(codes))


def known_sizes(measured: Measured) -> dict[int, int]:
    """Return the sizes of the codes that have answered, by code."""
    return {
        int(code, 16): len(each["raw"]) // 2
        for name in ("codes", "codes_again")
        for code, each in measured.get(name, {}).items()
        if each["answer"] == Answer.DATUM.value and each["raw"]
    }


def sample(unit: SurveyedUnit, measured: Measured, person: Prompter, state: str) -> None:
    """Read the data of every known code several times, with the engine's speed."""
    codes = sorted(unit.sizes)
    samples: dict[str, list[str]] = {}
    for done in range(_ROUNDS):
        if done:
            unit.pause(_APART)
        for code, raw in unit.data(codes).items():
            samples.setdefault(f"{code:02X}", []).append(raw.hex().upper())
        person.progress(done + 1, _ROUNDS)
    measured.setdefault("samples", {})[state] = samples
