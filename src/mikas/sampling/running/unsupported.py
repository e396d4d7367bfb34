"""Parameters that a unit refuses, at the beginning and while sampling (D10).

A unit refuses a whole list or stream because of a single code, and may later refuse a parameter
that it gave before. A refused parameter is dropped with a notice, and the others continue. Silence
is a refusal only if the line can't have lost the answers (`client.parameters.silence`). Even so
dropped parameters are requested again (`DroppedParameters`), and come back with a notice.

The tester reports a refused command. If the unit has answered the command before, `explained` names
the refused parameter or list instead (D10).
"""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Collection, Generator, Iterator
from enum import Enum
from math import inf

from mikas import errors
from mikas.client import Ecu
from mikas.client.parameters.data import COMMON, refused
from mikas.client.parameters.polling import STREAMS
from mikas.client.parameters.silence import SilenceCheck
from mikas.commands import Datum, ReadParameters
from mikas.framing import Decoder, Frame
from mikas.i18n import Text
from mikas.sampling.events import CycleFailed, Event, ParameterDropped, ParameterReturned
from mikas.sampling.plan import Plan, datum_of
from mikas.sampling.running.context import SamplingContext, SamplingRequest

_MOST_REFUSALS = 6  # before the first datum; with more, the parameters are not the cause
_ATTEMPTS = 3
_PAUSE = 60.0  # s to the next request of a dropped parameter; doubled after each in vain


