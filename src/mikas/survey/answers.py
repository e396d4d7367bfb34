"""The values of a survey: an answer to a question, and the clauses that it settles."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Any, Self

from mikas.i18n import Text

__all__ = ["SurveyAnswer", "SurveyVerdict"]


class SurveyVerdict(Enum):
    """Whether a question was answered."""

    FOUND = "found"
    """The unit has answered it."""
    OPEN = "open"
    """It was asked, and the answer is not certain; the text says why."""
    NOT_ASKED = "not-asked"
    """It was not asked; the text says why."""


@dataclass(frozen=True, slots=True)
class SurveyAnswer:
    """The answer to one question about one unit."""

    id: str
    """The question's name, as `turn_round`."""
    clauses: tuple[str, ...]
    """The clauses of the protocol that the question belongs to, as `D14`."""
    verdict: SurveyVerdict
    """Whether it was answered."""
    title: Text
    """The question in a few words."""
    text: Text
    """The answer in words; without one, the reason."""
    value: Any = None
    """The answer as JSON values; `None`: there is none."""

    def to_json(self) -> dict[str, Any]:
        """Return the answer as JSON values."""
        return {
            "id": self.id,
            "clauses": list(self.clauses),
            "verdict": self.verdict.value,
            "title": self.title._asdict(),
            "text": self.text._asdict(),
            "value": self.value,
        }

    @classmethod
    def from_json(cls, value: Any) -> Self:  # noqa: ANN401  (JSON)
        """Read what `to_json` returns. Raises `ValueError`, `TypeError` or `LookupError`."""
        return cls(
            str(value["id"]),
            tuple(str(clause) for clause in value["clauses"]),
            SurveyVerdict(value["verdict"]),
            _text(value["title"]),
            _text(value["text"]),
            value["value"],
        )


def _text(value: Any) -> Text:  # noqa: ANN401  (JSON)
    return Text(str(value["en"]), str(value["ru"]))
