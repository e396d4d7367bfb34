"""One plan on one unit, cycle after cycle, until something else is wanted or it has to be made
anew.
"""

from __future__ import annotations

from collections.abc import Generator, Iterator
from contextlib import suppress

from mikas.client import Ecu, Reading
from mikas.client.methods import STREAMS
from mikas.errors import EcuRefused, LineError, MikasError, NoConnection, SyncLost
from mikas.sampling.cycles import Asked, Cycles, cycles_of
from mikas.sampling.events import CycleFailed, Event
from mikas.sampling.identity_check import IdentityCheck
from mikas.sampling.plan import Plan
from mikas.sampling.reasons import reason
from mikas.sampling.session import Session, Wish
from mikas.sampling.unsupported import UnsupportedParameters

_BAD_LINE = 6  # failed cycles in a row after which another method may do better
_DOUBTS = 2  # of the unit's refusals in a row after which the method is given up


class Running:
    """Runs `plan`, which is made of `wish`."""

    def __init__(
        self,
        ecu: Ecu,
        plan: Plan,
        wish: Wish,
        *,
        session: Session,
        refusals: UnsupportedParameters,
        doubt: IdentityCheck,
    ) -> None:
        self._ecu = ecu
        self._plan = plan
        self._wish = wish
        self._session = session
        self._refusals = refusals
        self._now = ecu.tester.link.now
        self._cycles = cycles_of(ecu, plan, doubt)
        self._streams = plan.method in STREAMS
        # Between one-off requests a stream is not begun again: it is asked once, by 61.
        self._between = Asked(ecu, plan.by("batch"), doubt) if self._streams else self._cycles
        learning, baud = session.learning, ecu.tester.link.baud
        self._promise = None if wish.method else learning.rate_estimate(plan, baud)
        self._length = plan.price(baud=baud).seconds  # of a cycle, until one was measured
        self._failures = 0  # in a row
        self._doubts = 0  # of these, those that may be the unit's answer
        self._worked = False
        self._over = False

    def events(self) -> Iterator[Event]:
        """What happens. Raises the `NoConnection` or `SyncLost` that ends it, and what `strict`
        says.
        """
        number = 0
        try:
            while not self._over and self._session.is_current(self._wish):
                cycles = self._cycles
                if self._session.jobs:
                    yield from self._pause()
                    self._session.jobs.run(self._ecu)
                    cycles = self._between
                if not self._is_time_for(cycles):
                    continue
                yield from self._cycle(cycles, number)
                number += 1
        finally:
            with suppress(LineError):  # who comes next finds out how the line is
                self._cycles.pause()

    def _cycle(self, cycles: Cycles, number: int) -> Iterator[Event]:
        began = self._now()
        if not cycles.plan.asks(number):
            if cycles is self._cycles:
                self._session.rest(began, self._length)
            return
        try:
            fresh = cycles.run(number)
        except (NoConnection, SyncLost):
            raise
        except MikasError as error:
            yield CycleFailed(
                self._now(), reason(self._ecu, cycles.plan, error, worked=self._worked)
            )
            yield from self._after(error, cycles)
            return
        if cycles is self._cycles:
            self._length = self._now() - began
            self._hold_against_promise(began, whole=bool(fresh) or not self._streams)
        if fresh:
            yield from self._sampled(fresh)
        if len(fresh) < cycles.expected(number):
            wanted = self._plan.wanted
            self._over |= any(self._ecu.parameters.refuses([w.parameter]) for w in wanted)

    def _sampled(self, fresh: dict[str, Reading]) -> Iterator[Event]:
        self._failures = self._doubts = 0
        self._worked = True
        sampled = self._session.sampled(fresh)
        if self._session.in_time(sampled):
            yield sampled

    def _after(self, error: MikasError, cycles: Cycles) -> Iterator[Event]:
        """After `error`: is it the line, a parameter, or the method?"""
        strict = self._session.strict and not self._session.begun
        if strict and self._wish.method and not isinstance(error, LineError):
            raise error
        self._failures += 1
        if not isinstance(error, LineError | EcuRefused):
            self._doubts = _DOUBTS  # nobody allowed it
        elif cycles.let_down(error):
            self._doubts += 1
            weed = self._refusals.drop_unsupported(self._ecu, self._plan, self._wish, going=True)
            if (yield from weed) or not self._session.is_current(self._wish):
                self._over = True
                return
        if self._doubts >= _DOUBTS:
            self._session.learning.record_failure(self._plan.method)
            self._over = True
        elif self._failures >= _BAD_LINE and self._wish.method is None:
            self._session.learning.invalidate()
            self._over = True

    def _hold_against_promise(self, began: float, *, whole: bool) -> None:
        if self._promise is None:
            return
        kept = self._promise.count(self._now() - began, whole=whole)
        if kept is None:
            return
        self._promise = None
        if kept:
            self._session.learning.confirm()
        else:
            self._session.learning.invalidate()
            self._over = True

    def _is_time_for(self, cycles: Cycles) -> bool:
        """Waits for the next cycle's time; False: somebody wants something before. A stream keeps
        its own time, and what comes too early is left out.
        """
        if self._streams and cycles is self._cycles:
            return True
        return self._session.waited(self._ecu, self._wish)

    def _pause(self) -> Generator[Event, None, None]:
        try:
            self._cycles.pause()
        except LineError as error:
            yield CycleFailed(self._now(), error)
