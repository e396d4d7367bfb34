"""The times of single exchanges (D14): turn-round, pauses inside a response, the least pause."""

from __future__ import annotations

from math import ceil
from statistics import median

from mikas import commands as c
from mikas import errors
from mikas.survey.person import Prompter
from mikas.survey.steps.step import Measured
from mikas.survey.unit import SurveyedUnit

_TURNS = 40  # exchanges that time the turn-round
_LONG = 40  # bytes of the responses that show pauses between bytes, at least
_RESPONSES = 8
_PAUSES = (0.0, 0.025, 0.05, 0.1, 0.15, 0.25, 0.5, 1.0)  # s
_FINE = 0.002  # s
_TIMES = 3  # requests that a pause must let through
_TRIALS = 5  # of one pause, on a line that damages responses
_SEARCH = 40  # trials between two pauses, at most


def turn_round(unit: SurveyedUnit, measured: Measured, person: Prompter) -> None:
    """Time the responses to `01`, with the engine standing or running."""
    measured["turn_round"] = _delays(unit, person)


def turn_round_running(unit: SurveyedUnit, measured: Measured, person: Prompter) -> None:
    """Time them again while the unit is busy with ignition and injection."""
    measured["turn_round_running"] = _delays(unit, person)


def _delays(unit: SurveyedUnit, person: Prompter) -> list[float]:
    delays = []
    for done in range(_TURNS):
        _, reply = unit.tester.exchange(c.Availability())
        delays.append(round(max(0.0, reply.began - unit.tester.line.sent_until), 6))
        person.progress(done + 1, _TURNS)
    return delays


def inter_byte(unit: SurveyedUnit, measured: Measured, person: Prompter) -> None:
    """Time long responses: their duration beyond that of their bytes, for each pair of bytes."""
    codes = [code for code, size in sorted(unit.sizes.items()) if size < _LONG]
    if not codes:
        return
    times = ceil(_LONG / max(1, sum(unit.sizes[code] for code in codes)))
    body = bytes([0x61, *(codes * times)[: measured["lists"]["61"]["limit"] or 1]])
    pauses, longest = [], 0
    for done in range(_RESPONSES):
        reply = unit.ask(body)
        if reply is not None and len(reply.wire) > 2:
            beyond = reply.ended - reply.began - len(reply.wire) * unit.tester.link.byte_time
            pauses.append(round(max(0.0, beyond / (len(reply.wire) - 1)), 7))
            longest = max(longest, len(reply.wire))
        person.progress(done + 1, _RESPONSES)
    if pauses:
        measured["inter_byte"] = {"pauses": pauses, "bytes": longest}


def least_pause(unit: SurveyedUnit, measured: Measured, person: Prompter) -> None:
    """Find the least time from a response to a request that is answered, by trying shorter ones."""
    pause, refused = None, []
    for done, seconds in enumerate(_PAUSES):
        person.progress(done, len(_PAUSES))
        if _answered_after(unit, seconds):
            pause = seconds
            break
        refused.append(seconds)
    for _ in range(_SEARCH):
        if pause is None or not refused:
            break
        if pause - refused[-1] > _FINE:
            middle = (refused[-1] + pause) / 2
            if _answered_after(unit, middle):
                pause = middle
            else:
                refused.append(middle)
        elif _answered_after(unit, refused[-1]):
            pause = refused.pop()  # the line had lost that request, not the unit
        else:
            break
    measured["least_pause"] = {
        "pause": None if pause is None else round(pause, 6),
        "unanswered": [round(seconds, 6) for seconds in refused],
    }


def _answered_after(unit: SurveyedUnit, seconds: float) -> bool:
    """Whether `01` is answered each time when it follows a response after `seconds`.

    A trial in which the line has damaged a response is none: what follows that one comes sooner.
    """
    for _ in range(_TRIALS):
        try:
            with unit.without_pause():
                return _is_answered(unit, seconds)
        except (errors.SyncLost, errors.LineNotQuiet):
            raise
        except errors.LineError:
            continue
    return False


def _is_answered(unit: SurveyedUnit, seconds: float) -> bool:
    request = c.Availability().body()
    unit.tester.sync.resynchronize(unit.ecu.version_code)
    unit.pause(_PAUSES[-1])  # the response of a resynchronization may be the latest
    reply = unit.ask(request, times=1, damages=1)
    for _ in range(_TIMES):
        if reply is None:
            return False
        if seconds:
            unit.pause(seconds - (unit.now() - reply.ended))
        reply = unit.ask(request, times=1, damages=1)
    return reply is not None


def slowest(measured: Measured) -> float:
    """Return the longest turn-round so far, strays left out."""
    delays = sorted(measured.get("turn_round", ()))
    return max(median(delays), delays[-len(delays) // 10]) if delays else 0.5
