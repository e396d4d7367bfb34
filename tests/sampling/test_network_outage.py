"""A network that carries nothing for a while: the state is true soon, and values are back soon."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import closing
from dataclasses import replace
from itertools import product
from math import inf

import pytest
from sampling_harness import SimulatedPlug, WatchedLink, make_sampler, of

from mikas.errors import ConnectionSilent, PortFailed, PortKind
from mikas.i18n import Text
from mikas.link import Chunk, Link
from mikas.link.base import NETWORK
from mikas.link.network.silence import SILENT
from mikas.link.reconnecting import ReconnectingPort
from mikas.sampling.events import CycleFailed, Event, LineState, Sampled, StateChanged
from virtual_harness import make_bus

URL = "socket://bridge:7777"
DIES, WARNED, BACK_WITHIN = 8.0, 3.0, 5.0
METHODS = ("single", "list", "batch", "stream")
REFUSED = PortFailed(url=URL, problem=Text("no answer from there", "узел не отвечает"))


class BridgedLink(WatchedLink):
    """A connection to a bridge, which carries nothing any more once it is `dead`."""

    kind = PortKind.NETWORK

    def __init__(self, world: World) -> None:
        super().__init__(world.plug)
        self.url = URL
        self.granularity = NETWORK
        self.world = world
        self.dead = world.mute

    def write(self, data: bytes) -> None:
        if not self.dead:
            super().write(data)

    def read(self, deadline: float) -> Chunk:
        chunk = super().read(deadline)
        while self.dead and chunk.time < deadline:
            chunk = super().read(deadline)
        return Chunk(b"", chunk.time) if self.dead else chunk


class World:
    """A unit behind a bridge. `mute`: connections come, and carry nothing. `away`: none come."""

    def __init__(self, method: str = "batch", **settings: object) -> None:
        self.plug = SimulatedPlug(make_bus())
        self.mute = self.away = False
        self.opened: list[float] = []
        self.link: BridgedLink | None = None
        self.port = ReconnectingPort(
            URL, open_port=self.open, clock=self.plug.now, wait=self.plug.wait
        )
        self.sampler = make_sampler(self.port, "FREQ", method=method, rate=5, **settings)

    def open(self, url: str) -> Link:
        if self.away:
            self.plug.wait(2.0)
            raise REFUSED
        self.opened.append(self.plug.now())
        self.plug.link = self.link = BridgedLink(self)
        return self.link

    def dies(self, **how: bool) -> Callable[[], None]:
        def die() -> None:
            self.link.dead = True
            self.__dict__.update(how)

        return die

    def comes_back(self) -> None:
        """New connections carry; the old one stays dead."""
        self.mute = self.away = False

    def run(self, until: float) -> list[Event]:
        self.plug.at(until, self.sampler.stop)
        with closing(self.sampler.run()) as events:
            return list(events)


def states(events: list[Event]) -> list[tuple[float, LineState]]:
    return [(event.time, event.state) for event in of(StateChanged, events)]


def first_value(events: list[Event], after: float) -> float:
    return min((event.time for event in of(Sampled, events) if event.time > after), default=inf)


@pytest.mark.parametrize(
    ("method", "how", "seconds"),
    [*product(METHODS, ("mute", "away"), (8.0,)), ("batch", "mute", 60.0), ("batch", "away", 60.0)],
)
def test_the_state_is_true_soon_and_values_are_back_soon(method, how, seconds):
    world = World(method)
    world.plug.at(DIES, world.dies(**{how: True}))
    back = DIES + seconds
    world.plug.at(back, world.comes_back)
    events = world.run(back + 12.0)
    changes = [(time, state) for time, state in states(events) if time > DIES]
    assert changes[0][0] < DIES + WARNED
    assert changes[0][1] is LineState.NO_ECHO
    assert first_value(events, back) < back + BACK_WITHIN
    assert changes[-1][1] is LineState.SAMPLING


@pytest.mark.parametrize("method", METHODS)
def test_a_bridge_that_keeps_its_connection_and_carries_nothing_gets_a_new_one(method):
    world = World(method)
    world.plug.at(DIES, world.dies())
    events = world.run(DIES + 8.0)
    assert first_value(events, DIES + 0.3) < DIES + BACK_WITHIN
    assert len(world.opened) == 2


def test_what_cannot_be_reached_has_its_reason():
    world = World()
    world.plug.at(DIES, world.dies(away=True))
    events = world.run(DIES + 30.0)
    last = of(StateChanged, events)[-1]
    assert (last.state, last.error) == (LineState.NO_PORT, REFUSED)
    entered = dict.fromkeys(state for time, state in states(events) if time > DIES)
    assert [*entered] == [LineState.NO_ECHO, LineState.NO_PORT]


def key_off(world: World) -> None:
    world.plug.bus.ecu.responder.car.on = False


@pytest.mark.parametrize("quiet", [World.dies, key_off])
def test_what_stays_silent_is_opened_anew_and_its_state_stays(quiet):
    world = World()
    adapter = world.plug.bus.adapter
    adapter.kind = replace(adapter.kind, echo=False)
    if quiet is World.dies:
        world.plug.at(DIES, world.dies(mute=True))
    else:
        world.plug.at(DIES, lambda: key_off(world))
    events = world.run(DIES + 120.0)
    changes = [event for event in of(StateChanged, events) if event.time > DIES]
    assert {event.state for event in changes} == {LineState.NO_ECHO}
    assert len(changes) <= 2  # no echo; and that the connection is opened anew
    assert type(changes[-1].error) is ConnectionSilent
    anew = [time for time in world.opened if time > DIES]
    assert 10 < len(anew) <= 120 / SILENT + 2
    assert of(CycleFailed, events)  # which goes on saying that it waits


def test_an_adapter_without_echo_finds_its_unit_again_when_the_ignition_is_on():
    world = World()
    adapter = world.plug.bus.adapter
    adapter.kind = replace(adapter.kind, echo=False)
    world.plug.at(DIES, lambda: key_off(world))
    on = DIES + 63.0
    world.plug.at(on, lambda: setattr(world.plug.bus.ecu.responder.car, "on", True))
    events = world.run(on + 8.0)
    assert first_value(events, on) < on + BACK_WITHIN
    assert states(events)[-1][1] is LineState.SAMPLING


def test_opening_that_takes_its_time_is_tried_again_at_once():
    world = World()
    world.away = True
    tried = []
    opened = world.open
    world.port.open_port = lambda url: tried.append(world.plug.now()) or opened(url)
    world.run(30.0)
    assert 12 <= len(tried) <= 15


def test_a_strict_run_ends_with_the_missing_echo():
    world = World(strict=True)
    world.mute = True
    with pytest.raises(Exception, match="not even"):
        world.run(30.0)
