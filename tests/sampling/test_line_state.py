"""The table of the line's states: every cell is reached on simulated time, and no other one is."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import closing, suppress

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sampling_harness import SimulatedPlug, ecu_factory, make_sampler, of, take

from mikas.errors import (
    ConnectionSilent,
    EchoOnly,
    MikasError,
    NoEcho,
    PortBusy,
    RecordingOver,
    SyncLost,
)
from mikas.link.reconnecting import ReconnectingPort
from mikas.link.urls import open_link
from mikas.sampling.acquisition import Acquisition
from mikas.sampling.events import Event, LineState, Sampled, StateChanged
from mikas.sampling.line_state import (
    TRANSITIONS,
    ImpossibleTransition,
    LineTrigger,
    following,
    trigger_of,
)
from mikas.virtual.bus import AdapterKind
from mikas.virtual.fault_injector import LineFault
from mikas.virtual.quirks import GROUPS, EcuQuirks, Unknown
from mikas.virtual.responder import Identity
from protocol_codes import SECTION_4
from virtual_harness import PASSPORTS, make_bus

Cell = tuple[LineState | None, LineTrigger]
CELLS = [(state, event) for state, row in TRANSITIONS.items() for event in row]
SECONDS = 40.0  # of simulated time in which a cell has to be reached


@pytest.fixture
def reached(monkeypatch: pytest.MonkeyPatch) -> list[Cell]:
    """The cells that sampling has reached."""
    cells: list[Cell] = []

    def recorded(state: LineState | None, event: LineTrigger) -> LineState | None:
        cells.append((state, event))
        return following(state, event)

    monkeypatch.setattr("mikas.sampling.supervisor.following", recorded)
    return cells


class World:
    """A unit at a port, and what can happen to both."""

    def __init__(self, **settings: object) -> None:
        self.plug = SimulatedPlug(make_bus())
        self.sampler = make_sampler(self.plug, "TWAT", "INJ", method="batch", **settings)
        self.unit = self.plug.bus.ecu.responder

    def adapter_out(self) -> None:
        self.plug.plugged_in = False
        if self.plug.link is not None:
            self.plug.link.unplug()

    def adapter_out_at_first_use(self) -> None:
        """The port opens, and the adapter goes before the first request."""
        self.mend()
        opened = self.plug.open

        def open_once() -> object:
            self.plug.open = opened
            link = opened()
            link.unplug()
            return link

        self.plug.open = open_once

    def no_supply(self) -> None:
        self.mend()
        self.plug.unsupply()

    def key_off(self) -> None:
        self.mend()
        self.unit.car.on = False

    def damage(self) -> None:
        self.mend()
        self.plug.bus.fault_injector.rates = {LineFault.DAMAGED: 1.0}

    def another_unit(self) -> None:
        self.mend()
        self.unit.identity = Identity(0x0A, ("ANOTHER", *PASSPORTS[1:]))

    def another_version_after_a_dip(self) -> None:
        """The supply is gone for 0.3 s; then a unit of another version answers."""
        self.unit.identity = Identity(0x09, PASSPORTS)
        self.unit.car.on = False
        self.plug.at(self.plug.now() + 0.3, self.mend)

    def refuse_all(self) -> None:
        """The unit answers 01 to both parameters that are sampled, and knows others."""
        self.unit.quirks = EcuQuirks(unknown=Unknown.ERROR)
        for code in (0x1A, 0x3F):
            self.unit.car.data.pop(code, None)

    def another_version_while_it_refuses(self) -> None:
        """The unit is exchanged while each refused parameter is asked for alone."""

        def exchange(_: object) -> None:
            self.unit.identity = Identity(0x09, PASSPORTS)
            self.plug.bus.fault_injector.next(LineFault.DAMAGED)

        self.unit.quirks = EcuQuirks(missing=frozenset({0x61}), unknown=Unknown.ERROR)
        self.sampler.call(exchange)

    def mend(self) -> None:
        self.plug.mend()
        self.unit.car.on = True
        self.plug.bus.fault_injector.rates = {}

    def replay_over(self) -> None:
        def read(deadline: float) -> None:
            raise RecordingOver(url="replay:", file="drive.pcapng")

        assert self.plug.link is not None
        self.plug.link.read = read

    def another_plan(self) -> None:
        self.sampler.reconfigure(["UACC"], "batch")

    def stop(self) -> None:
        self.sampler.stop()


LEADS_TO: dict[LineState | None, Callable[[World], None]] = {
    None: lambda world: None,
    LineState.NO_PORT: World.adapter_out,
    LineState.NO_ECHO: World.no_supply,
    LineState.ECHO_ONLY: World.key_off,
    LineState.ECU_ALIVE: World.mend,
    LineState.SAMPLING: World.mend,
}
CAUSES: dict[LineTrigger, Callable[[World], None]] = {
    LineTrigger.PORT_MISSING: World.adapter_out,
    LineTrigger.PORT_LOST: World.adapter_out,
    LineTrigger.ECHO_MISSING: World.no_supply,
    LineTrigger.SILENT: World.key_off,
    LineTrigger.SPOILT: World.damage,
    LineTrigger.IDENTIFIED: World.mend,
    LineTrigger.ACCEPTED: World.another_plan,
    LineTrigger.REFUSED: World.refuse_all,
    LineTrigger.ENDED: World.stop,
}


def cause_of(state: LineState | None, event: LineTrigger) -> Callable[[World], None]:
    """Return what makes `event` happen; a unit that was identified is resynchronized first."""
    if event is LineTrigger.SPOILT and state is LineState.ECU_ALIVE:
        return World.another_version_while_it_refuses
    if event is LineTrigger.SPOILT and state is LineState.SAMPLING:
        return World.another_version_after_a_dip
    return CAUSES[event]


def until_state(world: World, events: Iterator[Event], state: LineState | None) -> None:
    """Take events until `state` is reported; SAMPLING with a sample of an identified unit."""
    if state is None:
        return
    LEADS_TO[state](world)
    take(events, lambda e: e[-1].state is state if isinstance(e[-1], StateChanged) else False)
    if state is LineState.SAMPLING:
        take(events, lambda e: bool(of(Sampled, e)) and world.sampler._supervisor.unit is not None)  # noqa: SLF001


def run_on(world: World, events: Iterator[Event], reached: list[Cell], cell: Cell) -> None:
    """Take events until `cell` is reached; without any event the run ends after a while."""
    world.plug.at(world.plug.now() + SECONDS, world.stop)
    for _ in events:
        if cell in reached:
            break


def simple(cell: Cell) -> bool:
    """Whether the scenario is: come to the state, then let the event's cause happen."""
    state, event = cell
    return cell not in SPECIAL and (state is not None or event is not LineTrigger.ENDED)


