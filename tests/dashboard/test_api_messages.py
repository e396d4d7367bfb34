"""Models of live messages and events are valid for the messages that are sent."""

from __future__ import annotations

import json

from pydantic import TypeAdapter

from mikas.dashboard.api.catalog import HistoryResponse
from mikas.dashboard.api.changes import JournalResponse
from mikas.dashboard.api.messages import FieldsMessage, LiveMessage, PingMessage
from mikas.dashboard.app import openapi_description

SENT = TypeAdapter(LiveMessage)


def strictly(socket, accepted):
    """Every message until one is accepted, each validated; the kinds of their events."""
    kinds = set()
    for _ in range(2000):
        message = json.loads(socket.recv(60))
        shown = SENT.validate_python(message, strict=False)
        assert shown.model_dump(mode="json", exclude_unset=True) == message
        kinds |= {event["kind"] for event in message.get("events", [])}
        if accepted(message, kinds):
            return kinds
    raise AssertionError(kinds)


def test_real_messages_fit_the_models(idle):
    with idle.live() as live:
        strictly(live.socket, lambda message, _: "data" in message)
        live.send(PingMessage(ping=7).model_dump())
        strictly(live.socket, lambda message, _: message.get("pong") == 7)
        live.send(FieldsMessage(fields=["FREQ"]).model_dump())
        idle.post("/recording/start", {"name": "x"})
        idle.post("/recording/marker", {"label": "knock"})
        idle.post("/recording/stop")
        idle.cars.pull()
        strictly(live.socket, lambda _, kinds: {"marker", "recording", "gap", "state"} <= kinds)
        idle.cars.put_back()
        strictly(live.socket, lambda _, kinds: {"unit", "state"} <= kinds)


def test_the_past_fits_its_model(idle):
    idle.post("/recording/marker", {"label": "knock"})
    history = idle.get("/history")
    assert HistoryResponse(**history).model_dump(mode="json", exclude_unset=True) == history


def test_the_journal_fits_its_model(idle):
    nonce = idle.post("/changes", {"kind": "erase_faults"})["nonce"]
    idle.post(f"/changes/{nonce}")
    entries = JournalResponse(**idle.get("/journal")).entries
    assert [entry.state for entry in entries] == ["done", "started"]


def test_the_description_is_the_same_each_time_and_has_the_socket():
    described = openapi_description()
    assert json.dumps(described) == json.dumps(openapi_description())
    schemas = described["components"]["schemas"]
    assert {"LiveMessage", "PingMessage", "FieldsMessage", "GapEvent", "DiagnosisStep"} <= set(
        schemas
    )
    assert schemas["LiveMessage"]["required"] == ["seq", "now", "dropped"]
    assert schemas["Level"]["enum"] == ["none", "warning", "danger"]
    for each in json.dumps(described).split('"#/components/schemas/')[1:]:
        assert each.partition('"')[0] in schemas


def test_every_route_that_answers_json_has_a_model():
    for path, methods in openapi_description()["paths"].items():
        for method, route in methods.items():
            content = route["responses"]["200"].get("content", {})
            schema = content.get("application/json", {"schema": {"$ref": ""}})["schema"]
            assert "$ref" in schema, (method, path)
