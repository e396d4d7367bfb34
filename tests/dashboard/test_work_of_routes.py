"""Work that a client causes: every route that computes does it in a lane, so that no viewer's work
makes the owner wait. A route without a lane is listed here with the reason why it needs none.
"""

from __future__ import annotations

import asyncio
import socket
from dataclasses import replace
from pathlib import Path
from threading import Event

import pytest
from fastapi.routing import APIRoute, APIWebSocketRoute

from dashboard.recordings_rig import record
from dashboard.rig import rig
from mikas.cancellation import check_cancelled
from mikas.dashboard.api import catalog as catalog_routes
from mikas.dashboard.api import dependencies
from mikas.dashboard.app import _ROUTES, create_app
from mikas.dashboard.dashboard import Dashboard
from mikas.dashboard.library.lanes import Lane, LaneLimits
from mikas.dashboard.security.access import Access
from mikas.dashboard.settings import Settings

SMALL = {
    # GET: what is shown has a size of its own, whatever was recorded or sent
    "GET /api/about/qr.svg": "a picture of one address",
    "GET /api/state": "the present values",
    "GET /api/actions": "fifty rules at most",
    "GET /api/ports": "the adapters of this computer",
    "GET /api/virtual-cars": "the scenarios and defects of the program",
    "GET /api/virtual-cars/answer": "some words",
    "GET /api/tests/run": "one test",
    "GET /api/faults": "read from the line by who controls, or as last read",
    "GET /api/passport": "read from the line by who controls, or as last read",
    "GET /api/memory/{space}": "1 KiB of the line, by who controls",
    "GET /api/parameters/{name}": "one value of the line, by who controls",
    "GET /api/co": "four values of the line, by who controls",
    "GET /api/freeze-frames": "thirty frames without their rows",
    "GET /api/freeze-frames/{identity}": "the rows of one frame, some seconds",
    "GET /api/dumps/{id}": "one dump's map of 256 cells",
    # files as they are: read in pieces, as fast as the client takes them
    "GET /api/dumps/{id}/file": "a file",
    "GET /api/recordings/{identity}/file": "a file",
    "GET /api/survey/file": "a file",
    # the page
    "GET /": "a file of the page",
    "GET /{path:path}": "a file of the page",
    "GET /api/docs": "made once",
    "GET /api/docs/style.css": "a template",
    "GET /api/openapi.json": "the same for all",
    "WEBSOCKET /api/live": "a message is 4 KiB at most, thirty a second; what is sent is shared",
}
CHANGING = (dependencies._known, dependencies._local, dependencies._controller)  # noqa: SLF001


def labelled(routes, prefix=""):
    """Each route with its method and path; FastAPI keeps some in the routers that have them."""
    for route in routes:
        if (router := getattr(route, "original_router", None)) is not None:
            yield from labelled(router.routes, prefix + route.include_context.prefix)
            continue
        for method in getattr(route, "methods", None) or ["WEBSOCKET"]:
            if method != "HEAD":
                yield f"{method} {prefix}{route.path}", route


def every_route():
    nowhere = Path("nowhere")
    app = create_app(Dashboard(Settings(nowhere, state=nowhere)), Access(port=1))
    return labelled(app.routes)


def test_no_route_of_the_api_is_analysed_twice():
    """FastAPI does that, at the first request, with each route of a router that is included."""
    assert {type(route) for route in _ROUTES} == {APIRoute, APIWebSocketRoute}


def needs(dependant):
    """What the route depends on, and these in turn."""
    yield dependant.call
    for inner in dependant.dependencies:
        yield from needs(inner)


ROUTES = dict(every_route())
IN_LANES = [
    label
    for label, route in ROUTES.items()
    if isinstance(route, APIRoute) and dependencies.Requester in needs(route.dependant)
]