def test_a_port_lost_at_first_use_is_no_port(reached: list[Cell]) -> None:
    world = World()
    world.adapter_out_at_first_use()
    with closing(world.sampler.run()) as events:
        run_on(world, events, reached, (LineState.SAMPLING, LineTrigger.ACCEPTED))
    assert reached[:2] == [
        (None, LineTrigger.PORT_LOST),
        (LineState.NO_PORT, LineTrigger.IDENTIFIED),
    ]


def test_a_port_lost_at_first_use_after_it_was_missing_stays_no_port(reached: list[Cell]) -> None:
    world = World()
    with closing(world.sampler.run()) as events:
        until_state(world, events, LineState.NO_PORT)
        world.adapter_out_at_first_use()
        run_on(world, events, reached, (LineState.NO_PORT, LineTrigger.PORT_LOST))
    assert (LineState.NO_PORT, LineTrigger.PORT_LOST) in reached


def test_another_unit_is_identified_twice(reached: list[Cell]) -> None:
    world = World()
    with closing(world.sampler.run()) as events:
        until_state(world, events, LineState.SAMPLING)
        until_state(world, events, LineState.ECHO_ONLY)
        world.another_unit()
        run_on(world, events, reached, (LineState.ECU_ALIVE, LineTrigger.IDENTIFIED))
    assert reached[-3:-1] == [
        (LineState.ECHO_ONLY, LineTrigger.IDENTIFIED),
        (LineState.ECU_ALIVE, LineTrigger.IDENTIFIED),
    ]


