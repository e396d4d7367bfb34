"""The way to the ECU: kept open, and opened again, without a hand on the keyboard.

    no port ─► no echo ─► echo only ─► the ECU answers ─► sampling        (LineState)

An adapter that was pulled out is looked for, a silent ECU is asked until it answers, and whoever
answers is compared with the one before: it may be another car.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator

from mikas.client import Ecu, Passport
from mikas.commands import Availability
from mikas.errors import (
    EchoOnly,
    LineError,
    LinkLost,
    MikasError,
    NoConnection,
    NoEcho,
    NotAKLineAdapter,
    SyncLost,
)
from mikas.link import Link
from mikas.link.reconnecting import ReconnectingPort
from mikas.sampling.context import SamplingContext
from mikas.sampling.events import CycleFailed, Event, LineState, StateChanged, UnitFound
from mikas.sampling.identity_check import IdentityCheck

UnitIdentity = tuple[int, Passport]

_PORT_LOOK = 1.0  # s between looks for an adapter that is not there


class ConnectionSupervisor:
    """Opens `plug` and finds the unit behind it, as often as needed.

    While the way is broken, jobs fail with what broke it; so do the methods here in a strict
    session before its first sample.
    """

    def __init__(
        self, port: ReconnectingPort, make_ecu: Callable[[Link], Ecu], context: SamplingContext
    ) -> None:
        self.state: LineState | None = None
        self.unit: UnitIdentity | None = None
        self.ecu: Ecu | None = None
        """That of the open link; None until a unit has been met on it."""
        self.identity_check = IdentityCheck(self._verify)
        """Whether it is still `unit`."""
        self._port = port
        self._make_ecu = make_ecu
        self._context = context
        self._reported: type[MikasError] | None = None

    def open_port(self) -> Generator[Event, None, Link | None]:
        """The link; None: nobody wants it any more."""
        while not self._context.stopped:
            try:
                return self._port.open()
            except NoConnection as error:
                yield from self.port_lost(error, self._port.now())
                self._port.wait(_PORT_LOOK)
        return None

    def port_lost(self, error: NoConnection, time: float) -> Iterator[Event]:
        """The adapter is gone. Raises `error` in a strict beginning."""
        self.ecu = None
        yield from self._broken(LineState.NO_PORT, time, error)

    def find_unit(self, link: Link) -> Generator[Event, None, Ecu | None]:
        """A connected `Ecu` on `link`; None: nobody wants it any more."""
        ecu = self._make_ecu(link)
        unit = yield from self._wait_for_answer(ecu, again=False)
        if unit is None:
            return None
        another = self.unit is not None and not is_same_unit(unit, self.unit)
        self.unit, self.ecu = unit, ecu
        yield _found(ecu, unit, another=another)
        return ecu

    def find_unit_again(
        self, ecu: Ecu, error: NoConnection | SyncLost
    ) -> Generator[Event, None, bool]:
        """After `error`, until a unit answers. False: it is not that of `ecu`, or nobody wants it
        any more.
        """
        yield from self._no_answer(ecu, error)
        # A unit that can't be brought in step may be one of another version.
        unit = yield from self._wait_for_answer(ecu, again=not isinstance(error, SyncLost))
        if unit is None or self.unit is None or not is_same_unit(unit, self.unit):
            return False
        self.unit = unit
        yield _found(ecu, unit, another=False)
        return True

    def now_in(
        self, state: LineState, time: float, error: MikasError | None = None
    ) -> Iterator[Event]:
        """Tells a state that is another one, or has another reason."""
        if state is not self.state or (error is not None and type(error) is not self._reported):
            self.state, self._reported = state, None if error is None else type(error)
            yield StateChanged(time, state, error)

    def _wait_for_answer(
        self, ecu: Ecu, *, again: bool
    ) -> Generator[Event, None, UnitIdentity | None]:
        """Asks until a unit answers; each attempt waits for it by itself (D14)."""
        while not self._context.stopped:
            try:
                if again and self.unit and ecu.version_code == self.unit[0]:
                    ecu.tester.request(Availability())  # after a short dip that is enough
                    again = False
                else:
                    ecu.tester.connect()
                unit = self._identify(ecu)
            except (LinkLost, NotAKLineAdapter):
                raise
            except (NoConnection, LineError) as error:
                again = False
                yield from self._no_answer(ecu, error)
            else:
                self.identity_check.confirm(ecu)
                yield from self.now_in(LineState.ECU_ALIVE, ecu.tester.link.now())
                return unit
        return None

    def _identify(self, ecu: Ecu) -> UnitIdentity:
        """Who answers. Another one than before has to say so twice: a piece may have been lost."""
        unit = ecu.version_code, ecu.passport(again=True)
        if self.unit is None:
            return unit
        if not is_same_unit(unit, self.unit):
            once, unit = unit, (ecu.version_code, ecu.passport(again=True))
            if not is_same_unit(once, unit):
                raise SyncLost(time=ecu.tester.link.now())
            return unit
        return unit[0], unit[1].filled_from(self.unit[1])

    def _verify(self, ecu: Ecu) -> None:
        """Raises `SyncLost` if it is not `unit` that answers, or not certain, `NoConnection`."""
        try:
            unit = self._identify(ecu)
        except LineError as error:
            raise SyncLost(time=ecu.tester.link.now()) from error
        if self.unit is None or not is_same_unit(unit, self.unit):
            raise SyncLost(time=ecu.tester.link.now())

    def _no_answer(self, ecu: Ecu, error: NoConnection | LineError) -> Iterator[Event]:
        state = LineState.ECHO_ONLY  # something talks, but it is no use yet
        if isinstance(error, NoEcho) or (
            isinstance(error, NoConnection) and not isinstance(error, EchoOnly)
        ):
            state = LineState.NO_ECHO
        yield from self._broken(state, ecu.tester.link.now(), error)

    def _broken(
        self, state: LineState, time: float, error: NoConnection | LineError
    ) -> Iterator[Event]:
        self._context.jobs.fail(error)
        if self._context.strict and not self._context.has_sampled:
            raise error
        if (
            self._context.has_sampled
        ):  # at each attempt, about once a second: those who wait see time go
            yield CycleFailed(time, error)
        yield from self.now_in(state, time, error)


def _found(ecu: Ecu, unit: UnitIdentity, *, another: bool) -> UnitFound:
    link = ecu.tester.link
    return UnitFound(
        link.now(),
        *unit,
        another,
        ecu.model.text,
        adapter=link.description,
        baud=link.baud,
        echo=ecu.tester.echoes,
        catalog=ecu.catalog.version,
    )


def is_same_unit(one: UnitIdentity, other: UnitIdentity) -> bool:
    """Whether both are one unit, as far as is known of each."""
    return one[0] == other[0] and one[1].may_be(other[1])
