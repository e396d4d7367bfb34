"""Whether it may be another unit by now that answers.

A response does not say whose it is (D13). Carrying the plug to another car takes a second or more,
in which whatever is asked is met by silence, and a tester that only repeats its request would take
the other car's answer for this one's. So after such a silence nothing is accepted before the
passports have been compared. A response that is lost or damaged now and then is no such silence.
"""

from __future__ import annotations

from collections.abc import Callable

from mikas.client import Ecu


class IdentityCheck:
    """`compare` raises what is in the way, or that it is another unit."""

    def __init__(self, compare: Callable[[Ecu], None]) -> None:
        self._compare = compare
        self._raised = False
        self._silences = 0

    def suspect(self) -> None:
        """A stream fell silent: that it is not the unit's own doing is not certain."""
        self._raised = True

    def confirm(self, ecu: Ecu) -> None:
        """Who is behind `ecu` has been found out just now."""
        self._raised = False
        self._silences = ecu.tester.silences

    def check(self, ecu: Ecu, pause: Callable[[], None]) -> None:
        """Compares, if there is any doubt. `pause` leaves the line free for it."""
        if self._raised or ecu.tester.silences != self._silences:
            pause()
            self._compare(ecu)
            self.confirm(ecu)
