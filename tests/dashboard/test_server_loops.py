"""What runs for as long as the program: an error in one turn ends no loop, and is reported.

Of the others: the sweep of connections in test_connections, dumps in test_dump_jobs_kept, lanes in
test_lanes. Leases, locks and confirmations have no timer: their end is a comparison with the clock.
"""

from __future__ import annotations

import asyncio
import json
import threading
from types import SimpleNamespace

import pytest

from dashboard.rig import ME, rig
from mikas.dashboard.connections import TcpConnections, TcpLimits
from mikas.dashboard.entrance import Entrance
from mikas.dashboard.network.listening import listen
from mikas.dashboard.server import Server
from mikas.saving import KeptFile


class Bug(Exception):
    """Any exception that no code expects."""


class Failing:
    """Raises while `broken`, then calls `function`."""

    def __init__(self, function=lambda: None):
        self.function, self.broken, self.calls = function, True, 0

    def __call__(self, *args, **kwargs):
        self.calls += 1
        if self.broken:
            raise Bug
        return self.function(*args, **kwargs)


def reported(caplog):
    """How many bugs were reported, as their own records or in the text of one."""
    own = sum(isinstance((it.exc_info or (0, 0))[1], Bug) for it in caplog.records)
    return own + sum(f"{__name__}.Bug" in it.getMessage() for it in caplog.records)


@pytest.mark.parametrize("part", ["sweep", "check", "sharing"])
def test_no_part_of_a_tick_ends_the_server(part, caplog):
    parts = {"sweep": Failing(), "check": Failing(), "sharing": Failing()}
    ending = SimpleNamespace(check=parts["check"])
    sharing = SimpleNamespace(check=parts["sharing"])
    server = Server(SimpleNamespace(state=SimpleNamespace(ending=ending, sharing=sharing)))
    server.guard.sweep = parts["sweep"]
    for it in parts.values():
        it.broken = it is parts[part]

    async def ticks(count):
        assert not any([await server.on_tick(number) for number in range(count)])

    asyncio.run(ticks(50))
    assert [it.calls for it in parts.values()] == [5, 5, 5]
    assert reported(caplog) == 1
    parts[part].broken = False
    asyncio.run(ticks(10))
    parts[part].broken = True
    asyncio.run(ticks(50))
    assert reported(caplog) == 2  # another time
    server.should_exit = True
    assert asyncio.run(server.on_tick(0))


def clients_of(entrance_of, count, monkeypatch):
    """Connect one client after the other; return what the loop reported beside the log."""
    monkeypatch.setattr("mikas.dashboard.entrance._OUT_OF_DESCRIPTORS", 0.001)
    caught = []

    async def main():
        with listen(0, lan=False) as own:
            loop = asyncio.get_running_loop()
            loop.set_exception_handler(lambda _, context: caught.append(context["exception"]))
            entrance, acts = entrance_of(own)
            entrance.open()
            for number in range(1, count + 1):
                _, writer = await asyncio.open_connection(*own.getsockname())
                while acts.calls < number:
                    await asyncio.sleep(0)
                acts.broken = False
                writer.close()
            await entrance.close()

    asyncio.run(main())
    return caught


def test_a_connection_without_a_protocol_is_one_only(monkeypatch, caplog):
    create = Failing(asyncio.Protocol)
    guard = TcpConnections(TcpLimits(64), lambda: 0.0)
    caught = clients_of(lambda own: (Entrance(own, create, guard, None), create), 3, monkeypatch)
    assert create.calls == 3
    assert len(caught) + reported(caplog) == 1


def test_a_connection_that_can_t_be_accepted_is_tried_again(monkeypatch, caplog):
    guard = TcpConnections(TcpLimits(64), lambda: 0.0)
    admit = guard.admit = Failing(guard.admit)
    entrance = lambda own: (Entrance(own, asyncio.Protocol, guard, None), admit)  # noqa: E731
    assert clients_of(entrance, 3, monkeypatch) == []
    assert reported(caplog) == 1


def test_a_timer_of_one_connection_ends_nothing(off, caplog):
    with off.live() as live:
        live.next()
        off.reached.loop.call_soon_threadsafe(Failing())  # as uvicorn's of pings and keep-alive
        live.send({"ping": 1})
        live.until(lambda it: "pong" in it)
    off.get("/state")
    assert reported(caplog) == 1