def test_a_unit_that_goes_on_refusing_everything_stays_alive(reached: list[Cell]) -> None:
    world = World()
    with closing(world.sampler.run()) as events:
        until_state(world, events, LineState.SAMPLING)
        world.refuse_all()
        run_on(world, events, reached, (LineState.ECU_ALIVE, LineTrigger.REFUSED))
    assert reached[-3:-1] == [
        (LineState.SAMPLING, LineTrigger.REFUSED),
        (LineState.ECU_ALIVE, LineTrigger.REFUSED),
    ]


def test_sampling_begins_with_the_first_accepted_cycle(reached: list[Cell]) -> None:
    world = World()
    with closing(world.sampler.run()) as events:
        until_state(world, events, LineState.SAMPLING)
    assert reached == [
        (None, LineTrigger.IDENTIFIED),
        (LineState.ECU_ALIVE, LineTrigger.ACCEPTED),
        (LineState.SAMPLING, LineTrigger.ENDED),
    ]


def test_a_strict_run_ends_before_any_state(reached: list[Cell]) -> None:
    world = World(strict=True)
    world.adapter_out()
    with pytest.raises(MikasError):
        list(world.sampler.run())
    assert reached == [(None, LineTrigger.ENDED)]


def test_a_silent_network_may_be_unreachable_next(reached: list[Cell]) -> None:
    world = World()
    opened = world.plug.open

    def open_silent() -> object:
        link = opened()

        def read(deadline: float) -> None:
            raise ConnectionSilent(url="socket://bridge:1", seconds=2)

        link.read = read
        world.plug.plugged_in = False
        return link

    world.plug.open = open_silent
    with closing(world.sampler.run()) as events:
        run_on(world, events, reached, (LineState.NO_ECHO, LineTrigger.PORT_MISSING))
    assert reached[:2] == [
        (None, LineTrigger.ECHO_MISSING),
        (LineState.NO_ECHO, LineTrigger.PORT_MISSING),
    ]


SPECIAL: dict[Cell, Callable[[list[Cell]], None]] = {
    (None, LineTrigger.PORT_LOST): test_a_port_lost_at_first_use_is_no_port,
    (
        LineState.NO_PORT,
        LineTrigger.PORT_LOST,
    ): test_a_port_lost_at_first_use_after_it_was_missing_stays_no_port,
    (LineState.ECU_ALIVE, LineTrigger.IDENTIFIED): test_another_unit_is_identified_twice,
    (
        LineState.ECU_ALIVE,
        LineTrigger.REFUSED,
    ): test_a_unit_that_goes_on_refusing_everything_stays_alive,
    (LineState.ECU_ALIVE, LineTrigger.ACCEPTED): test_sampling_begins_with_the_first_accepted_cycle,
    (None, LineTrigger.ENDED): test_a_strict_run_ends_before_any_state,
    (LineState.NO_ECHO, LineTrigger.PORT_MISSING): test_a_silent_network_may_be_unreachable_next,
}


@pytest.mark.parametrize(("state", "event"), [cell for cell in CELLS if simple(cell)])
def test_every_other_cell_is_reached_by_its_cause(
    state: LineState | None, event: LineTrigger, reached: list[Cell]
) -> None:
    world = World()
    with closing(world.sampler.run()) as events:
        until_state(world, events, state)
        reached.clear()
        cause_of(state, event)(world)
        run_on(world, events, reached, (state, event))
    assert (state, event) in reached


def test_only_the_end_leads_to_not_running() -> None:
    for state, row in TRANSITIONS.items():
        for event, to in row.items():
            assert (to is None) == (event is LineTrigger.ENDED), (state, event)


