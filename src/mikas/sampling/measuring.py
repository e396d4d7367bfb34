"""Finding out how fast a method is, while whoever wants something else gets it: what comes are
samples, other threads' requests go in between two cycles, and `stop` is heard.

A refusal may only mean that the list is too long (D11). The shortest, tried at once, tells; what is
refused then is not tried with any other.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator
from contextlib import closing
from dataclasses import replace

from mikas.client import Ecu, Reading
from mikas.errors import MikasError, NoConnection, SyncLost
from mikas.sampling.choosing import OF_THEIR_OWN, Measured, measure
from mikas.sampling.cycles import cycles_of
from mikas.sampling.events import CycleFailed, Event
from mikas.sampling.identity_check import IdentityCheck
from mikas.sampling.plan import Plan
from mikas.sampling.session import Session, Wish, datum_of

_SHORTEST = 2  # data: 01 can't be taken for that


class Measuring:
    """Measures methods and tells `session.learning`."""

    def __init__(self, session: Session, doubt: IdentityCheck) -> None:
        self._session = session
        self._doubt = doubt

    def learn(self, ecu: Ecu, plan: Plan, wish: Wish) -> Iterator[Event]:
        """Learns how fast `plan` is, unless something else than `wish` is wanted meanwhile."""
        measured = yield from self._measured(ecu, plan, wish)
        if measured is None:
            return
        self._session.learning.learn(measured, plan, ecu.tester.link.baud)
        if measured.refused and plan.method in OF_THEIR_OWN:
            yield from self._look_closer(ecu, plan, wish)

    def _measured(
        self, ecu: Ecu, plan: Plan, wish: Wish
    ) -> Generator[Event, None, Measured | None]:
        session, link = self._session, ecu.tester.link

        def run_pending(pause: Callable[[], None]) -> bool:
            if not session.jobs:
                return False
            pause()
            session.jobs.run(ecu)
            return True

        with closing(measure(ecu, plan, self._doubt, run_pending)) as found:
            while session.is_current(wish):
                try:
                    came = next(found)
                except StopIteration as end:
                    measured: Measured = end.value
                    return measured
                if isinstance(came, MikasError):
                    yield CycleFailed(link.now(), came)
                else:
                    yield from self._sampled(came)
        return None

    def _look_closer(self, ecu: Ecu, plan: Plan, wish: Wish) -> Iterator[Event]:
        """Its method was refused: so long a list, or any? Before and after it there are values."""
        short = yield from self._answered(ecu, plan)
        if short is None:
            return  # it may be the parameters
        if len(plan.fast) > len(short.fast):
            self._session.jobs.run(ecu)
            if not self._refused(ecu, short, wish):
                return
            yield from self._answered(ecu, plan)
        self._session.learning.lacks(plan.method)

    def _answered(self, ecu: Ecu, plan: Plan) -> Generator[Event, None, Plan | None]:
        """A cycle by 61. The shortest plan, by `plan`'s method, of what that brought."""
        session, now = self._session, ecu.tester.link.now
        try:
            fresh = cycles_of(ecu, plan.by("batch"), self._doubt).run(0)
        except (NoConnection, SyncLost):
            raise
        except MikasError as error:
            yield CycleFailed(now(), error)
            return None
        yield from self._sampled(fresh)
        size = min(_SHORTEST, session.learning.max_list)
        named = {datum_of(w.parameter): w for w in plan.wanted if w.parameter.name in fresh}
        short = tuple(replace(wanted, every=1) for wanted in list(named.values())[:size])
        return Plan(short, plan.method) if short else None

    def _sampled(self, fresh: dict[str, Reading]) -> Iterator[Event]:
        if fresh and self._session.in_time(sampled := self._session.sampled(fresh)):
            yield sampled

    def _refused(self, ecu: Ecu, short: Plan, wish: Wish) -> bool:
        """Whether the unit refuses it, as far as can be told while nothing else is wanted."""
        with closing(measure(ecu, short, self._doubt)) as found:
            while self._session.is_current(wish):
                try:
                    came = next(found)
                except StopIteration as end:
                    return bool(end.value.refused)
                if came and not isinstance(came, MikasError):
                    break
        return False