@pytest.mark.parametrize("label", ROUTES)
def test_every_route_computes_in_a_lane_or_is_known_to_compute_little(label):
    route = ROUTES[label]
    if label in IN_LANES:
        assert label not in SMALL
    elif label.startswith("GET ") or isinstance(route, APIWebSocketRoute):
        assert label in SMALL, "do its work by `Requester`, or name here why it is small"
    else:  # a change: by who may control, and never cancelled half-way
        assert set(CHANGING) & set(needs(route.dependant))


def test_no_route_is_listed_that_there_is_not():
    assert set(SMALL) <= set(ROUTES)


REQUESTS = {
    "GET /api/channels/{name}/value": ("/channels/FREQ/value", {"at": 1000}),
    "GET /api/history/find": ("/history/find", {"expression": "FREQ > 1"}),
    "GET /api/recordings/{identity}/find": ("/recordings/a.pcapng/find", {"expression": "FREQ"}),
    "GET /api/recordings/{identity}/tests/{name}": ("/recordings/a.pcapng/tests/any", {}),
    "GET /api/trip/{form}": ("/trip/gpx", {}),
    "GET /api/recordings/{identity}/trip/{form}": ("/recordings/a.pcapng/trip/gpx", {}),
    "GET /api/recordings/{identity}/export": ("/recordings/a.pcapng/export", {}),
}
BODIES = {
    "POST /api/plan/price": ("/plan/price", {"wanted": [{"name": "FREQ"}]}),
    "POST /api/channels/try": ("/channels/try", {"formula": "FREQ + 1"}),
}
BY_LABEL = [
    label
    for label in IN_LANES
    if label.startswith("GET ") or label in BODIES or label.endswith("/compare")
]


@pytest.fixture(scope="module")
def full(tmp_path_factory):
    """A dashboard in whose lanes every place is taken."""
    folder = tmp_path_factory.mktemp("full")
    (folder / "recordings").mkdir()
    record(folder / "recordings" / "a.pcapng", count=10)
    (folder / "state" / "dumps").mkdir(parents=True)
    with rig(folder, None) as it:
        library = it.dashboard.library
        for lane in (library.views, library.files, library.answers):
            lane.limits = replace(lane.limits, places=0)
        yield it


@pytest.mark.parametrize("label", BY_LABEL)
def test_a_route_in_a_lane_really_waits_there(full, label):
    if label.endswith("/compare"):
        pytest.skip("needs a dump: see test_dump_jobs_kept.py")
    if label in BODIES:
        path, body = BODIES[label]
        error = full.post(path, body, 409)
    else:
        path, query = REQUESTS.get(label, (label.removeprefix("GET /api"), {}))
        error = full.get(path.replace("{identity}", "a.pcapng"), 409, **query)
    assert error["code"] == "Busy"
    assert "too many requests" in error["en"]


LIMITS = LaneLimits(slots=2, deadline=3600, places=64, per_address=32)
VIEWER, OTHER = "192.168.0.7", "192.168.0.8"


def test_thirty_two_searches_of_a_viewer_leave_the_owner_the_next_turn():
    """Counted in turns: the owner's come at once, another viewer's after one of the first's."""

    async def scenario():
        lane, ended, turns = Lane(LIMITS), Event(), []

        def work(name):
            def run():
                turns.append(name)
                while name == "search" and not ended.wait(1e-3):
                    check_cancelled()

            return run

        async def ask(name, address):
            await lane.run(work(name), key=None, address=address)

        searches = [asyncio.create_task(ask("search", VIEWER)) for _ in range(32)]
        await asyncio.sleep(0)
        for _ in range(5):
            await ask("owner", None)
        assert turns.count("owner") == 5
        assert turns.count("search") == 1  # the network's only turn is still taken
        other = asyncio.create_task(ask("other", OTHER))
        await asyncio.sleep(0)
        ended.set()
        await other
        assert turns.count("search") <= 2
        await asyncio.gather(*searches)

    asyncio.run(scenario())


