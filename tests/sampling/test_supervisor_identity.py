"""Whether it is still the same unit: after an outage that is over soon, and on a bad line."""

from __future__ import annotations

from contextlib import closing
from itertools import pairwise

import pytest
from sampling_harness import SimulatedPlug, enough, make_sampler, of, settled, take

from mikas.client import Passport
from mikas.client.identity import UnitIdentity
from mikas.sampling.events import (
    CycleFailed,
    Event,
    LineState,
    PlanChanged,
    Sampled,
    StateChanged,
    UnitFound,
)
from mikas.virtual.bus import Bus
from mikas.virtual.ecu import VirtualEcu
from mikas.virtual.fault_injector import FaultInjector, LineFault
from mikas.virtual.quirks import EcuQuirks
from mikas.virtual.responder import Identity, Responder
from virtual_harness import DATA, FAULTS, IDENTITY, PASSPORTS, TableCar, make_bus

OTHER_DATA = {code: bytes(byte + 1 & 0xFF for byte in raw) for code, raw in DATA.items()}
# Seconds to observe each for: streams are given up late.
METHODS = {"single": 13, "batch": 13, "list": 13, "stream": 17, "stroke0": 23}


def after_an_outage(method: str, seconds: float, identity: Identity) -> list[Event]:
    """The events when the plug is carried to the car of `identity` and other data."""
    plug = SimulatedPlug(make_bus())
    unit = plug.bus.ecu

    def carried() -> None:
        car = TableCar(OTHER_DATA, faults=FAULTS, rpm=850)
        unit.responder = Responder(car, identity, EcuQuirks())

    with closing(make_sampler(plug, "FREQ", "TWAT/7", "INJ", method=method).run()) as events:
        take(events, enough)
        unit.responder.car.on = False
        plug.at(plug.now() + seconds, carried)
        return take(events, lambda e: plug.now() > METHODS[method] + seconds)


@pytest.mark.parametrize("seconds", [1.5, 3])
@pytest.mark.parametrize("method", METHODS)
def test_another_version_after_a_short_outage_is_found(method: str, seconds: float) -> None:
    reported = after_an_outage(method, seconds, Identity(0x09, PASSPORTS))
    assert [(u.version_code, u.another) for u in of(UnitFound, reported)] == [(0x09, True)]
    assert of(Sampled, reported)[-1].time > METHODS[method] - 1


@pytest.mark.parametrize("seconds", [1.5, 3, 5])
@pytest.mark.parametrize("method", METHODS)
def test_another_passport_after_a_short_outage_is_reported_before_its_values(
    method: str, seconds: float
) -> None:
    reported = after_an_outage(method, seconds, Identity(0x0A, ("OTHER", *PASSPORTS[1:])))
    assert [u.another for u in of(UnitFound, reported)] == [True]
    found = reported.index(of(UnitFound, reported)[0])
    assert of(PlanChanged, reported[found:])  # a new recording begins with it
    for table, part in ((DATA, reported[:found]), (OTHER_DATA, reported[found:])):
        for sample in of(Sampled, part):
            for reading in (*sample.fresh.values(), *sample.stale.values()):
                assert reading.raw == table[reading.parameter.code]
    assert of(Sampled, reported[found:])


def test_an_engine_that_stood_is_the_same_cars_and_no_state() -> None:
    """A stream by strokes is silent while it stands; the passports are compared on the quiet."""
    plug = SimulatedPlug(make_bus())
    car = plug.bus.ecu.responder.car
    with closing(make_sampler(plug, "FREQ", method="stroke0").run()) as events:
        take(events, enough)
        rpm, car.rpm = car.rpm, 0.0
        plug.at(plug.now() + 12, lambda: setattr(car, "rpm", rpm))
        reported = take(events, enough)
    assert of(CycleFailed, reported)
    assert not of(StateChanged, reported)
    assert not of(UnitFound, reported)


class Asked(Responder):
    """Remembers what it was asked."""

    def __init__(self, *made_of: object) -> None:
        super().__init__(*made_of)
        self.asked: list[int] = []

    def answer(self, body: bytes, now: float) -> bytes | None:
        self.asked.append(body[0])
        return super().answer(body, now)


@pytest.mark.parametrize("method", ["batch", "stream"])
def test_damaged_and_single_lost_responses_are_no_reason_to_compare(method: str) -> None:
    rates = {LineFault.DAMAGED: 0.05}
    unit = Asked(TableCar(DATA, faults=FAULTS, rpm=850), IDENTITY, EcuQuirks())
    plug = SimulatedPlug(Bus(VirtualEcu(unit), fault_injector=FaultInjector(rates, seed=3)))
    with closing(make_sampler(plug, method=method).run()) as events:
        take(events, enough)
        unit.asked.clear()
        if method == "batch":
            plug.bus.fault_injector.rates = rates | {LineFault.LOST: 0.02}
        reported = take(events, lambda e: len(of(Sampled, e)) > 400)
    if method == "stream":
        assert of(CycleFailed, reported)
    assert unit.asked
    assert not {0x51, 0x54}.intersection(unit.asked)


