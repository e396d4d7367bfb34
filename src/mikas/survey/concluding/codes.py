"""Conclusions on the codes of 61: which there are, their sizes, and what moves their data (§4)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from mikas.client import Answer
from mikas.i18n import counted
from mikas.survey.concluding.conclusion import Conclusion, found, is_open, unmeasured
from mikas.survey.steps.codes import known_sizes
from mikas.survey.steps.step import CarState, Measured

_RUNNING = (CarState.IDLE.value, CarState.WARM.value, CarState.RAISED.value, CarState.AFTER.value)
_AT_IDLE = (CarState.IDLE.value, CarState.WARM.value, CarState.AFTER.value)

_LISTED = 8  # unclear codes in a sentence


def codes(measured: Measured) -> Conclusion:
    """Conclude on the codes that 61 answers, and how it answers the others (D10)."""
    if "codes" not in measured:
        return unmeasured(measured, CarState.STANDING)
    sizes = known_sizes(measured)
    final = {**measured["codes"], **measured.get("codes_again", {})}
    unclear = [code for code, each in final.items() if each["answer"] == Answer.UNCLEAR.value]
    always_one = [code for code in unclear if _is_refused(measured, code)]
    unclear = [code for code in unclear if code not in always_one]
    number = {
        answer: sum(each["answer"] == answer.value for each in final.values()) for answer in Answer
    }
    value = {
        "sizes": {f"{code:02X}": size for code, size in sorted(sizes.items())},
        "refused": number[Answer.REFUSED] + len(always_one),
        "silent": number[Answer.SILENT],
        "unclear": unclear,
    }
    if not sizes:
        return is_open("61 gave no value", "команда 61 не дала ни одного значения", value)
    text = counted(len(sizes), ("code", "codes"), ("код", "кода", "кодов"))
    wide = [f"{code:02X}" for code, size in sorted(sizes.items()) if size > 1]
    en = f"{text.en} with a value, of more than one byte: {' '.join(wide) or '–'}"
    ru = f"{text.ru} со значением, длиннее байта: {' '.join(wide) or '–'}"
    en += f"; refused by 01: {value['refused']}, silent: {value['silent']}"
    ru += f"; отказ 01: {value['refused']}, молчание: {value['silent']}"
    if unclear:
        listed = " ".join([*unclear[:_LISTED], *["…"] * (len(unclear) > _LISTED)])
        return is_open(
            f"{en}; unclear {len(unclear)}: {listed}",
            f"{ru}; неясно {len(unclear)}: {listed}",
            value,
        )
    return found(value, en, ru)


def _is_refused(measured: Measured, code: str) -> bool:
    """Whether a unit that takes one code a request refuses this one by 01 (D10).

    A datum could be 01, too: it counts as a refusal if all of them are, of a unit that answers
    unknown commands so and was never silent.
    """
    scans = [measured[name] for name in ("codes", "codes_again") if name in measured]
    answers = [scan[code] for scan in scans if code in scan]
    by_one = set(measured.get("unknown", {}).values()) == {"01"}
    silent = any(each["answer"] == Answer.SILENT.value for scan in scans for each in scan.values())
    return by_one and not silent and all(each["raw"] == "01" for each in answers)


def moves(measured: Measured) -> Conclusion:
    """Conclude on what the data follow: the engine's speed, whether it runs, or something else."""
    samples = measured.get("samples", {})
    if CarState.STANDING.value not in samples:
        return unmeasured(measured, CarState.STANDING)
    kinds = moves_of(samples)
    if not any(state in samples for state in _RUNNING):
        constant = [code for code, kind in kinds.items() if kind == "constant"]
        missing = unmeasured(measured, CarState.IDLE).text
        return is_open(
            f"only with the engine standing, where these stand still: {' '.join(constant)}; "
            f"{missing.en}",
            f"только при заглушенном двигателе, неизменны: {' '.join(constant)}; {missing.ru}",
            kinds,
        )
    listed = {
        kind: " ".join(code for code, each in kinds.items() if each == kind) or "–"
        for kind in ("rpm", "key", "constant", "other")
    }
    en = (
        f"with rpm: {listed['rpm']}; with whether the engine runs: {listed['key']}; constant: "
        f"{listed['constant']}; else: {listed['other']}"
    )
    ru = (
        f"с оборотами: {listed['rpm']}; с тем, работает ли двигатель: {listed['key']}; неизменны: "
        f"{listed['constant']}; иначе: {listed['other']}"
    )
    if CarState.RAISED.value not in samples:
        missing = unmeasured(measured, CarState.RAISED).text
        return is_open(
            f"{en} (not at raised rpm: {missing.en})",
            f"{ru} (без поднятых оборотов: {missing.ru})",
            kinds,
        )
    return found(kinds, en, ru)


def moves_of(samples: Mapping[str, Mapping[str, Sequence[str]]]) -> dict[str, str]:
    """Return what each code follows, by the samples in each state of the car."""
    every = sorted({code for each in samples.values() for code in each})
    return {
        code: _follows({s: each[code] for s, each in samples.items() if each.get(code)})
        for code in every
    }


def _follows(samples: Mapping[str, Sequence[str]]) -> str:
    """Return what one code's data follow.

    `rpm`: at the raised speed they lie outside all that idle gave, by more than one step.
    `key`: with the engine standing they lie further from those of the running one than these from
    each other: a slow drift, as of a temperature, is no such step.
    """
    if len({raw for each in samples.values() for raw in each}) == 1:
        return "constant"
    standing = _span(samples, (CarState.STANDING.value,))
    idle, running = _span(samples, _AT_IDLE), _span(samples, _RUNNING)
    raised = _span(samples, (CarState.RAISED.value,))
    if idle and raised and _distance(idle, raised) > 1:
        return "rpm"
    if standing and running:
        width, step = running[1] - running[0], _distance(standing, running)
        if step > width and (step > 1 or running[1] <= 1):
            return "key"
    return "other"


def _span(samples: Mapping[str, Sequence[str]], states: Sequence[str]) -> tuple[int, int] | None:
    numbers = [
        int.from_bytes(bytes.fromhex(raw), "little")
        for state in states
        for raw in samples.get(state, ())
    ]
    return (min(numbers), max(numbers)) if numbers else None


def _distance(one: tuple[int, int], other: tuple[int, int]) -> int:
    return max(one[0] - other[1], other[0] - one[1])
