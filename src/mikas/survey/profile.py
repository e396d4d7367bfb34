"""`unit.json`: the unit's profile, from which a virtual unit is made that answers as it does.

A `null` was not found out: the virtual unit then follows the source's letter.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from mikas.commands.unit import PASSPORT_LENGTH, passport_text
from mikas.survey.answers import SurveyAnswer, SurveyVerdict
from mikas.survey.concluding.codes import moves_of
from mikas.survey.concluding.commands import support
from mikas.survey.steps.codes import known_sizes
from mikas.survey.steps.commands import PASSPORTS
from mikas.survey.steps.step import CarState, Measured

_LISTS = ("61", "64", "71")


def profile(measured: Measured, answers: Sequence[SurveyAnswer]) -> dict[str, Any]:
    """Return the profile as the JSON values of `unit.json`."""
    found = {each.id: each.value for each in answers if each.verdict is SurveyVerdict.FOUND}
    turn_round = found.get("turn_round") or {}
    known = support(measured)
    long_list, bad_write = found.get("long_list"), found.get("bad_write")
    return {
        "schema": 1,
        "version_code": measured["version_code"],
        "echo": measured["echo"],
        "turn_round": turn_round.get("median"),
        "turn_round_spread": turn_round.get("spread"),
        "inter_byte": found.get("inter_byte"),
        "least_pause": found.get("least_pause"),
        "supported": [code for code, is_known in known.items() if is_known],
        "missing": [code for code, is_known in known.items() if not is_known],
        "unknown": found.get("unknown"),
        "bad_write": bad_write if bad_write in ("01", "silent") else None,
        "counted_blocks": found.get("counted_blocks"),
        "max_block": min((found.get("max_block") or {}).values(), default=None),
        "max_list": {name: found.get(f"max_list_{name}") for name in _LISTS},
        "long_list": {"short": "short"}.get(str(long_list), "silent" if long_list else None),
        "accepts": found.get("checksum_accepted"),
        "sends": found.get("checksum_sent"),
        "stream_end": found.get("stream_end"),
        "stream_gap": found.get("stream_gap"),
        "stream_load": (found.get("stream_load") or {}).get("load"),
        "strokes": _strokes(found.get("strokes")),
        "codes": _codes(measured),
        "parameter_count": found.get("count"),
        "passports": _passports(measured),
        "faults": found.get("faults"),
    }


def _strokes(rates: dict[str, float | None] | None) -> dict[str, float] | None:
    if rates is None:
        return None
    return {code: rate for code, rate in rates.items() if rate is not None}


def _codes(measured: Measured) -> dict[str, Any] | None:
    """Return the codes; samples in the order that the virtual unit gives them in."""
    sizes = known_sizes(measured)
    if not sizes:
        return None
    samples = measured.get("samples", {})
    kinds = moves_of(samples)
    scanned = {**measured.get("codes", {}), **measured.get("codes_again", {})}
    found = {}
    for code, size in sorted(sizes.items()):
        name = f"{code:02X}"
        listed = [
            raw
            for state in CarState
            if state is not CarState.AFTER or kinds.get(name) == "other"
            for raw in samples.get(state.value, {}).get(name, ())
            if len(raw) == 2 * size
        ]
        moves = kinds.get(name, "constant")
        if moves != "other":
            listed = list(dict.fromkeys(listed))
        listed = listed or [scanned[name]["raw"]]
        found[name] = {"size": size, "samples": listed, "moves": moves}
    return found


def _passports(measured: Measured) -> list[str | None] | None:
    pieces = measured.get("passports")
    if pieces is None or not measured["passports_consent"]:
        return None
    found: list[str | None] = []
    for code in sorted(PASSPORTS):
        piece = pieces.get(f"{code:02X}")
        if piece is None or piece["raw"] is None or piece["bytes"] != PASSPORT_LENGTH:
            found.append(None)
        else:
            found.append(passport_text(bytes.fromhex(piece["raw"]).rstrip(b"\0")))
    return found