class UnsupportedParameters:
    """Plans without the parameters that the unit refuses."""

    def __init__(self, context: SamplingContext) -> None:
        self._context = context
        self._retried: SamplingRequest | None = None
        self.dropped: DroppedParameters = DroppedParameters(context.refused)
        self._again = False  # a dropped parameter has answered: its limit is to be forgotten

    def supported_plan(self, ecu: Ecu) -> Generator[Event, None, Plan | None]:
        """Return the plan of the supported parameters.

        None: the unit refuses all, as reported, or the request was replaced. Raises `NotSupported`
        if the unit refuses all before the first sample.
        """
        for attempt in range(1, _ATTEMPTS + 1):
            if attempt > 1:
                self._context.jobs.run(ecu)  # an attempt takes seconds if the unit is silent
            if not self._context.is_current:
                return None
            self._try_dropped(ecu)
            plan = self.remaining(self._context.request)
            if plan is None or self._context.answered.issuperset(plan.divisors):
                break
            try:
                yield from self._try(ecu, plan)
                break
            except errors.LineError as error:
                yield CycleFailed(ecu.tester.link.now(), error)
                if attempt == _ATTEMPTS:
                    return plan  # on a bad line refusals are not known
            except errors.NotSupported as error:
                dropped = yield from self.drop_unsupported(ecu, plan)
                if not dropped and self._context.is_current:
                    yield from self._all_refused(ecu, error)
                    return None
        plan = self.remaining(self._context.request)
        if plan is None:
            first = self._context.request.selection.parameters[0].parameter
            yield from self._all_refused(ecu, refused(first.name, first.code))
        return plan

    def _try(self, ecu: Ecu, plan: Plan) -> Iterator[Event]:
        parameters = [planned.parameter for planned in plan.parameters]
        requested = self._context.request
        again = requested.selection.explicit and requested is not self._retried
        wanted = ecu.parameters.wanted(parameters)
        fresh = ecu.parameters.fetch(wanted, again=again or self._again)
        self._retried, self._again = requested, False
        self._context.knowledge.max_list = ecu.limits().max_list
        for name in self._context.dropped.intersection(fresh):
            self._context.dropped.discard(name)
            yield ParameterReturned(ecu.tester.link.now(), name, ecu.limits())
        refusing = {datum_of(p) for p in parameters if ecu.parameters.refuses([p])}
        if len(fresh) == len(parameters):
            self._context.answered = frozenset(plan.divisors)
        yield from self._drop(ecu, plan, refusing)

    def remaining(self, request: SamplingRequest) -> Plan | None:
        """Return the plan of `request` without the refused parameters; None: none is left."""
        context = self._context
        requested = request.selection.parameters
        left = tuple(p for p in requested if datum_of(p.parameter) not in context.refused)
        return Plan(left, max_list=context.knowledge.max_list) if left else None

    def _all_refused(self, ecu: Ecu, error: errors.MikasError) -> Generator[Event, None, None]:
        if not self._context.has_sampled:
            raise error
        yield CycleFailed(ecu.tester.link.now(), error)

    def drop_unsupported(
        self, ecu: Ecu, plan: Plan, *, going: bool = False
    ) -> Generator[Event, None, bool]:
        """Drop the parameters that the unit refuses now; return whether it refuses any.

        A silent parameter takes a second each time; jobs run in between, and with `going` also a
        cycle of the parameters that have answered.
        """
        context = self._context
        planned = tuple(plan.divisors)
        answered: list[Datum] = []
        failed: Counter[Datum] = Counter()  # requests without a datum
        refusing: set[Datum] = set()
        silence = SilenceCheck(ecu.tester)
        queue = deque(dict.fromkeys((*COMMON, *planned)))
        try:
            while queue and context.is_current:
                context.jobs.run(ecu)
                datum = queue.popleft()
                if answered and datum not in planned:
                    continue
                result = _probe(ecu, datum)
                if result is ProbeResult.DATUM:
                    answered.append(datum)
                    del failed[datum]
                    continue
                failed[datum] += 1
                if not answered and len(failed) == _MOST_REFUSALS:
                    return False
                if result is ProbeResult.REFUSED or (
                    answered and silence.is_unknown(datum, answered[-1])
                ):
                    refusing.add(datum)
                elif not silence.gives_up(datum) and (answered or failed[datum] < _ATTEMPTS):
                    queue.append(datum)
                if going:
                    yield from self._rest(ecu, plan, answered)
        except errors.SyncLost:
            raise
        except errors.LineError as error:
            yield CycleFailed(ecu.tester.link.now(), error)
            return False
        refusing = refusing.intersection(planned) if answered else set()
        yield from self._drop(ecu, plan, refusing)
        return bool(refusing)

    def _try_dropped(self, ecu: Ecu) -> None:
        """Request one of the dropped parameters if its time has come."""
        datum = self.dropped.next(ecu.tester.link.now())
        if datum is None:
            return
        try:
            answers = _probe(ecu, datum) is ProbeResult.DATUM
        except errors.SyncLost:
            raise
        except errors.LineError:
            return  # later
        if answers:
            self._context.refused.discard(datum)
            self._again = True

    def _rest(self, ecu: Ecu, plan: Plan, answered: Collection[Datum]) -> Iterator[Event]:
        """Run a cycle of the parameters that have answered."""
        parameters = [p.parameter for p in plan.parameters if datum_of(p.parameter) in answered]
        if not parameters:
            return
        wanted = ecu.parameters.wanted(parameters)
        if fresh := ecu.parameters.fetch(wanted):
            self._context.identity_check.check(ecu, lambda: None)
            yield from self._context.sampled(fresh)

    def _drop(self, ecu: Ecu, plan: Plan, refusing: set[Datum]) -> Iterator[Event]:
        self._context.refused |= refusing
        now, read = ecu.tester.link.now(), self._context.read
        for planned in plan.parameters:
            name, datum = planned.parameter.name, datum_of(planned.parameter)
            if datum in refusing:
                self.dropped.add(datum, now, read_before=name in read)
                if name not in self._context.dropped:
                    self._context.dropped.add(name)
                    yield ParameterDropped(now, name, ecu.limits())


