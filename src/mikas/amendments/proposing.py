"""From a survey's ZIP to the amendments: its figures are concluded again, by the rules of today."""

from __future__ import annotations

import json
from dataclasses import dataclass
from hashlib import sha256
from io import BytesIO
from pathlib import Path
from typing import Final

from mikas.amendments import clauses, parameters
from mikas.amendments.amendment import Amendment
from mikas.amendments.parameters import EVEN_OPEN
from mikas.catalog import Catalog
from mikas.commands.unit import version_text
from mikas.errors import UsageError, usage_error
from mikas.i18n import joined
from mikas.recording.capture.reader import Blocks, Packet
from mikas.recording.capture.scan import scan
from mikas.survey import SurveyAnswer, SurveyFile, SurveyVerdict, conclude, read_survey
from mikas.survey.recording import NO_UNITS
from mikas.virtual.unit_profile import UnitProfile

__all__ = ["Proposal", "propose"]

_JUDGES: Final = {**clauses.JUDGES, **parameters.JUDGES}
_UNFIT: Final = (ValueError, TypeError, LookupError, AttributeError, ArithmeticError)
"""What the figures of a file raise that no survey has made."""


@dataclass(frozen=True, slots=True)
class Proposal:
    """What the survey of one unit would change."""

    unit: str
    """The unit: its answer to 01, and a mark of the survey: `0A, survey 3f2a90c1`.

    A virtual unit is called so: it is evidence of nothing.
    """
    is_virtual: bool
    """Whether it is a virtual unit in this program."""
    amendments: tuple[Amendment, ...]
    """In the order of the survey's questions."""
    open: tuple[SurveyAnswer, ...]
    """The questions that it leaves open."""


def propose(path: Path, catalog: Catalog) -> Proposal:
    """Return what the survey in that ZIP would change in `catalog`.

    Raises `UsageError` with the file: it is no survey.
    """
    file = read_survey(path)
    try:
        answers = conclude(file.measured)
        if not (ports := _ports(file.capture)):
            raise usage_error(
                f"{path}: its capture has no byte of the line: without them its figures are "
                "evidence of nothing. Survey the unit again",
                f"{path}: в нём нет записи линии: без неё измеренные числа ничего не доказывают. "
                "Обследуйте блок ещё раз",
            )
        virtual = not ports.isdisjoint(NO_UNITS)  # one byte from there is enough
        unit = _mark(file, path, is_virtual=virtual)
        found = {answer.id: tuple(_amended(answer, catalog)) for answer in answers}
    except UsageError:
        raise
    except _UNFIT as error:
        raise usage_error(
            f"{path}: its figures are none that a survey measures",
            f"{path}: таких измерений в обследовании не бывает",
        ) from error
    is_open = (SurveyVerdict.OPEN, SurveyVerdict.NOT_ASKED)
    return Proposal(
        unit,
        virtual,
        tuple(each for amended in found.values() for each in amended),
        tuple(each for each in answers if each.verdict in is_open),
    )


def _mark(file: SurveyFile, path: Path, *, is_virtual: bool) -> str:
    """Return the model and a mark of the figures: nothing of the owner, nor of the day."""
    code = version_text(UnitProfile.from_json(file.unit, str(path)).version_code)
    figures = json.dumps(file.measured, sort_keys=True).encode()
    virtual = "virtual " if is_virtual else ""
    return f"{virtual}{code or '??'}, survey {sha256(figures).hexdigest()[:8]}"


def _ports(capture: bytes) -> set[str]:
    """Return what the ports are called that the bytes came from: a survey may go on at another."""
    blocks = Blocks()
    return {
        each.source.url.partition(":")[0]
        for item in scan(BytesIO(capture))
        for each in blocks.read(item)
        if isinstance(each, Packet)
    }


def _amended(answer: SurveyAnswer, catalog: Catalog) -> list[Amendment]:
    judge = _JUDGES.get(answer.id)
    is_open = answer.verdict is not SurveyVerdict.FOUND
    if judge is None or answer.value is None or (is_open and answer.id not in EVEN_OPEN):
        return []
    own = joined(": ", (answer.title, answer.text))
    return [
        Amendment(each.of, each.agreement, each.text or own, each.changes)
        for each in judge(answer.value, catalog)
    ]