class Forgetful(Responder):
    """Loses the first two answers to `code`, as a bad line does."""

    def __init__(self, code: int) -> None:
        super().__init__(TableCar(DATA, faults=FAULTS, rpm=850), IDENTITY, EcuQuirks())
        self.code = code
        self.lost = 0

    def answer(self, body: bytes, now: float) -> bytes | None:
        if body[0] == self.code and self.lost < 2:
            self.lost += 1
            return None
        return super().answer(body, now)


@pytest.mark.parametrize("code", [0x51, 0x53, 0x54, 0x57])
def test_a_damaged_passport_makes_no_other_car(code: int) -> None:
    plug = SimulatedPlug(Bus(VirtualEcu(Forgetful(code))))
    car = plug.bus.ecu.responder.car
    with closing(make_sampler(plug, "FREQ", "INJ").run()) as events:
        reported = take(events, settled)
        car.on = False
        take(events, lambda e: bool(of(StateChanged, e)))
        car.on = True
        again = take(events, enough)
    (first,) = of(UnitFound, reported)
    assert None in (*first.passport.program, *first.passport.data)
    (found,) = of(UnitFound, again)
    assert not found.another
    assert found.passport == Passport(PASSPORTS[:3], PASSPORTS[3:])
    assert not of(PlanChanged, again)


class Damaging(Asked):
    """Damages the next `count` answers to `code`, more often than the tester repeats a request."""

    def __init__(self, code: int, count: int = 5) -> None:
        super().__init__(TableCar(DATA, faults=FAULTS, rpm=850), IDENTITY, EcuQuirks())
        self.code = code
        self.count = count

    def answer(self, body: bytes, now: float) -> bytes | None:
        answer = super().answer(body, now)
        if body[0] == self.code and self.count:
            self.count -= 1
            return b"\x00" * 5
        return answer

    @property
    def passports_asked(self) -> list[int]:
        return [self.asked.count(code) for code in range(0x51, 0x59)]


def test_after_an_outage_only_a_lost_passport_is_read_again() -> None:
    unit = Damaging(0x57, count=0)
    plug = SimulatedPlug(Bus(VirtualEcu(unit)))
    with closing(make_sampler(plug, "FREQ", "INJ", method="batch").run()) as events:
        take(events, enough)
        unit.car.on = False
        take(events, lambda e: bool(of(StateChanged, e)))
        unit.car.on, unit.count = True, 5
        unit.asked.clear()
        again = take(events, lambda e: bool(of(Sampled, e)))
    assert unit.passports_asked == [1, 1, 1, 1, 1, 1, 6, 1]
    assert [found.another for found in of(UnitFound, again)] == [False]
    assert len(of(CycleFailed, again)) <= 1


def test_first_values_go_on_while_a_passport_is_lost() -> None:
    unit = Damaging(0x51, count=5)
    with closing(make_sampler(SimulatedPlug(Bus(VirtualEcu(unit)))).run()) as events:
        reported = take(events, lambda e: bool(of(UnitFound, e)))
    assert unit.passports_asked == [6, 1, 1, 1, 1, 1, 1, 1]
    assert [found.another for found in of(UnitFound, reported)] == [False]
    times = [sample.time for sample in of(Sampled, reported)]
    assert max(after - before for before, after in pairwise(times)) < 2.5  # of three repetitions
    assert not of(CycleFailed, reported)


def test_passports_of_two_cars_make_no_unit() -> None:
    """The plug is carried to another car, whose program is another one, between two passports."""
    unit = Damaging(0x54, count=0)
    plug = SimulatedPlug(Bus(VirtualEcu(unit)))
    other = Responder(TableCar(OTHER_DATA), Identity(0x0A, ("OTHER", *PASSPORTS[1:])), EcuQuirks())

    def carried() -> None:
        if unit.count == 5:  # not yet requested
            plug.at(plug.now(), carried)
        elif unit.car.on:
            unit.car.on = False
            plug.at(plug.now() + 1.5, carried)
        else:
            plug.bus.ecu.responder = other

    with closing(make_sampler(plug, "FREQ", "INJ", method="batch").run()) as events:
        take(events, enough)
        unit.car.on = False
        take(events, lambda e: bool(of(StateChanged, e)))
        unit.car.on, unit.count = True, 5
        plug.at(plug.now(), carried)
        reported = take(events, enough)
    assert [found.another for found in of(UnitFound, reported)] == [True]
    assert {sample.fresh["FREQ"].raw for sample in of(Sampled, reported)} == {OTHER_DATA[0x29]}


