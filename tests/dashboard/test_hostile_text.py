"""Texts that no screen and no file can take, as input of every route that takes a text."""

from __future__ import annotations

import json
from urllib.parse import quote

import pytest

from dashboard.rig import ME, rig

# JSON may hold half of a surrogate pair; httpx would not send it.
HALF, CONTROLS = '"a\\ud800"', '"a\\u001b[2J\\u202e\\u0000b"'
ROUTES = [
    ("POST", "/recording/start", '{"name": %s}'),
    ("POST", "/recording/marker", '{"label": %s}'),
    ("POST", "/recording/note", '{"text": %s}'),
    ("PUT", "/recordings/x.pcapng/note", '{"text": %s}'),
    ("POST", "/connect", '{"port": %s}'),
    ("PUT", "/plan", '{"wanted": [{"name": %s}]}'),
    ("POST", "/changes", '{"kind": "write_parameter", "name": %s, "value": 1}'),
    ("POST", "/changes", '{"kind": "delete_recording", "id": %s}'),
    ("POST", "/changes", '{"kind": %s}'),
    ("POST", "/dumps", '{"space": "ram", "name": %s}'),
    ("POST", "/nowhere", '{%s: 1}'),
]  # fmt: skip


@pytest.fixture(scope="module")
def desk(tmp_path_factory):
    with rig(tmp_path_factory.mktemp("hostile"), None) as it:
        yield it


def is_shown(response):
    """Whether the response is JSON for a browser: 500 is a bug."""
    assert response.status_code != 500, response.text
    response.json()


def test_half_a_pair_or_controls_in_a_body_are_an_error_that_can_be_shown(desk):
    headers = ME | {"Content-Type": "application/json"}
    for method, path, body in ROUTES:
        for bad in (HALF, CONTROLS):
            is_shown(
                desk.client.request(method, f"/api{path}", content=body % bad, headers=headers)
            )


def test_controls_in_a_path_or_a_query_are_an_error_that_can_be_shown(desk):
    for bad in ("%ED%A0%80", "%1B%5B2J", "%FF", "%E2%80%AE", "%00"):
        for path in ("/recordings/{}", "/recordings/{}/report", "/dumps/{}", "/{}"):
            is_shown(desk.client.get(f"/api{path.format(bad)}", headers=ME))
        is_shown(desk.client.get(f"/api/history?names={bad}&seconds=1", headers=ME))


def test_a_marker_is_cleaned_for_every_page(desk):
    desk.post("/recording/marker", {"label": "a\x1b[2J\u202e\nb"})
    events = desk.get("/history", seconds=3600)["events"]
    assert events[-1]["label"] == "a\ufffd[2J\ufffd b"


def test_the_name_of_a_client_is_cleaned(desk):
    name = {"X-Mikas-Name": quote("a\x1b]0;x\x07\u202e") + "%ED%A0%80"}
    state = desk.client.post("/api/control/take", json={}, headers=ME | name).json()
    assert "\x1b" not in json.dumps(state, ensure_ascii=False)
    assert "a\ufffd]0;x\ufffd\ufffd" in json.dumps(state, ensure_ascii=False)
    desk.post("/control/release")
