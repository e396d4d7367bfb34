"""Live data: content, rate and recipients; slow, dead and flooding clients."""

from __future__ import annotations

import asyncio
import json
import socket
import threading

import pytest
from websockets.exceptions import ConnectionClosed

from dashboard.rig import rig
from mikas.dashboard.api.live import QUEUE, Broadcaster, Listener, _send, handle_request
from mikas.dashboard.api.state import shared_state
from mikas.dashboard.dashboard import Dashboard
from mikas.dashboard.security.control import Client
from mikas.dashboard.session.history import History
from mikas.dashboard.session.monitor import _ROWS, ConnectionMonitor
from mikas.dashboard.settings import Settings
from mikas.sampling.events import Sampled
from mikas.sampling.session import SamplingSession


def test_the_first_message_has_the_state(shared_off):
    with shared_off.live() as live:
        first = live.next()
        assert (first["seq"], first["dropped"]) == (1, 0)
        assert first["state"]["line"] == "off"
        assert first["state"]["viewers"] == 1
        assert first["now"] > 1e9


def test_values_come_as_the_car_has_them(idle):
    message = idle.until(lambda it: "data" in it and it["state"]["rate"] > 0)
    data = message["data"]
    assert data["names"] == ["FREQ", "TWAT", "UACC", "INJ", "DET", "FUEL_FLOW"]
    assert all(len(column) == len(data["times"]) for column in data["values"])
    latest = {name: column[-1] for name, column in zip(data["names"], data["values"], strict=True)}
    assert 80 < latest["TWAT"] < 105
    assert 600 < latest["FREQ"] < 1100
    assert latest["DET"] in (0, 1)


def test_a_slow_parameter_is_null_between_its_turns(idle):
    idle.put(
        "/plan",
        {"wanted": [{"name": "FREQ"}, {"name": "TWAT", "every": 3}], "method": "batch", "rate": 5},
    )
    columns = {"FREQ": [], "TWAT": []}
    with idle.live() as live:
        while len(columns["TWAT"]) < 12:
            data = live.until(lambda it: it.get("data", {}).get("names") == ["FREQ", "TWAT"])[
                "data"
            ]
            for name, column in zip(data["names"], data["values"], strict=True):
                columns[name] += column
    assert None not in columns["FREQ"]
    assert 0 < sum(value is not None for value in columns["TWAT"]) <= len(columns["TWAT"]) / 2


def test_a_client_may_want_some_columns_only(idle):
    with idle.live() as live, idle.live("watcher-0002") as other:
        live.send({"fields": ["UACC", "FREQ", "nothing"]})
        got = live.until(lambda it: it.get("data", {}).get("names") == ["FREQ", "UACC"])
        assert len(got["data"]["values"]) == 2
        assert len(other.until(lambda it: "data" in it)["data"]["names"]) == 6
        live.send({"fields": []})
        live.until(lambda it: it.get("data", {}).get("names") == [])
        live.send({"fields": None})
        live.until(lambda it: len(it.get("data", {}).get("names", ())) == 6)


def test_a_ping_is_answered(shared_off):
    with shared_off.live() as live:
        for ping in (1, 'a"b', 2.5):
            live.send({"ping": ping})
            assert live.until(lambda it: "pong" in it)["pong"] == ping


@pytest.mark.parametrize(
    "message",
    ["", "x", "[]", "{}", '{"ping": null}', '{"ping": 1, "x": 2}', '{"fields": 1}',
     '{"fields": [1]}', '{"plan": []}', b"\x00", '{"ping": NaN}', "[" * 100_0, "x" * 5000,
     json.dumps({"fields": ["A"] * 201})],
)  # fmt: skip
def test_what_makes_no_sense_ends_the_talk(shared_off, message):
    with shared_off.live() as live:
        live.socket.send(message)
        with pytest.raises(ConnectionClosed) as ended:
            live.until(lambda _: False)
        assert ended.value.rcvd.code == 1008


def flood(live):
    for number in range(10_000):
        live.send({"ping": number})
    live.until(lambda _: False)


def test_who_floods_is_shown_the_door_and_the_others_see_nothing_of_it(idle):
    with idle.live("watcher-0002") as other:
        other.next()
        with idle.live() as live:
            with pytest.raises(ConnectionClosed) as ended:
                flood(live)
            assert ended.value.rcvd is None or ended.value.rcvd.code == 1008
        assert other.until(lambda it: "data" in it)["dropped"] == 0


def test_a_slow_reader_stops_no_other_and_loses_whole_messages(tmp_path):
    with rig(tmp_path, "sim:?scenario=warm-idle", rate=None) as it:
        it.sampling()
        deaf = socket.create_connection(("127.0.0.1", it.port))
        deaf.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        deaf.sendall(
            f"GET /api/live?client=deaf-0001 HTTP/1.1\r\nHost: 127.0.0.1:{it.port}\r\n"
            "Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
            "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n".encode()
        )
        assert deaf.recv(12) == b"HTTP/1.1 101"
        with it.live() as live:
            samples = live.until(lambda m: m["state"]["viewers"] == 2)["state"]["samples"]
            latest = live.until(lambda m: m["state"]["samples"] > samples + 500)
            assert latest["dropped"] == 0
        deaf.close()
        with it.live() as live:
            live.until(lambda m: m["state"]["viewers"] == 1)