def test_a_bug_in_the_live_data_ends_no_page(shared_idle, caplog):
    broadcaster = shared_idle.server._app.state.broadcaster  # noqa: SLF001
    tick = broadcaster.tick = Failing(broadcaster.tick)
    with shared_idle.live() as live:
        live.next()
        while tick.calls < 3:
            shared_idle.get("/state")
        tick.broken = False
        live.until(lambda it: "data" in it)
    assert reported(caplog) == 1
    del broadcaster.tick


def test_a_bug_in_the_sampling_is_shown_and_ends_in_a_new_connection(idle, caplog, monkeypatch):
    with monkeypatch.context() as patch:
        patch.setattr(idle.dashboard.monitor, "add_event", Failing())
        idle.until(lambda it: it["state"]["reason_code"] == "InternalError")
    assert reported(caplog) == 1
    assert idle.cars.links[-1]._gone.is_set()  # noqa: SLF001
    idle.post("/connect", {"port": "sim:?scenario=warm-idle"})
    idle.sampling()


def test_a_bug_in_the_diagnosis_is_a_step_and_gives_the_port_back(idle, caplog, monkeypatch):
    with monkeypatch.context() as patch:
        patch.setattr(
            "mikas.dashboard.session.port_threads.examine", lambda *_, **__: iter(Failing(), 0)
        )
        lines = idle.client.post("/api/doctor", json={}, headers=ME).text.splitlines()
    (step,) = map(json.loads, lines)
    assert (step["code"], step["ok"]) == ("InternalError", False)
    assert "mikas" in step["detail"]["en"]
    assert reported(caplog) == 1
    idle.sampling()


def ended_threads(name):
    for thread in threading.enumerate():
        if name in thread.name:
            thread.join(60)


def test_a_result_that_can_t_be_saved_ends_no_more_than_its_thread(shared_idle, monkeypatch):
    ended, guided = [], shared_idle.dashboard.guided
    monkeypatch.setattr("threading.excepthook", lambda it: ended.append(it.exc_type))
    with monkeypatch.context() as patch:
        patch.setattr(KeptFile, "save", Failing())
        guided._keep([])  # noqa: SLF001
        ended_threads("mikas test result")
    assert ended == [Bug]
    guided._keep([])  # noqa: SLF001
    ended_threads("mikas test result")
    assert guided.file.load() == []


def test_a_freeze_frame_that_can_t_be_saved_ends_no_more_than_its_thread(shared_idle, monkeypatch):
    ended, store = threading.Event(), shared_idle.dashboard.freeze_frames
    monkeypatch.setattr("threading.excepthook", lambda it: ended.set())
    frame = SimpleNamespace(id="1.000-1", seen=1.0, code=1, as_json=Failing())
    frame.moved = lambda _: frame
    store._keep(frame)  # noqa: SLF001
    assert ended.wait(60)
    assert store.frames == [frame]
    frame.as_json.broken = False
    store._keep(frame, at_once=True)  # noqa: SLF001
    assert store.delete(frame.id)
    shared_idle.sampling()


@pytest.mark.parametrize("step", ["entrance", "sharing", "library", "dumps", "port", "uvicorn"])
def test_a_bug_at_the_end_leaves_the_recording_whole(tmp_path, step, caplog, monkeypatch):
    async def fail(*_):
        raise Bug

    with rig(tmp_path, "sim:?scenario=warm-idle") as it:
        it.sampling()
        it.post("/recording/start", {"name": "last"})
        state = it.server._app.state  # noqa: SLF001
        if step == "sharing":
            state.sharing.close_for_good = fail
        elif step == "library":
            state.dashboard.library.close = Failing(state.dashboard.library.close)
        else:
            monkeypatch.setattr("uvicorn.Server.shutdown", fail)
    assert it.dashboard.recorder.last.failure is None
    assert it.dashboard.recorder.last.path.name == "last.pcapng"
    assert Bug.__name__ in caplog.text
    it.dashboard.connection.stop()  # as the command line does
    assert it.cars.links[-1]._gone.is_set()  # noqa: SLF001