@pytest.mark.parametrize("end", [World.replay_over, World.stop])
def test_the_end_of_a_recording_and_stop_end_the_run(
    end: Callable[[World], None], reached: list[Cell]
) -> None:
    world = World()
    with closing(world.sampler.run()) as events, suppress(RecordingOver):
        until_state(world, events, LineState.SAMPLING)
        end(world)
        list(events)
    assert reached[-1] == (LineState.SAMPLING, LineTrigger.ENDED)


def test_an_elm327_ends_the_run_before_any_state(reached: list[Cell]) -> None:
    port = ReconnectingPort("sim:?adapter=elm327&clock=simulated", open_port=open_link)
    with pytest.raises(MikasError):
        list(Acquisition(port, ecu_factory(), SECTION_4, ["FREQ"]).run())
    assert reached == [(None, LineTrigger.ENDED)]


def test_a_method_that_the_unit_lacks_changes_no_state(reached: list[Cell]) -> None:
    bus = make_bus(quirks=EcuQuirks(missing=GROUPS["stream"]))
    with closing(make_sampler(SimulatedPlug(bus), "FREQ", method="stream").run()) as events:
        take(events, lambda e: len(of(Sampled, e)) > 10)
    assert set(reached) == {
        (None, LineTrigger.IDENTIFIED),
        (LineState.ECU_ALIVE, LineTrigger.ACCEPTED),
        (LineState.SAMPLING, LineTrigger.ACCEPTED),
        (LineState.SAMPLING, LineTrigger.ENDED),
    }


@pytest.mark.parametrize("state", [None, *LineState])
@pytest.mark.parametrize("event", LineTrigger)
def test_an_event_without_a_cell_raises(state: LineState | None, event: LineTrigger) -> None:
    if event in TRANSITIONS[state]:
        assert following(state, event) is TRANSITIONS[state][event]
        return
    name = state.name if state else "None"
    with pytest.raises(ImpossibleTransition, match=f"{event.name} cannot occur in state {name}"):
        following(state, event)


@pytest.mark.parametrize(
    ("error", "event"),
    [
        (NoEcho(), LineTrigger.ECHO_MISSING),
        (EchoOnly(), LineTrigger.SILENT),
        (SyncLost(), LineTrigger.SPOILT),
        (PortBusy(url="sim:"), LineTrigger.ECHO_MISSING),
    ],
)
def test_each_error_is_the_event_of_its_kind(error: MikasError, event: LineTrigger) -> None:
    assert trigger_of(error) is event


HAPPENS = st.sampled_from(
    [
        World.adapter_out,
        World.adapter_out_at_first_use,
        World.no_supply,
        World.key_off,
        World.damage,
        World.another_unit,
        World.mend,
        World.another_plan,
        World.refuse_all,
        World.another_version_after_a_dip,
        World.another_version_while_it_refuses,
    ]
)


@settings(max_examples=25, deadline=None)
@given(st.lists(st.tuples(HAPPENS, st.floats(0.05, 6.0)), min_size=1, max_size=8))
def test_whatever_happens_on_the_line_no_other_transition_occurs(
    happens: list[tuple[Callable[[World], None], float]],
) -> None:
    """`ImpossibleTransition` would end the run; each reported state follows from the one before."""
    world = World()
    time = 0.0
    for cause, seconds in happens:
        time += seconds
        world.plug.at(time, lambda cause=cause: cause(world))
    world.plug.at(time + 6.0, world.stop)
    before: LineState | None = None
    with suppress(MikasError), closing(world.sampler.run()) as events:
        for event in events:
            if isinstance(event, StateChanged):
                assert event.state in TRANSITIONS[before].values()
                before = event.state
    assert world.plug.now() < time + 60


def test_an_adapter_without_supply_at_the_beginning_is_no_echo(reached: list[Cell]) -> None:
    plug = SimulatedPlug(make_bus(adapter=AdapterKind(supplied=False)))
    with closing(make_sampler(plug).run()) as events:
        next(events)
    assert reached == [(None, LineTrigger.ECHO_MISSING), (LineState.NO_ECHO, LineTrigger.ENDED)]