def test_the_queue_is_bounded_and_counts_its_losses():
    listener = Listener(Client("x", "", False))
    for number in range(QUEUE + 3):
        listener.offer(f',"data":{number}')
    assert len(listener.waiting) == QUEUE
    first = json.loads(listener.next(1.0, '"rights":"view"', (1, '"line":"off"')))
    assert (first["dropped"], first["data"], first["state"]["line"]) == (3, 3, "off")
    second = json.loads(listener.next(2.0, "", (1, '"line":"off"')))
    assert (second["dropped"], second["data"], second["seq"]) == (0, 4, 2)
    assert "state" not in second


def test_deeply_nested_json_is_no_request():
    listener = Listener(Client("x", "", False))
    assert not handle_request(listener, "[" * 4000)


def test_a_reload_finds_what_it_missed_in_the_history(idle):
    idle.put("/plan", {"wanted": [{"name": "FREQ"}], "method": "batch", "rate": 5})
    idle.until(lambda it: it.get("data", {}).get("names") == ["FREQ"])
    past = idle.get("/history", seconds=60, points=100, names="FREQ,TWAT")
    assert past["names"] == ["FREQ", "TWAT"]
    assert past["times"] == sorted(past["times"])
    assert any(value is not None for value in past["values"][1])
    assert past["values"][1][-1] is None  # no longer asked
    kinds = {event["kind"] for event in idle.get("/history", seconds=3600)["events"]}
    assert {"unit", "state"} <= kinds


def listener(name):
    return Listener(Client(name, "", False))


def test_nothing_is_gathered_after_the_last_client_has_gone(tmp_path):
    dashboard = Dashboard(Settings(tmp_path, state=tmp_path))

    def gathered():
        dashboard.monitor.add_event(Sampled(1.0, {}, {}))
        return len(dashboard.monitor.drain().times)

    async def come_and_go():
        broadcaster, one, another = Broadcaster(dashboard), listener("one"), listener("another")
        broadcaster.join(one)
        broadcaster.join(another)
        broadcaster.leave(one)
        assert gathered() == 1
        dashboard.monitor.add_event(Sampled(2.0, {}, {}))
        broadcaster.leave(another)

    assert gathered() == 0
    asyncio.run(come_and_go())
    assert not dashboard.monitor.drain().times
    assert gathered() == 0


def test_what_is_gathered_is_bounded():
    monitor = ConnectionMonitor(History(), SamplingSession())
    monitor.listened = True
    for number in range(_ROWS + 10):
        monitor.add_event(Sampled(number / 10, {}, {}))  # within what the history keeps
    assert len(monitor.drain().times) == _ROWS


def test_a_bug_in_one_message_does_not_end_the_others(idle, monkeypatch, caplog):
    met = threading.Event()

    def broken_once(dashboard):
        if not met.is_set():
            met.set()
            raise ValueError("the bug of this test")
        return shared_state(dashboard)

    with idle.live() as live:
        live.until(lambda it: "data" in it)
        monkeypatch.setattr("mikas.dashboard.api.live.shared_state", broken_once)
        assert met.wait(60)
        live.until(lambda it: "data" in it)
    assert "the bug of this test" in caplog.text


def test_a_bug_while_waiting_for_news_does_not_end_the_live_data(idle, monkeypatch, caplog):
    met, wait = threading.Event(), ConnectionMonitor.wait

    def broken_once(monitor, wake):
        if not met.is_set():
            met.set()
            raise ValueError("the bug of this test")
        return wait(monitor, wake)

    with idle.live() as live:
        live.until(lambda it: "data" in it)
        monkeypatch.setattr(ConnectionMonitor, "wait", broken_once)
        assert met.wait(60)
        live.until(lambda it: "data" in it)
    assert "the bug of this test" in caplog.text


def test_one_client_too_many_gets_try_later(shared_off, monkeypatch):
    with shared_off.live() as live:
        live.next()
        monkeypatch.setattr("mikas.dashboard.api.live._MAX_CLIENTS", 1)
        with shared_off.live("watcher-0002") as other:
            with pytest.raises(ConnectionClosed) as ended:
                other.next()
            assert ended.value.rcvd.code == 1013
        live.send({"ping": 1})
        live.until(lambda it: it.get("pong") == 1)


def test_viewers_from_the_network_leave_places_for_this_computer(tmp_path, monkeypatch):
    monkeypatch.setattr(Broadcaster, "_run", lambda _: asyncio.sleep(0))

    def come(broadcaster, address, count):
        came = 0
        for number in range(count):
            if broadcaster.has_room(address):
                client = Client(f"{address}-{number}", "", False)
                broadcaster.join(Listener(client, "", address))
                came += 1
        return came

    async def all_come():
        it = Broadcaster(Dashboard(Settings(tmp_path, state=tmp_path)))
        came = [come(it, address, 40) for address in ("10.0.0.1", "10.0.0.2", "10.0.0.3", "x")]
        assert came == [8, 8, 8, 0]
        one = next(iter(it.listeners))
        again = Listener(one.client, one.page, one.address)
        it.replace(again)
        assert it.has_room(again.address)  # for the page that connects again
        assert come(it, None, 40) == 9

    asyncio.run(all_come())


class BrokenSocket:
    """Can't send a message."""

    def __init__(self):
        self.closed = None

    async def send_text(self, text):
        text.encode("utf-8-unknown")

    async def close(self, code):
        self.closed = code


def test_a_message_that_can_not_be_sent_ends_its_connection(tmp_path, caplog):
    broadcaster = Broadcaster(Dashboard(Settings(tmp_path, state=tmp_path)))
    broken, waiting = BrokenSocket(), listener("broken")
    waiting.offer("")
    asyncio.run(_send(broken, waiting, broadcaster))
    assert broken.closed == 1011
    assert "utf-8-unknown" in caplog.text
