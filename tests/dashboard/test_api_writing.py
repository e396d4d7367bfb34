"""Writing a parameter: what can be written, its start value, and what each error says to do."""

from __future__ import annotations

import json
import sys

import pytest

from dashboard.rig import OTHER, rig
from mikas.client.identity import Passport
from mikas.dashboard.session.start_values import SESSION, StartValues
from mikas.sampling.events import UnitFound

IDLE = "sim:?scenario=warm-idle"
STEP = 1 / 256  # of RCOD, which the running engine leaves alone


def look(it, name="RCOD", status=200, **more):
    return it.get(f"/parameters/{name}", status, **more)


def propose(it, status=200, **wish):
    return it.post("/changes", {"kind": "write_parameter", **wish}, status)


def write(it, status=200, **wish):
    return it.post(f"/changes/{propose(it, **wish)['nonce']}", status=status)


@pytest.fixture
def open_idle(idle):
    idle.post("/unlock", {"minutes": 30})
    return idle


@pytest.fixture
def stubborn(tmp_path):
    """A unit with its car: what it does with a write is the test's."""
    with rig(tmp_path, IDLE) as it:
        it.sampling()
        it.post("/unlock", {"minutes": 30})
        yield it, it.cars.car(IDLE)


def test_a_parameter_has_its_value_and_the_bounds_of_its_bytes(idle):
    shown = look(idle, "SSM")
    assert (shown["lowest"], shown["highest"], shown["step"]) == (0, 255, 1)
    assert (shown["start"], shown["start_time"]) == (None, None)
    assert shown["now"]["raw"]
    fine = look(idle, "UGB")
    assert (fine["lowest"], fine["highest"], fine["step"]) == (0, 655.35, 0.01)
    flag = look(idle, "DET")
    assert (flag["lowest"], flag["highest"], flag["step"]) == (None, None, None)
    assert look(idle, "NOPE", 400)["code"] == "UnknownParameter"
    assert look(idle, "0x41")["now"]["raw"] == look(idle, "RCOD")["now"]["raw"]


def test_the_value_before_the_first_write_is_the_start_value_and_stays_it(open_idle):
    before = look(open_idle, "RCOD")
    for value in (before["now"]["value"] + 3 * STEP, before["now"]["value"] + 7 * STEP):
        assert write(open_idle, name="RCOD", value=value)["after"]["value"] == value
    shown = look(open_idle, "RCOD")
    assert shown["now"]["value"] == before["now"]["value"] + 7 * STEP
    assert shown["start"] == before["now"]
    assert before["time"] <= shown["start_time"] <= shown["time"]
    back = write(open_idle, name="RCOD", raw=shown["start"]["raw"])
    assert back["after"] == before["now"]
    entries = open_idle.get("/journal")["entries"]
    written = [it for it in entries if it["change"]["en"] == "write parameter RCOD"]
    assert [it["state"] for it in written] == ["done", "started"] * 3


def test_what_is_only_shown_has_no_start_value(open_idle):
    propose(open_idle, name="RCOD", value=-0.25)
    assert look(open_idle, "RCOD")["start"] is None


def test_a_proposal_says_the_values_as_each_language_writes_them(open_idle):
    meaning = propose(open_idle, name="RCOD", value=-0.25)["meaning"]
    assert "factor: −0.469 → −0.250. " in meaning["en"]
    assert "ходу: −0,469 → −0,250. " in meaning["ru"]
    advance = propose(open_idle, name="UOZ", value=12)["meaning"]["en"]
    assert "→ 12.0\N{NO-BREAK SPACE}°" in advance


def test_a_proposal_says_which_limit_of_the_catalog_it_is_beyond(open_idle):
    within = propose(open_idle, name="UOZ", value=12)
    assert within["danger"] is False
    beyond = propose(open_idle, name="UACC", value=18.5)
    outside = propose(open_idle, name="TWAT", value=150)
    assert beyond["danger"] is outside["danger"] is True
    assert "beyond the limit 18" in beyond["meaning"]["en"]
    assert "за пределом 18" in beyond["meaning"]["ru"]
    assert "outside -40 … 130" in outside["meaning"]["en"]


def test_a_value_that_the_engine_has_moved_since_it_was_shown_is_replaced(stubborn):
    it, car = stubborn
    raw, keep, written = car.raw, car.write, []
    asked = propose(it, name="RCOD", value=-0.25)

    def moved(code, now):
        return b"\x11" if code == 0x41 and not written else raw(code, now)

    car.raw = moved
    car.write = lambda code, data: keep(code, data) and not written.append(data)
    done = it.post(f"/changes/{asked['nonce']}")
    assert asked["before"]["raw"] != "11"
    assert done["after"] == asked["after"]
    assert it.get("/journal")["entries"][0]["before"] == "11"


def test_a_refusal_says_that_nothing_changed_and_what_to_try(stubborn):
    it, car = stubborn
    before = look(it, "RCOD")["now"]
    car.write = lambda code, data: False
    error = write(it, 502, name="RCOD", value=before["value"] + STEP)
    assert (error["code"], error["received"]) == ("WriteRefused", "01FF0D")
    assert "engine off" in error["en"]
    assert "заглушенном" in error["ru"]
    assert look(it, "RCOD")["now"] == before


@pytest.mark.parametrize("unknown", ["silent", "01"])
def test_a_unit_without_the_command_says_so(tmp_path, unknown):
    with rig(tmp_path, f"{IDLE}&missing=write&unknown={unknown}") as it:
        it.sampling()
        it.post("/unlock", {})
        before = look(it, "RCOD")["now"]
        error = write(it, 502, name="RCOD", value=before["value"] + STEP)
        if unknown == "01":
            assert error["code"] == "WriteRefused"
        else:
            assert error["code"] in ("NotSupported", "NoResponse")
            assert "(62)" in error["en"]
            assert "(62)" in error["ru"]
        assert look(it, "RCOD")["now"] == before
        failed = it.get("/journal")["entries"][0]
        assert failed["state"] == "failed"


