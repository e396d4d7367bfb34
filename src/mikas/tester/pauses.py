"""The pause that a unit needs between its response and the next request (D14), found by trying.

Nothing says so of a Mikas; sibling units ignore a request that comes too soon. Such a unit answers
`01` alone but not in a row: a request without a response that followed the one before closely,
with no answered ones like it before, is what makes a tester try. Most units are never tried.
"""

from __future__ import annotations

from collections.abc import Callable

from mikas.errors import LineError, NoResponse
from mikas.tester.line import Line
from mikas.tester.line_sync import AVAILABILITY, LineSync

PAUSES = (0.025, 0.05, 0.1, 0.15)
"""The seconds that are tried, the shortest first; the first that works is taken."""
LONGEST_PAUSE = 2.0
"""s; the longest that can be set, or is believed of a saved one."""

_SOON = 2 * PAUSES[-1]  # s after a response; a later request was not too soon
_JITTER = 0.005  # s by which such times may differ
_PROOF = 4  # answers to requests in a row that came so soon: the unit needs no longer pause
_IN_A_ROW = 5  # requests that a pause has to bring to an answer, without an exception
_TRIED = 3  # requests in a row that show whether the present pause is enough,
_IGNORED = 2  # if fewer than these get no response: a single one may be lost on the line
_TRIALS = 3  # of one connection; silence after them has another reason


class Pauses:
    """The pause of one connection. `setting`: that of the user, None: found by trying.

    `found`: by trying, in this connection. The caller of `found_by_trying` holds the tester's lock.
    """

    def __init__(
        self, line: Line, sync: LineSync, setting: float | None, check: Callable[[], None]
    ) -> None:
        self.setting = setting
        self.found: float | None = None
        self._line = line
        self._sync = sync
        self._check = check  # raises if the call is to end
        self._opened = line.link.now()
        self._left = 0 if setting is not None else _TRIALS
        line.pause = setting or 0.0

    @property
    def seconds(self) -> float:
        """The pause in force."""
        return self._line.pause

    def assume(self, seconds: float) -> None:
        """Keep this pause, which an earlier session has found, unless this one knows better."""
        if self.setting is None and self.found is None:
            line = self._line
            line.pause = min(max(seconds, 0.0), LONGEST_PAUSE)
            line.heard = max(line.heard, self._opened)  # a session before may just have ended

    def on_other_unit(self) -> None:
        """Let another pause be assumed or found: the unit is not the one of before."""
        if self.setting is None:
            self.found, self._left = None, _TRIALS

    def restart(self) -> None:
        """Forget the pause of this unit: it is to be found again."""
        self.on_other_unit()
        self.assume(0.0)

    def suspects(self, error: LineError, *, known: bool) -> bool:
        """Whether the request that failed with `error` may have come too soon.

        Not if others that came as soon were answered. `known`: the unit has answered this command
        before. Silence to another one shows a lack of it as a rule (D10): it is looked into once.
        """
        if not isinstance(error, NoResponse) or error.received or self._line.gap >= _SOON:
            return False
        as_soon = sum(gap < self._line.gap + _JITTER for gap in self._line.answered_gaps)
        self._line.answered_gaps.clear()
        return as_soon < _PROOF and self._left > (0 if known else _TRIALS - 1)

    def connect_patiently(self) -> None:
        """Connect with the longest pause; `found_by_trying` then finds the one that is needed."""
        self._line.pause = PAUSES[-1]

    def found_by_trying(self, version_code: int, *, least: float | None = None) -> bool:
        """Try longer pauses than the present one, or than `least`; return whether one was found.

        Not if requests in a row are answered at that one already, nor if none of `PAUSES` brings
        each of them to an answer. Raises as `resynchronize`.
        """
        self._left -= 1
        line, before = self._line, self._line.pause if least is None else least
        found = None
        line.pause = before
        try:
            if self._ignored(version_code, _TRIED, _IGNORED) < _IGNORED:
                return False
            for line.pause in (each for each in PAUSES if each > before):
                if not self._ignored(version_code, _IN_A_ROW, 1):
                    found = self.found = line.pause
                    break
        finally:
            line.pause = before if found is None else found
        return found is not None

    def _ignored(self, version_code: int, count: int, most: int) -> int:
        """Return how many of `count` requests in a row failed; end once `most` are, or can't be."""
        failed = 0
        for left in reversed(range(count)):
            # After a failure a response comes first, which begins another row.
            begins = self._sync.lost
            failed += not ((not begins or self._send(version_code)) and self._send(version_code))
            if failed >= most or failed + left < most:
                break
        return failed

    def _send(self, version_code: int) -> bool:
        """Send `01`; return whether its response came. Raises as `resynchronize`."""
        self._check()
        self._sync.resynchronize(version_code)
        self._sync.mark_lost()
        try:
            reply = self._line.exchange(AVAILABILITY)
        except LineError as error:
            self._sync.mark_lost(error)
            return False
        if reply.body == bytes([version_code]):
            self._sync.keep()
        return not self._sync.lost
