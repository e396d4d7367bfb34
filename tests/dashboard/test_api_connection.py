"""Connecting, the plan and its price, control; the state of the line."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest

from dashboard.rig import ADAPTER, ME, OTHER, rig
from mikas.client.doctor import Step
from mikas.client.other_units import NAMES
from mikas.errors import LinkLost
from mikas.i18n import Text


def test_nothing_is_connected_until_somebody_says_so(off):
    state = off.get("/state")
    assert (state["line"], state["port"], state["controller"]) == ("off", None, None)
    assert state["reason_code"] is None
    assert off.get("/ports")["ports"][0]["url"] == ADAPTER.url
    assert off.get("/faults", 503)["code"] == "NotConnected"


def test_a_click_connects_to_the_one_likely_adapter(off):
    state = off.post("/connect", {"port": None})
    assert state["port"] == ADAPTER.url
    state = off.sampling()
    assert (state["line"], state["model"]["en"]) == ("sampling", "Mikas 7.1")
    assert state["demo"] is False
    state = off.post("/disconnect")
    assert (state["line"], state["port"]) == ("off", None)


def test_no_adapter_and_two_adapters_have_different_messages(off):
    off.cars.ports.clear()
    error = off.post("/connect", {}, 503)
    assert error["code"] == "NoPortGiven"
    assert "none" in error["en"]
    assert "ни одного" in error["ru"]


@pytest.mark.parametrize("url", ["nonsense://x", "", "sim:?wrong=1", "sim:?scenario=nowhere"])
def test_an_address_that_makes_no_sense_is_refused(off, url, monkeypatch):
    from mikas.link import open_link

    monkeypatch.setattr(off.cars, "open", open_link)
    object.__setattr__(off.dashboard.settings, "open_port", open_link)
    error = off.post("/connect", {"port": url}, 400)
    assert error["code"] in ("BadPortUrl", "UsageError")
    assert error["ru"] != error["en"]


def test_an_adapter_pulled_out_is_waited_for_and_found_again(idle):
    with idle.live() as live:
        live.until(lambda it: "data" in it)
        idle.cars.pull()
        lost = live.until(lambda it: it["state"]["line"] == "no-port")
        assert lost["state"]["reason"]["ru"]
        assert lost["state"]["rate"] == 0
        idle.cars.put_back()
        kinds = []
        live.until(
            lambda it: (
                kinds.extend(it.get("events", ()))
                or any(e["kind"] == "gap" and e["ended"] for e in kinds)
            )
        )
        live.until(lambda it: it["state"]["line"] == "sampling")


def test_an_adapter_that_comes_back_under_another_name_is_followed(off):
    def cable(name, number):
        return replace(ADAPTER, url=name, vid=0x0403, pid=0x6001, serial_number=number)

    cars, first, second = off.cars, "/dev/ttyUSB0", "/dev/ttyUSB1"
    cars.ports[:] = [cable(first, "A1")]
    off.post("/connect", {"port": None})
    off.sampling()
    cars.pull()
    cars.ports[:] = [cable(first, "B2")]
    state = off.until(lambda it: it["state"]["reason_code"] == "AnotherAdapter")["state"]
    assert "another adapter has its port /dev/ttyUSB0" in state["reason"]["en"]
    cars.ports.append(cable(second, "A1"))
    cars.put_back()
    assert off.sampling()["port"] == second
    events = off.get("/history")["events"]
    (moved,) = [event for event in events if event["kind"] == "adapter"]
    assert (moved["port"], moved["before"]) == (second, first)
    assert [link.url for link in cars.links] == [first, second]
    assert off.dashboard.connection.port.url == second  # the check of the connection opens this


def test_an_adapter_exchanged_during_the_check_is_not_sampled(off):
    def cable(number):
        return replace(ADAPTER, vid=0x0403, pid=0x6001, serial_number=number)

    def exchanged(url):
        link = off.cars.open(url)
        off.cars.ports[:] = [cable("B2")]
        return link

    off.cars.ports[:] = [cable("A1")]
    off.post("/connect", {"port": None})
    off.sampling()
    object.__setattr__(off.dashboard.settings, "open_port", exchanged)
    off.client.post("/api/doctor", json={}, headers=ME)
    off.until(lambda it: it["state"]["reason_code"] == "AnotherAdapter")
    assert len(off.cars.links) == 2


KEY_OFF = """
duration = 60
after_end = "hold"
[text]
en = "The key stays off"
ru = "Зажигание выключено"
[timeline]
key = 0
"""


@pytest.mark.parametrize(
    ("setting", "line"),
    [("supplied=0", "no-echo"), ("scenario={key_off}", "echo-only")],
    ids=["no-supply", "key-off"],
)
def test_no_supply_and_ignition_off_are_distinguished(tmp_path, setting, line):
    key_off = tmp_path / "key-off.toml"
    key_off.write_text(KEY_OFF, "utf-8")
    with rig(tmp_path, f"sim:?{setting.format(key_off=key_off)}") as it:
        state = it.until(lambda message: message["state"]["line"] == line)["state"]
        assert state["reason"]["en"]
        error = it.get("/faults", 503)
        assert error["code"] == "NotConnected"
        assert state["reason"]["en"] in error["en"]


def test_an_elm327_ends_the_attempt_with_what_to_buy(tmp_path):
    with rig(tmp_path, "sim:?adapter=elm327") as it:
        state = it.until(lambda message: message["state"]["reason"])["state"]
        assert (state["line"], state["reason_code"]) == ("off", "NotAKLineAdapter")
        assert "ELM327" in state["reason"]["en"]


def test_the_plan_changes_while_it_runs(idle):
    state = idle.put(
        "/plan", {"wanted": [{"name": "TWAT"}, {"name": "fuel_used", "every": 5}], "method": "list"}
    )
    assert [(it["name"], it["every"]) for it in state["plan"]["wanted"]] == [
        ("TWAT", 1),
        ("FUEL_USED", 5),
    ]
    message = idle.until(lambda it: "FUEL_USED" in it.get("data", {}).get("names", ()))
    assert message["data"]["names"] == ["TWAT", "FUEL_USED"]
    idle.until(lambda it: it["state"]["method"] == "list")


def test_a_plan_of_what_does_not_exist_changes_nothing(shared_idle):
    error = shared_idle.put("/plan", {"wanted": [{"name": "TWATT"}]}, 400)
    assert error["code"] == "UnknownParameter"
    assert "TWAT" in error["en"]
    assert "TWAT" in [one["name"] for one in shared_idle.get("/state")["plan"]["wanted"]]


def test_a_plan_made_while_nothing_is_connected_is_kept(off):
    off.put("/plan", {"wanted": [{"name": "UOZ"}], "method": "batch", "rate": 5})
    off.post("/connect", {"port": "sim:", "method": "batch", "rate": 5})
    assert off.until(lambda it: "data" in it)["data"]["names"] == ["UOZ"]


def test_the_cost_of_a_channel_is_known_before_it_is_added(shared_idle):
    price = shared_idle.post("/plan/price", {"wanted": [{"name": "FREQ"}], "method": "batch"})
    assert price["rate"] == pytest.approx(1 / price["seconds"])
    assert price["more"]["TWAT"]["rate"] < price["rate"]
    assert price["more"]["TWAT"]["seconds"] > 0
    assert "FREQ" not in price["more"]
    assert price["more"]["INJ"]["seconds"] > price["more"]["TWAT"]["seconds"]  # two bytes


def test_where_each_channel_costs_time_some_come_first(off):
    """An adapter without a rate limit: by 61 the others are read in every fifth cycle."""
    everything = [{"name": it["name"]} for it in off.get("/state")["plan"]["wanted"]]
    off.put("/plan", {"wanted": everything, "method": "batch"})
    off.put("/plan/first", {"names": ["FREQ", "fuel_flow"]})
    assert off.put("/plan/first", {"names": ["TWTA"]}, 400)["code"] == "UnknownParameter"
    off.post("/connect", {"port": "sim:?scenario=warm-idle", "method": "batch"})
    state = off.until(lambda it: it["state"]["samples"] > 20)["state"]
    assert state["plan"]["first"] == ["FREQ", "FUEL_FLOW"]
    cycles = {it["name"]: it["cycles"] for it in state["plan"]["wanted"]}
    assert {it["every"] for it in state["plan"]["wanted"]} == {1}
    assert (cycles["FREQ"], cycles["INJ"], cycles["FUEL_FLOW"]) == (1, 1, 1)
    assert cycles["TWAT"] == 5
    prices = {
        method: off.post("/plan/price", {"wanted": everything, "method": method, "first": ["FREQ"]})
        for method in ("batch", "stream")
    }
    assert "FREQ" not in prices["batch"]["more"]
    assert prices["batch"]["more"]["TWAT"]["seconds"] > 0.0005
    assert prices["stream"]["more"]["TWAT"]["seconds"] == 0


def test_the_doctor_borrows_the_port_and_gives_it_back(idle):
    answer = idle.client.post("/api/doctor", json={}, headers=ME)
    assert answer.headers["content-type"].startswith("application/x-ndjson")
    steps = [json.loads(line) for line in answer.text.splitlines()]
    assert [step["name"] for step in steps] == [
        "port", "echo", "baud", "latency", "line", "ecu", "commands",
    ]  # fmt: skip
    assert all(step["title"]["ru"] and step["detail"]["ru"] for step in steps)
    assert idle.sampling()["line"] == "sampling"


def test_what_the_doctor_answers_is_described(shared_off):
    described = shared_off.get("/openapi.json")
    answer = described["paths"]["/api/doctor"]["post"]["responses"]["200"]["content"]
    assert list(answer) == ["application/x-ndjson"]
    name = answer["application/x-ndjson"]["schema"]["$ref"].removeprefix("#/components/schemas/")
    schema = described["components"]["schemas"][name]
    shape = set(schema["properties"])
    assert (
        schema["properties"]["title"]["$ref"].removeprefix("#/components/schemas/")
        in (described["components"]["schemas"])
    )
    lines = shared_off.client.post("/api/doctor", json={"port": "sim:?supplied=0"}, headers=ME).text
    steps = [json.loads(line) for line in lines.splitlines()]
    assert all(set(step) == shape for step in steps)
    assert steps[0]["to_try"] is None  # it went well: nothing to try, rather than empty words


def test_the_doctor_without_a_connection_leaves_none(off):
    steps = off.client.post("/api/doctor", json={"port": "sim:?supplied=0"}, headers=ME).text
    last = json.loads(steps.splitlines()[-1])
    assert (last["name"], last["ok"]) == ("echo", False)
    assert "12 V" in last["to_try"]["en"]
    assert "12 V" not in last["detail"]["en"]
    assert "doctor" not in last["to_try"]["ru"]
    assert off.get("/state")["line"] == "off"


def test_the_doctor_names_another_kind_of_unit_on_request(off):
    port = "sim:?baud=19200&adapter_baud=9600"
    for asked in (False, True):
        body = {"port": port, "other_units": asked}
        lines = off.client.post("/api/doctor", json=body, headers=ME).text.splitlines()
        steps = {step["name"]: step for step in map(json.loads, lines)}
        assert steps["ecu"]["code"] == "EchoOnly"
        assert (NAMES[0] in steps) is asked
    assert tuple(steps)[-4:] == NAMES
    assert steps["other-baud"]["ok"] is True
    assert "19200" in steps["other-baud"]["detail"]["ru"]
    assert steps["kwp2000-slow"]["ok"] is None
    assert steps["kwp2000-slow"]["title"]["ru"] == "KWP2000, медленное пробуждение"


@pytest.fixture
def patient(monkeypatch):
    """A doctor that never comes to an end by itself."""

    def examine(open_port, create_ecu, *, others):
        with open_port() as link:
            yield Step("port", True, Text("open", "открыт"))
            try:
                while True:
                    link.read(link.now() + 3600)
            except LinkLost as error:
                yield Step("ecu", False, error.text)

    monkeypatch.setattr("mikas.dashboard.session.port_threads.examine", examine)


def test_a_doctor_that_is_stopped_lets_go_of_the_port_at_once(patient, idle):
    with idle.client.stream("POST", "/api/doctor", json={}, headers=ME) as answer:
        lines = answer.iter_lines()
        assert json.loads(next(lines))["name"] == "port"
        examined = idle.cars.links[-1]
        assert idle.post("/doctor", status=409)["code"] == "Busy"
        assert idle.post("/doctor/stop", status=409, headers=OTHER)["code"] == "NotController"
        idle.post("/doctor/stop")
        with pytest.raises(LinkLost):
            examined.write(b"")
        assert list(lines) == []  # the error of a port that we closed ourselves is not reported
    idle.post("/connect", {"port": "sim:?scenario=warm-idle"})  # the port is free
    assert idle.sampling()["line"] == "sampling"
    idle.post("/doctor/stop")  # there is none: nothing to do


def test_a_doctor_without_a_listener_ends(patient, idle):
    with idle.client.stream("POST", "/api/doctor", json={}, headers=ME) as answer:
        next(answer.iter_lines())
    assert idle.sampling()["line"] == "sampling"
    assert idle.dashboard.diagnosis is None


def test_one_has_control_the_others_watch(idle):
    mine = idle.post("/relearn")["controller"]
    assert mine == {"id": mine["id"], "name": "Me", "you": True}
    error = idle.post("/disconnect", status=409, headers=OTHER)
    assert error["code"] == "NotController"
    assert "Me" in error["en"]
    controller = idle.get("/state", headers=OTHER)["controller"]
    assert controller == {"id": mine["id"], "name": "Me", "you": False}
    idle.post("/control/take", {}, 409, headers=OTHER)
    taken = idle.post("/control/take", {"force": True}, headers=OTHER)
    theirs = taken["controller"]
    assert theirs == {"id": theirs["id"], "name": "Вася", "you": True}
    assert theirs["id"] != mine["id"]
    idle.post("/relearn", status=409)
    assert idle.post("/control/release", headers=OTHER)["controller"] is None
    idle.post("/relearn")


def test_who_does_not_say_who_it_is_controls_nothing(shared_idle):
    assert shared_idle.post("/relearn", status=400, headers={})["code"] == "BadRequest"
    assert shared_idle.post("/relearn", status=400, headers={"X-Mikas-Client": "x y"})["code"]