def test_another_value_read_back_says_to_look_and_go_back(stubborn):
    it, car = stubborn
    before = look(it, "RCOD")["now"]
    car.write = lambda code, data: True
    error = write(it, 502, name="RCOD", value=before["value"] + STEP)
    assert error["code"] == "ReadBackDiffers"
    assert "start value" in error["en"]
    assert "начальное значение" in error["ru"]
    assert look(it, "RCOD")["start"] == before


def test_another_tab_has_the_lock(open_idle):
    asked = propose(open_idle, name="RCOD", value=-0.25)
    error = open_idle.post(f"/changes/{asked['nonce']}", status=409, headers=OTHER)
    assert error["code"] == "NotController"
    assert "take control over" in error["en"]
    open_idle.post("/control/take", {"force": True}, headers=OTHER)
    assert propose(open_idle, 409, name="RCOD", value=-0.25)["code"] == "NotController"
    open_idle.post("/control/take", {"force": True})
    locked = propose(open_idle, 403, name="RCOD", value=-0.25)  # the lock closed with the change
    assert locked["code"] == "Locked"
    assert "Unlock writing first" in locked["en"]


def test_a_connection_that_is_lost_between_is_no_write(open_idle):
    it = open_idle
    before = look(it, "RCOD")["now"]
    asked = propose(it, name="RCOD", value=before["value"] + STEP)
    it.cars.pull()
    it.until(lambda message: message["state"]["line"] == "no-port")
    error = it.post(f"/changes/{asked['nonce']}", status=503)
    assert error["code"] == "NotConnected"
    assert look(it, "RCOD", 503)["code"] == "NotConnected"
    it.cars.put_back()
    it.sampling()
    assert look(it, "RCOD")["now"] == before
    assert it.get("/journal")["entries"] == []


def test_the_start_value_outlives_the_adapter_and_the_program(tmp_path):
    with rig(tmp_path, IDLE) as it:
        it.sampling()
        it.post("/unlock", {})
        before = look(it, "RCOD")["now"]
        write(it, name="RCOD", value=before["value"] + 5 * STEP)
        it.cars.pull()
        it.until(lambda message: message["state"]["line"] == "no-port")
        it.cars.put_back()
        it.sampling()
        assert look(it, "RCOD")["start"] == before
        it.post("/connect", {"port": f"{IDLE}&model=5.4"})
        it.sampling()
        assert look(it, "RCOD")["start"] is None  # another unit's
    with rig(tmp_path, IDLE) as it:
        it.sampling()
        assert look(it, "RCOD")["start"] == before


def unit(program="one", *, another=False):
    return UnitFound(0.0, 0x0A, Passport((program, None, None), (None,) * 5), another)


def test_a_session_ends_some_hours_after_the_last_write(tmp_path):
    values = StartValues(tmp_path / "start.json")
    values.begin_unit(unit())
    values.note("SSM", b"\x01", 1000.0)
    values.note("SSM", b"\x02", 1000.0 + SESSION - 1)
    assert values.value("SSM", 1000.0 + SESSION + 5).raw == b"\x01"
    later = 1000.0 + 2 * SESSION
    assert values.value("SSM", later) is None
    values.note("SSM", b"\x02", later)
    assert values.value("SSM", later).raw == b"\x02"


def test_start_values_are_each_units_own_and_those_of_a_nameless_one_are_not_kept(tmp_path):
    file = tmp_path / "start.json"
    values = StartValues(file)
    values.begin_unit(unit("one"))
    values.note("SSM", b"\x01", 1.0)
    values.begin_unit(unit("two", another=True))
    assert values.value("SSM", 2.0) is None
    values.note("SSM", b"\x07", 2.0)
    values.begin_unit(unit("", another=True))
    values.note("SSM", b"\x09", 3.0)
    assert values.value("SSM", 3.0).raw == b"\x09"
    again = StartValues(file)
    for program, raw in (("one", b"\x01"), ("two", b"\x07")):
        again.begin_unit(unit(program, another=True))
        assert again.value("SSM", 4.0).raw == raw
    again.begin_unit(unit("", another=True))
    assert again.value("SSM", 4.0) is None


@pytest.mark.parametrize(
    "content",
    ["", "[]", "{}", '{"units": 5}', '{"units": {"a": 1}}', '{"units": {"a": {"SSM": {}}}}',
     '{"units": {"a": {"SSM": {"raw": "zz", "read": 1, "written": 1}}}}',
     '{"units": {"a": {"SSM": {"raw": "00", "read": "x", "written": 1}}}}'],
)  # fmt: skip
def test_a_file_of_start_values_that_makes_no_sense_is_put_aside(tmp_path, content):
    file = tmp_path / "start.json"
    file.write_text(content)
    values = StartValues(file)
    values.begin_unit(unit())
    values.note("SSM", b"\x01", 1.0)
    assert "units" in json.loads(file.read_text())
    assert [it.name for it in tmp_path.glob("*.broken*")] == ["start.json.broken"]


@pytest.mark.skipif(sys.platform == "emscripten", reason="a site's folder takes every file")
def test_a_file_in_the_way_costs_only_the_way_back_after_the_program(tmp_path):
    blocked = tmp_path / "state"
    blocked.write_text("")
    values = StartValues(blocked / "start.json")
    values.begin_unit(unit())
    values.note("SSM", b"\x01", 1.0)
    assert values.value("SSM", 1.0).raw == b"\x01"