def test_a_unit_that_cannot_be_resynchronized_is_found_again_at_once() -> None:
    """No hand on the keyboard: two cycles at most, and the state says so."""
    plug = SimulatedPlug(make_bus())
    with closing(make_sampler(plug, "FREQ", method="batch").run()) as events:
        take(events, enough)
        plug.bus.ecu.responder.identity = Identity(0x09, PASSPORTS)
        plug.bus.ecu.responder.car.on = False
        plug.at(plug.now() + 0.3, lambda: setattr(plug.bus.ecu.responder.car, "on", True))
        reported = take(events, enough)
    assert len(of(CycleFailed, reported)) <= 2
    states = [event.state for event in of(StateChanged, reported)]
    assert states == [LineState.ECHO_ONLY, LineState.ECU_ALIVE, LineState.SAMPLING]


PIECES_READ = (0, 1, 7)


def lost_early(away: float, pieces: int, other: Responder | None = None) -> list[Event]:
    """The events after the port is lost when the first values and `pieces` of the passport came."""
    unit = Asked(TableCar(DATA, faults=FAULTS, rpm=850), IDENTITY, EcuQuirks())
    plug = SimulatedPlug(Bus(VirtualEcu(unit)))

    def pull() -> None:
        plug.pull()
        if other is not None:
            plug.bus.ecu.responder = other
        plug.at(plug.now() + away, plug.mend)

    def pull_then() -> None:
        if sum(0x51 <= code <= 0x58 for code in unit.asked) > pieces:
            pull()
        else:
            plug.at(plug.now(), pull_then)

    with closing(make_sampler(plug, "FREQ", "INJ").run()) as events:
        first = take(events, lambda e: bool(of(Sampled, e)))
        plug.at(plug.now(), pull_then if pieces else pull)
        return first + take(events, settled)


@pytest.mark.parametrize("pieces", PIECES_READ)
def test_a_unit_away_for_a_moment_before_its_passports_were_read_is_the_same(pieces: int) -> None:
    reported = lost_early(1.5, pieces)
    (found,) = of(UnitFound, reported)
    assert not found.another
    lost = next(at for at, event in enumerate(reported) if isinstance(event, CycleFailed))
    back = next(event for event in reported[lost:] if isinstance(event, Sampled))
    assert reported.index(found) < reported.index(back)


@pytest.mark.parametrize("pieces", PIECES_READ)
def test_a_unit_away_for_longer_before_its_passports_were_read_counts_as_another(
    pieces: int,
) -> None:
    assert [found.another for found in of(UnitFound, lost_early(6, pieces))] == [True]


@pytest.mark.parametrize(
    ("pieces", "identity"),
    [
        (0, Identity(0x09, PASSPORTS)),
        (1, Identity(0x0A, ("OTHER", *PASSPORTS[1:]))),
        (7, Identity(0x0A, ("OTHER", *PASSPORTS[1:]))),
        (7, Identity(0x0A, (*PASSPORTS[:6], "OTHER", PASSPORTS[7]))),
    ],
)
def test_a_version_or_a_piece_that_differs_shows_another_unit_however_early_the_first_was_lost(
    pieces: int, identity: Identity
) -> None:
    other = Responder(TableCar(OTHER_DATA, faults=FAULTS, rpm=850), identity, EcuQuirks())
    reported = lost_early(1.5, pieces, other)
    assert [found.another for found in of(UnitFound, reported)] == [True]
    found = reported.index(of(UnitFound, reported)[0])
    assert of(PlanChanged, reported[found:])  # a new recording begins with it
    for table, part in ((DATA, reported[:found]), (OTHER_DATA, reported[found:])):
        for sample in of(Sampled, part):
            for reading in (*sample.fresh.values(), *sample.stale.values()):
                assert reading.raw == table[reading.parameter.code]


def test_the_unit_of_an_earlier_connection_is_compared_before_the_first_value() -> None:
    known = UnitIdentity(0x0A, Passport(PASSPORTS[:3], (None, *PASSPORTS[4:])))
    for before, is_another in ((known, False), (known._replace(version_code=9), True)):
        sampler = make_sampler(SimulatedPlug(make_bus()), "FREQ", before=before)
        with closing(sampler.run()) as events:
            reported = take(events, enough)
        (found,) = of(UnitFound, reported)
        assert found.another is is_another
        assert reported.index(found) < reported.index(of(Sampled, reported)[0])


def test_a_unit_at_a_port_of_its_own_is_another_though_it_says_the_same() -> None:
    known = UnitIdentity(0x0A, Passport(PASSPORTS[:3], PASSPORTS[3:]))
    sampler = make_sampler(SimulatedPlug(make_bus()), "FREQ", before=known, moved=True)
    with closing(sampler.run()) as events:
        reported = take(events, enough)
    assert [found.another for found in of(UnitFound, reported)] == [True]
