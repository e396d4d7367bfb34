"""Whether a silence means a code that the unit does not know (D10), or a lost answer.

After each silence, codes are requested that the unit has answered. If a share `p` of those requests
fails, `n` silences of a known code in a row have the probability `p` to the power of `n`. So three
silences are enough on a sound line; with every third response in trouble it takes ten.
"""

from __future__ import annotations

from collections import Counter

from mikas.commands import Datum, ReadParameters
from mikas.errors import EcuRefused, LineError, SyncLost
from mikas.tester import Tester

_CHECKS = 16  # requests of a known code after a silence; on a sound line they take 0.2 s
_CHANCE = 1e-5  # below, the code is unknown to the unit
MOST_SILENCES = 30
"""Of one code; after so many without a result the line is too bad to know."""


class SilenceCheck:
    """The silences of one search for refused codes, against the line's trouble meanwhile."""

    def __init__(self, tester: Tester) -> None:
        self._tester = tester
        self._silences: Counter[Datum] = Counter()
        self._answered = self._failed = 0  # requests of known codes

    def is_unknown(self, silent: Datum, known: Datum) -> bool:
        """Count one more silence of `silent`; return whether the unit does not know the code.

        `known`: a datum that the unit has answered lately. Raises `SyncLost` or a `NoConnection`.
        """
        self._silences[silent] += 1
        for _ in range(_CHECKS):
            if not self._answers(known):
                self._failed += 1
                break
            self._answered += 1
        lost = (self._failed + 1) / (self._answered + self._failed + 2)
        return bool(lost ** self._silences[silent] < _CHANCE)

    def gives_up(self, silent: Datum) -> bool:
        """Whether `silent` had so many silences that more of them prove nothing."""
        return self._silences[silent] >= MOST_SILENCES

    def _answers(self, known: Datum) -> bool:
        try:
            self._tester.exchange(ReadParameters((known,)), retries=0)
        except SyncLost:
            raise
        except LineError:
            return False
        except EcuRefused:
            pass  # an answer as well
        return True
