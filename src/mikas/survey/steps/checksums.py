"""Checksums 0D and 40: which form the unit understands, and which it sends (D3).

Requests are lists of known codes (61) chosen so that the checksum is that byte; so are responses,
of codes whose data stand still. A unit that takes one code only has no such list: there a byte of
RAM (11) does it, if memory may be read; all of RAM is recorded only if passports may be kept.
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
_RAM = 0x11  # reads one byte; its response repeats the address
_LONGEST = 24  # codes in such a list
_TRIES = 8  # of a response, whose data may have moved


def accepted(unit: SurveyedUnit, measured: Measured, _: Prompter) -> None:
    """Send a request with each such checksum in each form; one that is not answered twice fails."""
    weights = {code: code for code in unit.sizes}
    found: dict[str, dict[str, bool]] = {}
    for value in SPECIAL:
        listed = listed_codes(weights, (-value - 0x61) & 0xFF, _room(measured))
        if listed is not None:
            body, length = bytes([0x61, *listed]), sum(unit.sizes[code] for code in listed)
        elif _reads_ram(measured):
            body, length = bytes([_RAM, (-value - _RAM) & 0xFF]), 2
        else:
            continue
        found[f"{value:02X}"] = {form: _answers(unit, body, length, form) for form in FORMS}
    measured["checksum_accepted"] = found


def sent(unit: SurveyedUnit, measured: Measured, person: Prompter) -> None:
    """Read data whose checksum is such a byte, and look at its form on the wire."""
    found: dict[str, str] = {}
    for place, value in enumerate(SPECIAL):
        for done in range(_TRIES):
            person.progress(place * _TRIES + done, len(SPECIAL) * _TRIES)
            data = unit.data(sorted(unit.sizes))
            weights = {code: sum(raw) & 0xFF for code, raw in data.items()}
            listed = listed_codes(weights, -value & 0xFF, _room(measured))
            if listed is None:
                break
            if (form := _form_of(unit, bytes([0x61, *listed]), value)) is not None:
                found[f"{value:02X}"] = form
                break
        if f"{value:02X}" not in found and _reads_ram(measured):
            forms = (_form_of(unit, bytes([_RAM, address]), value) for address in range(0x100))
            with unit.recording_paused(paused=not measured["passports_consent"]):
                form = next(filter(None, forms), None)
            if form is not None:
                found[f"{value:02X}"] = form
    measured["checksum_sent"] = found


def _form_of(unit: SurveyedUnit, body: bytes, value: int) -> str | None:
    """Return the form of the response's checksum; None: it is not `value`."""
    reply = unit.ask(body)
    if reply is None or checksum(reply.body) != value:
        return None
    frames = [each for each in Decoder().feed(reply.wire) if isinstance(each, Frame)]
    return FORMS[frames[0].raw_checksum] if len(frames) == 1 else None


def _reads_ram(measured: Measured) -> bool:
    return bool(measured["memory"] and measured["commands"].get(f"{_RAM:02X}"))


def _room(measured: Measured) -> int:
    return min(_LONGEST, measured["lists"]["61"]["limit"] or 1)


def _answers(unit: SurveyedUnit, body: bytes, length: int, form: str) -> bool:
    with _sending(unit, form):
        reply = unit.ask(body)
    return reply is not None and len(reply.body) == length


@contextmanager
def _sending(unit: SurveyedUnit, form: str) -> Iterator[None]:
    line = unit.tester.line
    usual, line.raw_checksum = line.raw_checksum, form == "raw"
    try:
        yield
    finally:
        line.raw_checksum = usual


def listed_codes(weights: Mapping[int, int], total: int, longest: int) -> tuple[int, ...] | None:
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