def test_a_viewers_work_on_a_file_does_not_make_the_owner_wait_for_that_file():
    async def scenario():
        lane, began, ended = Lane(LIMITS), Event(), Event()

        def look():
            began.set()
            while not ended.wait(1e-3):
                check_cancelled()

        viewer = asyncio.create_task(lane.run(look, key="a.pcapng", address=VIEWER))
        await asyncio.to_thread(began.wait, 60)
        assert await lane.run(lambda: 1, key="a.pcapng", address=None) == 1
        ended.set()
        await viewer

    asyncio.run(scenario())


def test_the_owner_comes_before_the_viewers_that_waited_longer():
    async def scenario():
        lane, turns = Lane(LIMITS), []
        first, held = Event(), Event()
        taken = [
            asyncio.create_task(
                lane.run(lambda: (first.set(), held.wait(60)), key=str(number), address=None)
            )
            for number in range(2)
        ]
        await asyncio.to_thread(first.wait, 60)
        waiting = [
            asyncio.create_task(
                lane.run(lambda name=name: turns.append(name), key=None, address=name)
            )
            for name in (VIEWER, VIEWER, OTHER, None)
        ]
        await asyncio.sleep(0)
        held.set()
        await asyncio.gather(*taken, *waiting)
        assert turns[0] is None
        assert turns[1:] == [VIEWER, OTHER, VIEWER]

    asyncio.run(scenario())


def test_a_search_that_costs_too_much_is_refused_before_it_is_computed(full, monkeypatch):
    library = full.dashboard.library
    monkeypatch.setattr(library.answers, "limits", LIMITS)
    monkeypatch.setattr(library.views, "limits", LIMITS)
    monkeypatch.setattr("mikas.dashboard.api.search.search_rows", None)
    monkeypatch.setattr("mikas.dashboard.api.search.search", None)
    monkeypatch.setattr("mikas.dashboard.api.search._MOST_RECORDED", 10_000)
    monkeypatch.setattr("mikas.dashboard.api.search._MOST_LIVE", 10_000)
    for at in range(10):
        full.dashboard.history.add(1000.0 + at, ("FREQ",), (1.0,))
    costly = " + ".join(["FREQ ** 1.5"] * 40) + " > 1"
    error = full.get("/history/find", 400, expression=costly)
    assert error["code"] == "UsageError"
    assert "12079 operations for each of 10 rows" in error["en"]
    assert "at most 1000 fit here" in error["en"]
    assert "shorter time" in error["en"]
    error = full.get("/recordings/a.pcapng/find", 400, expression=costly)
    assert "mikas find FILE EXPRESSION" in error["en"]
    assert "mikas find ФАЙЛ УСЛОВИЕ" in error["ru"]


def test_a_long_computation_ends_at_its_deadline(full, monkeypatch):
    library = full.dashboard.library
    monkeypatch.setattr(library.answers, "limits", replace(LIMITS, deadline=0))
    ended = Event()

    def endless(rows, points):
        try:
            while True:
                check_cancelled()
        finally:
            ended.set()

    monkeypatch.setattr(catalog_routes, "decimated", endless)

    error = full.get("/history", 504)
    assert error["code"] == "AnswerTookTooLong"
    assert "shorter" in error["en"]
    assert ended.wait(60)


def test_ctrl_c_does_not_wait_for_a_search(tmp_path, monkeypatch):
    began, ended = Event(), Event()

    def endless(rows, condition):
        began.set()
        try:
            while True:
                check_cancelled()
        finally:
            ended.set()

    monkeypatch.setattr("mikas.dashboard.api.search.search_rows", endless)
    with rig(tmp_path, None) as it:
        client = socket.create_connection(("127.0.0.1", it.port))
        head = (
            f"GET /api/history/find?expression=FREQ HTTP/1.1\r\nHost: 127.0.0.1:{it.port}\r\n\r\n"
        )
        client.sendall(head.encode())
        assert began.wait(60)
    assert ended.is_set()
    with client:
        assert "the dashboard is closing" in client.makefile("rb").read().decode()
