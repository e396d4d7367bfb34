"""Checksums 0D and 40: which form the unit understands, and which it sends (D3).

Requests are lists of known codes (61) chosen so that the checksum is that byte; so are responses,
of codes whose data stand still.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager

from mikas.framing import Decoder, Frame, checksum
from mikas.survey.person import Prompter
from mikas.survey.steps.step import Measured
from mikas.survey.unit import SurveyedUnit

SPECIAL = (0x0D, 0x40)
FORMS = ("stuffed", "raw")
_LONGEST = 24  # codes in such a list
_TRIES = 8  # of a response, whose data may have moved


def accepted(unit: SurveyedUnit, measured: Measured, _: Prompter) -> None:
    """Send a request with each such checksum in each form; one that is not answered twice fails."""
    weights = {code: code for code in unit.sizes}
    found: dict[str, dict[str, bool]] = {}
    for value in SPECIAL:
        listed = _listed(weights, (-value - 0x61) & 0xFF, _room(measured))
        if listed is None:
            continue
        body = bytes([0x61, *listed])
        found[f"{value:02X}"] = {form: _answers(unit, body, listed, form) for form in FORMS}
    measured["checksum_accepted"] = found


def sent(unit: SurveyedUnit, measured: Measured, person: Prompter) -> None:
    """Read data whose checksum is such a byte, and look at its form on the wire."""
    found: dict[str, str] = {}
    for place, value in enumerate(SPECIAL):
        for done in range(_TRIES):
            person.progress(place * _TRIES + done, len(SPECIAL) * _TRIES)
            data = unit.data(sorted(unit.sizes))
            weights = {code: sum(raw) & 0xFF for code, raw in data.items()}
            listed = _listed(weights, -value & 0xFF, _room(measured))
            if listed is None:
                break
            reply = unit.ask(bytes([0x61, *listed]))
            if reply is None or checksum(reply.body) != value:
                continue
            frames = [each for each in Decoder().feed(reply.wire) if isinstance(each, Frame)]
            if len(frames) == 1:
                found[f"{value:02X}"] = FORMS[frames[0].raw_checksum]
                break
    measured["checksum_sent"] = found


def _room(measured: Measured) -> int:
    return min(_LONGEST, measured["lists"]["61"]["limit"] or 1)


def _answers(unit: SurveyedUnit, body: bytes, listed: tuple[int, ...], form: str) -> bool:
    with _sending(unit, form):
        reply = unit.ask(body)
    return reply is not None and len(reply.body) == sum(unit.sizes[code] for code in listed)


@contextmanager
def _sending(unit: SurveyedUnit, form: str) -> Iterator[None]:
    line = unit.tester.line
    usual, line.raw_checksum = line.raw_checksum, form == "raw"
    try:
        yield
    finally:
        line.raw_checksum = usual


def _listed(weights: Mapping[int, int], total: int, longest: int) -> tuple[int, ...] | None:
    """Return the shortest list of two codes or more whose weights sum to `total` modulo 256."""
    layer: dict[int, tuple[int, ...]] = {0: ()}
    for length in range(1, longest + 1):
        following: dict[int, tuple[int, ...]] = {}
        for at, listed in layer.items():
            for code, weight in weights.items():
                following.setdefault((at + weight) & 0xFF, (*listed, code))
        layer = following
        if length > 1 and total in layer:
            return layer[total]
    return None
