"""Keeps the connection: opens the port, finds the unit, and reports each change of state.

A lost port is opened again, a silent ECU is requested until it answers, and a unit that answers is
compared with the one before: it may be another car. `line_state` has the states and transitions.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator
from dataclasses import dataclass
from math import inf
from typing import NamedTuple

from mikas import errors
from mikas.client import Ecu, Reading
from mikas.client.identity import UnitIdentity
from mikas.commands import Availability
from mikas.link import Link
from mikas.link.reconnecting import ReconnectingPort
from mikas.link.urls import kind_of, parse
from mikas.sampling.events import (
    AdapterMoved,
    CycleFailed,
    Event,
    LineState,
    StateChanged,
    UnitFound,
)
from mikas.sampling.line_state import LineTrigger, following, trigger_of
from mikas.sampling.plan import Plan
from mikas.sampling.running.context import SamplingContext

_RETRY_PORT = 1.0  # s from one attempt to open the port to the next
_BREATH = 0.1  # s between two of them at least
_FLOODED = 20.0  # s until a port is opened again that sent more than a line carries
_PAUSE = 0.5  # s between two cycles; passports that are answered take 0.2 s
_SILENT = errors.ConnectionSilent
_CARRIED = 4.0  # s: in less no plug is carried to another car whose unit then answers


class _Unnamed(NamedTuple):
    """A unit that has given values before all its passports were read; `seen`: its last answer."""

    identity: UnitIdentity
    seen: float


@dataclass(eq=False)
class ConnectionSupervisor:
    """Opens `port` and finds the unit, as often as needed.

    `before`: the unit of an earlier connection, with which the first one is compared before it is
    sampled; without, the first unit is sampled at once. `moved`: the first unit is another one,
    whatever it says of itself. While no unit answers, queued jobs fail
    with the error that prevents an answer; with `strict` the methods raise that error until the
    first sample.
    """

    port: ReconnectingPort
    make_ecu: Callable[[Link], Ecu]
    context: SamplingContext
    before: UnitIdentity | None = None
    moved: bool = False

    def __post_init__(self) -> None:
        self.state: LineState | None = None
        """The state reported last; None while not running."""
        self.unit: UnitIdentity | None = None
        self.ecu: Ecu | None = None
        """The `Ecu` on the open link; None until a unit answers."""
        self.context.identity_check.compare = self._verify
        self._reported: type[errors.MikasError] | None = None  # the reason reported with `state`
        self._listening_since = inf  # when the port was opened, until something was sent on it
        self._unnamed: _Unnamed | None = None
        self._answered = -inf  # when a unit answered after the latest silence or lost port

    def open_port(self) -> Generator[Event, None, Link | None]:
        """Open the port; None: sampling was stopped before."""
        before = parse(self.port.url).name
        while not self.context.stopped:
            began = self.port.now()
            try:
                link = self.port.open()
                self._listening_since = link.opened
                if (name := parse(self.port.url).name) != before:
                    yield AdapterMoved(link.now(), name, before)
                return link
            except errors.NoConnection as error:
                yield from self._broken(LineTrigger.PORT_MISSING, self.port.now(), error)
                spent = self.port.now() - began  # a network may take seconds to fail
                self.port.wait(max(_RETRY_PORT - spent, _BREATH))
        return None

    def port_lost(self, error: errors.LinkLost, time: float) -> Iterator[Event]:
        """Report that the open port failed, and wait. Raises `error` with `strict` before a sample.

        Without the wait, a port that opens and fails at once would be opened without end. A silent
        connection has taken its time.
        """
        self.ecu = None
        if isinstance(error, errors.ConnectionSilent):
            yield from self._broken(LineTrigger.ECHO_MISSING, time, error)
            return
        yield from self._broken(LineTrigger.PORT_LOST, time, error)
        pause = _FLOODED if isinstance(error, errors.LineFlooded) else _RETRY_PORT
        until = self.port.now() + pause
        while not self.context.stopped and (left := until - self.port.now()) > 0:
            self.port.wait(min(left, _RETRY_PORT))
            self.context.jobs.fail(error)

    def find_unit(self, link: Link) -> Generator[Event, None, Ecu | None]:
        """Return a connected `Ecu` on `link`; None: sampling was stopped."""
        ecu = self.make_ecu(link)
        unit = yield from self._wait_for_answer(ecu, again=False)
        if unit is None:
            return None
        if another := self._is_another(unit):
            self.context.forget_unit()
            self.context.forget_totals()
        elif self._known is not None:
            unit = unit.filled_from(self._known)
        self._unnamed = None
        self.unit, self.ecu = unit, ecu
        yield unit_found(ecu, unit, another=another)
        return ecu

    def find_unit_again(
        self, ecu: Ecu, error: errors.NoConnection | errors.SyncLost
    ) -> Generator[Event, None, bool]:
        """After `error`, wait for a unit; return whether it is that of `ecu`.

        Also False if sampling was stopped.
        """
        yield from self._broken(trigger_of(error), ecu.tester.link.now(), error)
        # A unit that cannot be resynchronized may be one of another version.
        unit = yield from self._wait_for_answer(ecu, again=not isinstance(error, errors.SyncLost))
        if unit is None or self._is_another(unit):
            return False
        self.unit = unit
        yield unit_found(ecu, unit)
        return True

    def process(
        self, event: LineTrigger, time: float, error: errors.MikasError | None = None
    ) -> Iterator[Event]:
        """Enter the state after `event`; report a change of state or of the kind of `error`.

        A connection that fell silent and is silent again brings no news: its requests have no echo.
        """
        before, self.state = self.state, following(self.state, event)
        if self.state is None:
            return
        known = {self._reported, errors.NoEcho} if self._reported is _SILENT else {self._reported}
        if self.state is not before or (error is not None and error.kind not in known):
            self._reported = None if error is None else error.kind
            yield StateChanged(time, self.state, error, port=kind_of(self.port.url))

    def end_run(self) -> None:
        """End the run."""
        self.state = following(self.state, LineTrigger.ENDED)
        self.ecu = None

    def _wait_for_answer(
        self, ecu: Ecu, *, again: bool
    ) -> Generator[Event, None, UnitIdentity | None]:
        """Repeat requests until a unit answers; each attempt has its own timeout (D14)."""
        while not self.context.stopped:
            try:
                if again and self.unit and ecu.version_code == self.unit.version_code:
                    ecu.tester.request(Availability())  # enough after a short voltage dip
                    again = False
                else:
                    since, self._listening_since = self._listening_since, inf
                    ecu.tester.connect(listening_since=since)
                self._answered = ecu.tester.link.now()
                unit: UnitIdentity | None
                if self.unit is None and self._unnamed is None:
                    unit = yield from self._identify_first(ecu)
                else:
                    unit = self._identify(ecu)
                    yield from self.process(LineTrigger.IDENTIFIED, ecu.tester.link.now())
            except (errors.LinkLost, errors.NotAKLineAdapter):
                raise
            except (errors.NoConnection, errors.LineError) as error:
                again = False
                yield from self._broken(trigger_of(error), ecu.tester.link.now(), error)
            else:
                self.context.identity_check.confirm(ecu)
                return unit
        return None

    def _identify_first(self, ecu: Ecu) -> Generator[Event, None, UnitIdentity | None]:
        """Read the identity of the first unit, with which no other can be confused.

        So its values come first, and the passports between two cycles. None: sampling was stopped.
        If the unit is lost in between, the next one is identified before it is sampled, and is
        compared with what was read by then.
        """
        self.ecu = ecu
        yield from self.process(LineTrigger.IDENTIFIED, ecu.tester.link.now())
        first_values = FirstValues(self.context, ecu, works=self.before is None)
        steps = ecu.passports.steps()
        while not self.context.stopped:
            if fresh := first_values.read():
                self._note_unnamed(ecu)
                time = min(reading.time for reading in fresh.values())
                yield from self.process(LineTrigger.ACCEPTED, time)
                yield from self.context.report_plan(first_values.plan, time)
                yield from self.context.sampled(fresh)
            try:
                next(steps)
            except StopIteration as end:
                self._unnamed = None
                return UnitIdentity(ecu.version_code, end.value)
            if self._unnamed is not None:
                self._note_unnamed(ecu)
        return None

    def _note_unnamed(self, ecu: Ecu) -> None:
        identity = UnitIdentity(ecu.version_code, ecu.passports.so_far)
        self._unnamed = _Unnamed(identity, ecu.tester.link.now())

    def _is_another(self, unit: UnitIdentity) -> bool:
        """Return whether `unit` is another than the one before: the one place that decides.

        One that was lost before its passports were read is known by its version and the pieces read
        by then, which may be none: it is the same one only if it was away for a moment.
        """
        if (unnamed := self._unnamed) is not None:
            away = self._answered - unnamed.seen
            return away > _CARRIED or unnamed.identity.contradicts(unit)
        if self._known is None:
            return False
        return (self.moved and self.unit is None) or not unit.may_be(self._known)

    @property
    def _known(self) -> UnitIdentity | None:
        """The unit before, as far as it is known."""
        return self._unnamed.identity if self._unnamed else self.unit or self.before

    def _identify(self, ecu: Ecu) -> UnitIdentity:
        """Read the identity; a different one is read twice, as a part may have been lost."""
        unit = UnitIdentity(ecu.version_code, ecu.passports.read())
        if self._is_another(unit):
            once, unit = unit, UnitIdentity(ecu.version_code, ecu.passports.read())
            if not once.may_be(unit):
                raise _sync_lost(ecu)
            return unit
        return unit.filled_from(self._known) if self._known else unit

    def _verify(self, ecu: Ecu) -> None:
        """Raise `SyncLost` unless `unit` certainly answers; `NoConnection` if no unit does."""
        try:
            unit = self._identify(ecu)
        except errors.LineError as error:
            raise _sync_lost(ecu) from error
        if self._is_another(unit):
            raise _sync_lost(ecu)

    def _broken(
        self, event: LineTrigger, time: float, error: errors.NoConnection | errors.LineError
    ) -> Iterator[Event]:
        context = self.context
        context.jobs.fail(error)
        if context.strict and not context.has_sampled:
            raise error
        if context.has_sampled:  # at each attempt, about once a second: the wait stays visible
            yield CycleFailed(time, error)
        yield from self.process(event, time, error)


class FirstValues:
    """Reads all requested parameters of `ecu` by one 61, until that may be refused.

    Later the unit's refusals are found and its fastest method is measured. Not if another method is
    requested; without `works`; if limits are saved for any unit, for this may be the one that does
    not take the whole list.
    """

    def __init__(self, context: SamplingContext, ecu: Ecu, *, works: bool) -> None:
        request = context.request
        self.plan: Plan = Plan(request.selection.parameters, max_list=context.knowledge.max_list)
        self._context = context
        self._ecu = ecu
        self._works = works and request.method in (None, "batch") and not ecu.limits_cache.any_saved
        self._due = -inf

    def read(self) -> dict[str, Reading]:
        """Return the readings by name; {} if the unit refuses, or soon after the last ones.

        Raises a `NoConnection`.
        """
        now = self._ecu.tester.link.now
        if not self._works or now() < self._due or not self._context.is_current:
            return {}
        parameters = [planned.parameter for planned in self.plan.parameters]
        try:
            fresh = self._ecu.parameters.at_once(parameters)
        except (errors.EcuRefused, errors.NoResponse, errors.WrongLength, errors.SyncLost):
            fresh, self._works = {}, False
        except errors.LineError:  # damage is no refusal
            fresh = {}
        self._due = now() + _PAUSE
        return fresh


def unit_found(ecu: Ecu, unit: UnitIdentity, *, another: bool = False) -> UnitFound:
    """Return the event of a unit that answers, with all that a recording of it needs."""
    link = ecu.tester.link
    return UnitFound(
        link.now(),
        *unit,
        another,
        ecu.model.text,
        adapter=link.description,
        baud=link.baud,
        echo=ecu.tester.line.echo,
        catalog=ecu.catalog.version,
    )


def _sync_lost(ecu: Ecu) -> errors.SyncLost:
    link = ecu.tester.link
    return errors.met_on(link.kind, errors.SyncLost(time=link.now()))
