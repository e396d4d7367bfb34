"""The causes of a car in its drives: what each drive's values say, in words."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import Final

from mikas.causes.result import LIKELIHOODS, CauseVerdict, Likelihood
from mikas.fleet.report.comparing import LATEST
from mikas.i18n import Text

MOST: Final = 10
"""Drives of a car whose causes are listed."""

_WORDS: Final = {
    CauseVerdict.SOUND: Text("sound", "исправна"),
    CauseVerdict.UNKNOWN: Text("unknown", "неизвестна"),
    CauseVerdict.CANNOT_TELL: Text("can't tell", "сказать нельзя"),
}


@dataclass(frozen=True, slots=True)
class JudgedDrive:
    """A dated drive with its verdict. `likelihood`, `text`: of the likeliest cause, if one is
    named.
    """

    began: datetime
    seconds: float
    verdict: CauseVerdict
    likelihood: Likelihood | None = None
    text: Text | None = None

    @property
    def words(self) -> Text:
        """The likeliest cause with its likelihood, or that there is none to name."""
        if (
            self.verdict is CauseVerdict.CAUSES
            and self.likelihood is not None
            and self.text is not None
        ):
            likely = LIKELIHOODS[self.likelihood]
            return Text(f"{likely.en}: {self.text.en}", f"{likely.ru}: {self.text.ru}")
        return _WORDS.get(self.verdict, _WORDS[CauseVerdict.CANNOT_TELL])


def latest(drives: Sequence[JudgedDrive]) -> JudgedDrive | None:
    """Return the latest drive that decides, of the last few; None: no drive was judged."""
    recent = drives[-LATEST:]
    deciding = (it for it in reversed(recent) if it.verdict is not CauseVerdict.CANNOT_TELL)
    return next(deciding, recent[-1] if recent else None)


def car_words(drives: Sequence[JudgedDrive]) -> Text | None:
    """Return the words of the car: of its latest drive that decides, and how many of the last
    few say the same.
    """
    decisive = latest(drives)
    if decisive is None:
        return None
    recent, words = drives[-LATEST:], decisive.words
    if len(recent) == 1:
        return words
    same = sum(it.verdict is decisive.verdict and it.text == decisive.text for it in recent)
    return Text(
        f"{words.en} ({same} of {len(recent)} drives)",
        f"{words.ru} (поездок: {same} из {len(recent)})",
    )
