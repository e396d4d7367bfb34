"""Which parameters a unit refuses, at the beginning and in the middle of sampling (D10).

A list or a stream is refused as a whole because of a single code, and a unit may change its mind.
What is refused is dropped with a notice, and the others go on: a log that is silently empty because
of one bad channel is no log.
"""

from __future__ import annotations

from collections.abc import Generator, Iterable, Iterator

from mikas.client import Ecu
from mikas.client.data import refused
from mikas.commands import Datum, ReadParameters
from mikas.errors import LineError, MikasError, NoResponse, NotSupported, WrongLength
from mikas.sampling.events import Dropped, Event, Gap
from mikas.sampling.plan import Plan
from mikas.sampling.session import Session, Wish, datum_of

_RPM = Datum(0x29, 1)  # FREQ: what a unit that knows 61 at all has
_HOPELESS = 3  # refusals before the first answer: it is not the parameters
_ATTEMPTS = 3


class Refusals:
    """Makes plans without what the unit refuses."""

    def __init__(self, session: Session) -> None:
        self._session = session
        self._asked_again: Wish | None = None

    def accepted(self, ecu: Ecu, wish: Wish) -> Generator[Event, None, Plan | None]:
        """The plan of what the unit gives; None: it gives nothing, which was told.

        Raises `NotSupported` instead if there has never been a sample, and what `strict` says.
        """
        for attempt in range(1, _ATTEMPTS + 1):
            plan = self._left(wish)
            if plan is None:
                break
            try:
                yield from self._try(ecu, wish, plan)
                break
            except LineError as error:
                yield Gap(ecu.tester.link.now(), error)
                if attempt == _ATTEMPTS:
                    return plan  # on such a line there is no telling
            except NotSupported as error:
                if not (yield from self.weed(ecu, plan)):
                    yield from self._nothing(ecu, error)
                    return None
        plan = self._left(wish)
        if plan is None:
            first = wish.wanted[0].parameter
            yield from self._nothing(ecu, refused(first.name, first.code))
        return plan

    def _try(self, ecu: Ecu, wish: Wish, plan: Plan) -> Iterator[Event]:
        named = [wanted.parameter for wanted in plan.wanted]
        ecu.parameters.fetch(named, again=wish.again and wish is not self._asked_again)
        self._asked_again = wish
        lost = {datum_of(p) for p in named if ecu.parameters.refuses([p])}
        yield from self._drop(ecu, plan, lost)

    def _left(self, wish: Wish) -> Plan | None:
        left = tuple(w for w in wish.wanted if datum_of(w.parameter) not in self._session.refused)
        return Plan(left) if left else None

    def _nothing(self, ecu: Ecu, error: MikasError) -> Generator[Event, None, None]:
        if not self._session.begun:
            raise error
        yield Gap(ecu.tester.link.now(), error)

    def weed(self, ecu: Ecu, plan: Plan) -> Generator[Event, None, bool]:
        """Drops what the unit refuses now; whether that is anything."""
        try:
            lost = refused_of(ecu, plan.every)
        except LineError as error:
            yield Gap(ecu.tester.link.now(), error)
            return False
        yield from self._drop(ecu, plan, lost)
        return bool(lost)

    def _drop(self, ecu: Ecu, plan: Plan, lost: set[Datum]) -> Iterator[Event]:
        self._session.refused |= lost
        for wanted in plan.wanted:
            name = wanted.parameter.name
            if datum_of(wanted.parameter) in lost and name not in self._session.dropped:
                self._session.dropped.add(name)
                yield Dropped(ecu.tester.link.now(), name)


def refused_of(ecu: Ecu, data: Iterable[Datum]) -> set[Datum]:
    """Those of `data` that the unit refuses while it answers others; empty if it answers none.

    Raises a `LineError` if the line leaves no telling, or a `NoConnection`.
    """
    asked = tuple(data)
    refused: set[Datum] = set()
    answered = 0
    for datum in asked if _RPM in asked else (_RPM, *asked):
        if _answers(ecu, datum):
            answered += 1
            continue
        refused.add(datum)
        if not answered and len(refused) == _HOPELESS:
            return set()
    return refused.intersection(asked) if answered else set()


def _answers(ecu: Ecu, datum: Datum) -> bool:
    # Asked for twice at once, a datum of 01 can't be taken for a refusal.
    count = 2 if ecu.limits().max_list > 1 else 1
    try:
        ecu.tester.request(ReadParameters((datum,) * count))
    except (NotSupported, NoResponse, WrongLength):
        return False
    return True
