"""The table has every route of the API: a new one is driven on the desktop and on the site."""

from __future__ import annotations

import json

from mikas.dashboard.app import create_app
from mikas.dashboard.dashboard import Dashboard
from mikas.dashboard.security.access import Access
from mikas.dashboard.settings import Settings

from .driving import drive
from .routes import ROUTES, change, get, post, samples


def test_no_route_of_the_api_is_missing_and_none_is_too_many(tmp_path):
    settings = Settings(tmp_path / "recordings", state=tmp_path / "state", tests=tmp_path / "tests")
    paths = create_app(Dashboard(settings), Access(8000)).openapi()["paths"]
    there = {(way.upper(), path) for path, ways in paths.items() for way in ways}
    assert {(row.method, f"/api{row.route}") for row in ROUTES} == there


def asked(*answers):
    """What is asked, in order; `answers`: status and JSON of each."""
    waiting, seen = list(answers), []

    def ask(method, address, body):
        seen.append((method, address, body))
        status, answer = waiting.pop(0)
        return status, json.dumps(answer).encode()

    return ask, seen


def test_later_rows_have_what_earlier_answers_said():
    ask, seen = asked((200, {"nonce": "a/b"}), (200, {}))
    assert drive(ask, change({"kind": "erase_faults"}), "site") == []
    assert seen[1] == ("POST", "api/changes/a%2Fb", None)


def test_an_answer_is_waited_for():
    ready = {"line": "sampling", "samples": 9, "version_code": 1}
    ask, seen = asked((200, ready | {"samples": 0}), (200, ready))
    assert drive(ask, [get("/state", until=samples)], "desktop") == []
    assert len(seen) == 2


def test_what_is_answered_otherwise_is_named_with_what_follows_from_it():
    ask, _ = asked((500, {"error": "platformdirs"}), (200, {}))
    rows = (get("/about", takes={"id": lambda it: it["id"]}), post("/x", address="/x/{id}"))
    first, second = drive(ask, rows, "site")
    assert "500" in first
    assert "platformdirs" in first
    assert second.startswith("POST /x/{id}: what it needs is not there")


def test_a_home_is_asked_only_for_what_it_has():
    rows = (get("/about", homes=("desktop",)), get("/x", status=409))
    ask, seen = asked((409, {}))
    assert drive(ask, rows, "site") == []
    assert [address for _, address, _ in seen] == ["api/x"]
