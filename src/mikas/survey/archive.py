"""The ZIP of a survey: answers, the unit's profile, raw bytes, and words on what it holds.

Its members have one date, so that a file says nothing of when and where it was made. It is read
within bounds: a ZIP of gigabytes, or with other members, is refused.
"""

from __future__ import annotations

import json
import zipfile
from collections.abc import Sequence
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import Any, Final

from mikas.cleaning import clean_json
from mikas.errors import UsageError, naming_file, usage_error
from mikas.files import open_regular
from mikas.files.archives import SAVED, Archive
from mikas.i18n import Text
from mikas.survey.answers import SurveyAnswer

__all__ = ["SurveyFile", "read_survey"]

SCHEMA: Final = 1
_DATE: Final = (1980, 1, 1, 0, 0, 0)
_MEMBERS: Final = {
    "survey.json": 1 << 24,
    "unit.json": 1 << 22,
    "capture.pcapng": 1 << 27,
    "README.txt": 1 << 20,
}
"""The members and the most bytes of each."""


@dataclass(frozen=True, slots=True)
class SurveyFile:
    """The content of a survey's ZIP."""

    answers: tuple[SurveyAnswer, ...]
    """The answers, as they were concluded when it was made."""
    measured: dict[str, Any]
    """The figures behind them, for `conclude`."""
    unit: dict[str, Any]
    """The profile of the unit, as the JSON of `unit.json`."""
    versions: dict[str, Any]
    """The versions of mikas and of its catalog that made it."""
    capture: bytes
    """The raw bytes, a pcapng file."""


def archive(content: SurveyFile, readme: str) -> bytes:
    """Return the ZIP of `content`; equal content gives equal bytes."""
    survey = {
        "schema": SCHEMA,
        "versions": content.versions,
        "answers": [answer.to_json() for answer in content.answers],
        "measured": content.measured,
    }
    members = {
        "README.txt": readme.encode(),
        "survey.json": _json(survey),
        "unit.json": _json(content.unit),
        "capture.pcapng": content.capture,
    }
    file = BytesIO()
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as packed:
        for name, data in members.items():
            packed.writestr(zipfile.ZipInfo(name, _DATE), data, zipfile.ZIP_DEFLATED)
    return file.getvalue()


def read_survey(path: Path) -> SurveyFile:
    """Read a survey's ZIP. Raises `UsageError` with the file and its fault."""
    with naming_file(path), open_regular(path) as file:
        packed = Archive(file, SAVED)
        members = {name: packed.read(name, most) for name, most in _MEMBERS.items()}
    try:
        survey = json.loads(members["survey.json"])
        unit = json.loads(members["unit.json"])
        if survey["schema"] != SCHEMA:
            raise _wrong(path, _OTHER_VERSION)
        return SurveyFile(
            _answers(survey["answers"]),
            _object(clean_json(survey["measured"])),
            _object(clean_json(unit)),
            _object(clean_json(survey["versions"])),
            members["capture.pcapng"],
        )
    except UsageError:
        raise
    except _UNFIT as error:
        raise _wrong(path, _NO_SURVEY) from error


_UNFIT: Final = (ValueError, TypeError, LookupError, RecursionError)
"""What the members of another archive raise."""
_NO_SURVEY: Final = Text(
    "this is no survey's ZIP, which “mikas survey -o FILE.zip” saves, or a damaged one",
    "это не ZIP обследования, какой сохраняет «mikas survey -o ФАЙЛ.zip», или он повреждён",
)
_OTHER_VERSION: Final = Text(
    "another version of mikas has made this survey",
    "это обследование сделано другой версией mikas",
)


def _answers(values: Sequence[Any]) -> tuple[SurveyAnswer, ...]:
    return tuple(SurveyAnswer.from_json(clean_json(value)) for value in values)


def _object(value: object) -> dict[str, Any]:
    if not isinstance(value, dict):
        raise TypeError("no JSON object")
    return value


def _wrong(path: Path, problem: Text) -> UsageError:
    return usage_error(f"{path}: {problem.en}", f"{path}: {problem.ru}")


def _json(value: object) -> bytes:
    return json.dumps(value, ensure_ascii=False, indent=1).encode()