class DroppedParameters:
    """When a dropped parameter is requested again, which may have been dropped by mistake (D10).

    One at a time, as a silent one takes a second: after a reconnection, when values are missing
    anyway, each in turn. One that was read before is also requested after a minute, then after two,
    four, … So a parameter that a unit never had costs nothing while the connection lasts.
    `refused`: the set of all that are dropped.
    """

    def __init__(self, refused: set[Datum]) -> None:
        self._refused = refused
        self._read_before: set[Datum] = set()
        self._requests: Counter[Datum] = Counter()
        self._reconnected = False
        self._due, self._pause = inf, _PAUSE

    def add(self, datum: Datum, now: float, *, read_before: bool) -> None:
        """Note that `datum` is dropped."""
        if read_before:
            self._read_before.add(datum)
            self._due, self._pause = now + _PAUSE, _PAUSE

    def reconnected(self) -> None:
        """Note that the unit answers again."""
        self._reconnected = True

    def is_due(self, now: float) -> bool:
        """Whether one is to be requested again, during a connection."""
        return now >= self._due

    def next(self, now: float) -> Datum | None:
        """Return the one to request again now; None: none."""
        if self._reconnected:
            waiting = self._refused
        elif self.is_due(now):
            waiting = self._refused & self._read_before
        else:
            return None
        self._reconnected = False
        if self._due < inf:
            self._due = now + self._pause if self._refused & self._read_before else inf
            self._pause *= 2
        if not waiting:
            return None
        datum = min(waiting, key=self._turn)
        self._requests[datum] += 1
        return datum

    def _turn(self, datum: Datum) -> tuple[int, bool, int]:
        return self._requests[datum], datum not in self._read_before, datum.code


class ProbeResult(Enum):
    """The outcome of a request for one datum."""

    DATUM = "a datum"
    REFUSED = "a refusal"
    SILENCE = "no response, or none of the right length: it may have been lost"


def _probe(ecu: Ecu, datum: Datum) -> ProbeResult:
    """Request `datum`; repeat after damage. Raises the third `LineError` in a row."""
    # With the code twice in a request, a datum 01 differs from a refusal.
    command = ReadParameters((datum,) * (2 if ecu.limits().max_list > 1 else 1))
    for attempt in range(1, _ATTEMPTS + 1):
        try:
            ecu.tester.exchange(command, retries=0, trial=True)
            break
        except errors.NotSupported as error:
            return ProbeResult.REFUSED if error.received else ProbeResult.SILENCE
        except (errors.NoResponse, errors.WrongLength):
            return ProbeResult.SILENCE
        except errors.LineError:
            if attempt == _ATTEMPTS:
                raise
    return ProbeResult.DATUM


def explained(ecu: Ecu, plan: Plan, error: errors.MikasError, *, worked: bool) -> errors.MikasError:
    """Return `error`, or the true refusal of this unit. `worked`: `plan` gave readings before."""
    frames = Decoder().feed(error.request or b"") if isinstance(error, errors.NotSupported) else []
    bodies = [frame.body for frame in frames if isinstance(frame, Frame)]
    if not bodies:
        return error
    code, *codes = bodies[0]
    if not (ecu.tester.has_answered(code) or worked):
        return error
    refusal = _refusal(plan, code, codes)
    refusal.request, refusal.received, refusal.time = error.request, error.received, error.time
    refusal.__cause__ = error.__cause__
    return refusal


def _refusal(plan: Plan, code: int, codes: list[int]) -> errors.NotSupported:
    names = [p.parameter.name for p in plan.parameters if p.parameter.code in codes]
    if code in ReadParameters.CODES and len(set(codes)) == 1 and names:
        return refused(", ".join(names), codes[0])
    kind = Text("a stream", "потока") if plan.method in STREAMS else Text("a list", "списка")
    count = len(set(codes)) or len(plan.fast)  # 63 names none
    return errors.NotSupported(
        command=Text(
            f"{kind.en} ({code:02X}) of these parameters ({count})",
            f"{kind.ru} ({code:02X}) из этих параметров ({count})",
        )
    )
