"""The greatest lists of 61, 64 and 71, each found by itself (D11), with the engine standing.

64 sets the unit's list; a power cycle ends it. The data are of one byte, one code as often as it
takes: whether a unit counts codes or bytes is shown by a code of two bytes.
"""

from __future__ import annotations

from functools import partial
from typing import Any, Final

from mikas import commands as c
from mikas import errors
from mikas.survey.person import Prompter
from mikas.survey.steps.greatest import MOST, CountedResponse, greatest
from mikas.survey.steps.step import Measured
from mikas.survey.unit import SurveyedUnit

_TRIES = 18  # requests of one search, about


def lists(unit: SurveyedUnit, measured: Measured, person: Prompter) -> None:
    """Find the greatest list of each command that the unit has."""
    found: dict[str, dict[str, Any]] = {}
    codes = unit.one_byte_codes()
    for place, (name, ask) in enumerate(_LISTS.items()):

        def progress(done: int, place: int = place) -> None:
            person.progress(min(_TRIES * (place + 1) - 1, _TRIES * place + done), 3 * _TRIES)

        found[name] = {"limit": None, "beyond": None}
        # A unit that takes one code only has seemed to lack 71.
        if codes and (name == "71" or measured["commands"].get(name) is not False):
            found[name] = greatest(partial(ask, unit, c.Datum(codes[0], 1)), progress)
        if found[name]["limit"] is not None:
            measured["commands"][name] = True
    measured["lists"] = found
    measured["list_bytes"] = _takes_as_many_words(unit, found["61"]["limit"])


def _read(unit: SurveyedUnit, datum: c.Datum, count: int) -> CountedResponse:
    reply = unit.ask(bytes([0x61, *[datum.code] * count]))
    return CountedResponse.of(reply, count)


def _set(unit: SurveyedUnit, datum: c.Datum, count: int) -> CountedResponse:
    reply = unit.ask(bytes([0x64, *[datum.code] * count]))
    if reply is None:
        return CountedResponse(0, "silent")
    if reply.body == b"\x00":
        return CountedResponse(count, None)
    return CountedResponse(0, "01" if reply.body == b"\x01" else "other")


def _stream(unit: SurveyedUnit, datum: c.Datum, count: int) -> CountedResponse:
    """Start a stream (71), take its first response, and end it; silence is tried twice."""
    command = c.StreamCyclic((datum,) * count)
    line = unit.tester.line
    seconds = line.timing.response_timeout + line.timing.inter_byte_timeout
    for _ in range(2):
        response = CountedResponse(0, "silent")
        with unit.tester.stream(command) as stream:
            try:
                deadline = line.sent_at_latest + seconds + 3 * count * unit.tester.link.byte_time
                if stream.read(deadline, raise_errors=True) is not None:
                    response = CountedResponse(count, None)
            except errors.NotSupported:
                response = CountedResponse(0, "01")
            except errors.WrongLength as error:
                came = len(error.received or b"")
                response = CountedResponse(came, "short" if 0 < came < count else "other")
            except errors.LineError:
                response = CountedResponse(0, "other")
        if response.form not in ("silent", "other"):
            break
    return response


_LISTS: Final = {"61": _read, "64": _set, "71": _stream}


def _takes_as_many_words(unit: SurveyedUnit, limit: object) -> bool | None:
    """Whether a list of that many codes of two bytes comes whole; None: there is none to try."""
    words = [code for code, size in unit.sizes.items() if size == 2]
    if not words or not isinstance(limit, int) or not 1 < limit < MOST:
        return None
    reply = unit.ask(bytes([0x61, *[words[0]] * limit]))
    return CountedResponse.of(reply, limit, size=2).form is None
