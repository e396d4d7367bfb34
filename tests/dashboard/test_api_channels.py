"""The user's own catalog through the API: a change is in use at once, on the same connection."""

from __future__ import annotations

import pytest

import mikas
from dashboard.rig import NAMES, OTHER, rig
from mikas.catalog.own.file import OwnCatalog
from mikas.recording import CaptureReader

DOUBLE = {
    "formula": "FREQ * factor",
    "constants": {"factor": 2},
    "text": {"en": "Double", "ru": "Вдвое"},
    "unit": "rpm",
    "decimals": 0,
    "new": True,
}
NONE = dict.fromkeys(("danger_low", "warning_low", "warning_high", "danger_high"))


def channel(it, name):
    known = it.get("/catalog")
    return next(each for each in known["parameters"] + known["derived"] if each["name"] == name)


def values_of(message, name):
    data = message.get("data", {"names": []})
    if name not in data["names"]:
        return []
    return [each for each in data["values"][data["names"].index(name)] if each is not None]


def state_version(it):
    return it.get("/state")["catalog"]


@pytest.fixture
def warm(tmp_path):
    with rig(tmp_path, "sim:?scenario=warm-idle") as it:
        it.sampling()
        yield it


def test_an_own_channel_is_sampled_recorded_and_exported_at_once(warm, tmp_path):
    warm.post("/recording/start", {"name": "drive"})
    before, links = warm.get("/state"), len(warm.cars.links)
    with warm.live() as live:
        made = warm.put("/channels/DOUBLE", {**DOUBLE, "version": before["catalog"]})
        assert made["version"] != before["catalog"]
        live.until(lambda it: values_of(it, "DOUBLE"))
        live.until(lambda it: it["state"]["catalog"] == made["version"])
    rows = warm.get("/history", seconds=900, names="FREQ,DOUBLE")
    pairs = list(zip(*rows["values"], strict=True))
    # Computed for the time before it was made as well.
    assert len(pairs) > 3
    # A row between the change and the sampler's next cycle has a dash.
    assert all(each is None or each == 2 * freq for freq, each in pairs)
    assert sum(each is None for _, each in pairs) < 5
    state = warm.get("/state")
    assert state["since"] == before["since"]
    assert len(warm.cars.links) == links  # and no gap, but for those of a busy computer
    assert "DOUBLE" in [each["name"] for each in state["plan"]["wanted"]]

    # Another formula: no value of the first one is left.
    again = {**DOUBLE, "new": False, "constants": {"factor": 3}}
    warm.put("/channels/double", again)
    warm.until(lambda it: values_of(it, "DOUBLE"))
    rows = warm.get("/history", seconds=900, names="FREQ,DOUBLE")
    pairs = list(zip(*rows["values"], strict=True))
    assert all(each is None or each == 3 * freq for freq, each in pairs)
    assert sum(each is None for _, each in pairs) < 5
    warm.post("/recording/stop")
    (file,) = warm.get("/recordings")["recordings"]
    shown = warm.get(f"/recordings/{file['id']}/rows", names="FREQ,DOUBLE", points=20000)
    triple = [(freq, each) for freq, each in zip(*shown["values"], strict=True) if freq]
    assert triple
    assert all(each == 3 * freq for freq, each in triple)
    text = warm.get(f"/recordings/{file['id']}/export", format="csv").text
    assert "DOUBLE" in text.splitlines()[0]
    own = tmp_path / "state" / "catalog.toml"
    recording = mikas.open(tmp_path / "recordings" / file["id"], catalogs=[own])
    assert recording.channels[-1].name == "DOUBLE" or "DOUBLE" in recording.to_arrow().column_names
    # What the recording says of the catalogs that decoded it, one after the other.
    notes = CaptureReader(recording.path).notes()
    noted = [note.data["version"] for note in notes if note.kind == "catalog"]
    assert noted == [before["catalog"], made["version"], state_version(warm)]
    assert recording.about["recorded with catalog"] == ", ".join(noted)

    warm.client.delete("/api/channels/DOUBLE", headers={"X-Mikas-Client": "tester-0001"})
    assert "DOUBLE" not in [each["name"] for each in warm.get("/state")["plan"]["wanted"]]
    warm.until(lambda it: values_of(it, "FREQ") and "DOUBLE" not in it["data"]["names"])


def test_limits_alarm_at_once_and_end_with_their_limits(warm):
    limits = {**NONE, "warning_high": 10, "hysteresis": 2}
    with warm.live() as live:
        warm.put("/channels/TWAT/keys", {"limits": limits, "gauge": [0, 150]})
        live.until(lambda it: [a["name"] for a in it["state"]["alarms"]] == ["TWAT"])
        twat = channel(warm, "TWAT")
        assert (twat["limits"], twat["gauge"]) == (limits, [0, 150])
        assert sorted(twat["own"]) == ["gauge", "limits"]
        # Another limit, not crossed: the alarm ends, and nothing says that the value came back.
        warm.put("/channels/TWAT/keys", {"limits": {**limits, "warning_high": 200}})
        ended = live.until(lambda it: not it["state"]["alarms"])
        assert ended["state"]["line"] == "sampling"
    last = [e for e in warm.get("/history")["events"] if e["kind"] == "alarm"][-1]
    assert (last["level"], last["text"]["en"]) == (
        "none",
        "Coolant temperature: the limits were changed",
    )
    reset = warm.client.delete("/api/channels/TWAT/keys", headers={"X-Mikas-Client": "tester-0001"})
    assert reset.status_code == 200
    assert channel(warm, "TWAT")["own"] == []


def test_an_outdated_or_foreign_change_of_a_channel_is_refused(warm):
    version = state_version(warm)
    warm.put("/channels/TWAT/keys", {"version": version, "gauge": [0, 150]})
    error = warm.put("/channels/TWAT/keys", {"version": version, "gauge": [0, 140]}, 409)
    assert error["code"] == "CatalogOutdated"
    error = warm.put("/channels/TWAT/keys", {"gauge": [0, 140]}, 409, headers=OTHER)
    assert error["code"] == "NotController"
    error = warm.put("/channels/TWAT/keys", {"gauge": [9, 1]}, 400)
    assert (error["code"], "catalog.toml:" in error["en"]) == ("CatalogError", True)
    assert warm.put("/channels/NONE/keys", {"gauge": [0, 1]}, 400)["code"] == "UnknownParameter"
    assert warm.put("/channels/TWAT", DOUBLE, 400)["code"] == "UsageError"
    assert warm.put("/channels/D", {**DOUBLE, "formula": "FREQ %"}, 400)["code"] == "CatalogError"
    assert channel(warm, "TWAT")["gauge"] == [0, 150]
    # An unfit file is left as it is, and said.
    own: OwnCatalog = warm.dashboard.catalogs.own
    own.path.write_text("[parameter.TWAT\n", "utf-8")
    assert "catalog.toml:1" in warm.get("/catalog")["problem"]["en"]
    said = warm.get("/about")["problems"][0]["en"]
    assert said.startswith("Your own catalog was left out: ")
    assert "catalog.toml:1" in said
    assert "catalog.toml:1" in warm.put("/channels/TWAT/keys", {"gauge": [0, 9]}, 400)["en"]
    assert own.path.read_text("utf-8") == "[parameter.TWAT\n"


def trial(it, formula, **more):
    return it.post("/channels/try", {"formula": formula, **more})


def test_a_formula_is_tried_without_being_kept(warm):
    freq = warm.get("/channels/FREQ/value")
    assert bytes.fromhex(freq["raw"])[0] * 40 == freq["value"]
    got = trial(warm, "FREQ * k", constants={"k": 2})
    assert got["value"] == 2 * got["inputs"][0]["value"] > 0
    wrong = trial(warm, "FREQ +\n TWOT")
    assert (wrong["span"], wrong["value"]) == ([8, 12], None)
    assert "the nearest is TWAT" in wrong["problem"]["en"]
    assert trial(warm, "FREQ $")["span"] == [5, 6]
    assert trial(warm, "FUEL_USED + 1", name="FUEL_FLOW")["problem"] is not None
    # No value: the engine's throttle is not in the plan, and a division by zero.
    assert trial(warm, "THR + FREQ")["inputs"][0] == {"name": "THR", "value": None}
    assert trial(warm, "FREQ / 0") == {
        "value": None, "problem": None, "span": None,
        "inputs": [{"name": "FREQ", "value": freq["value"]}],
    } or trial(warm, "FREQ / 0")["value"] is None  # fmt: skip
    assert "THR" not in NAMES
    assert warm.post("/channels/try", {"formula": "x" * 1001}, 400)["code"] == "BadRequest"


def test_a_channel_has_its_values_at_a_moment_of_a_recording(warm):
    warm.post("/recording/start", {"name": "drive"})
    warm.until(lambda it: (it["state"]["recording"] or {"samples": 0})["samples"] > 20)
    warm.post("/recording/stop")
    (file,) = warm.get("/recordings")["recordings"]
    rows = warm.get(f"/recordings/{file['id']}/rows", names="FREQ,UACC,FUEL_FLOW", points=20000)
    at = 10
    time, values = rows["times"][at], [column[at] for column in rows["values"]]
    for name, number in zip(rows["names"], values, strict=True):
        got = warm.get(f"/channels/{name}/value", recording=file["id"], at=time)
        assert (got["value"], got["time"]) == (number, pytest.approx(time, abs=1e-5))
        if name == "FREQ":
            assert bytes.fromhex(got["raw"])[0] * 40 == number
        if name == "FUEL_FLOW":
            assert got["raw"] is None
    got = trial(warm, "UACC * 2", recording=file["id"], at=time)
    assert got["value"] == 2 * values[1]
    assert trial(warm, "UACC * 2", recording=file["id"])["value"] > 0
    assert warm.get("/channels/FREQ/value", recording=file["id"], at=time - 1e6)["value"] is None
    assert warm.get("/channels/FREQ/value", 400, at="nan")["code"] == "BadRequest"


def test_rcok_has_its_value_by_each_reading_and_what_it_rests_on(warm):
    rcok = channel(warm, "RCOK")
    assert [each["name"] for each in rcok["otherwise"]] == ["alternative", "family"]
    assert rcok["evidence"]["source"] == {"en": "letter; odd", "ru": "буква; странная"}
    assert rcok["evidence"]["siblings"]["en"].startswith("`family` for RCOK")
    assert rcok["evidence"]["sightings"] == []
    assert channel(warm, "DUTY")["evidence"] is None
    warm.put("/plan", {"wanted": [{"name": "RCOK"}, {"name": "FREQ"}]})
    with warm.live() as live:
        live.until(lambda it: values_of(it, "RCOK"))
    got = warm.get("/channels/RCOK/value")
    raw = int(got["raw"], 16)
    assert got["value"] == (raw - 128) / 256 - 0.5
    assert got["otherwise"] == {"alternative": (raw - 128) / 256, "family": (raw + 128) / 256}
    assert warm.get("/channels/FREQ/value")["otherwise"] == {}
    warm.post("/recording/start", {"name": "factors"})
    warm.until(lambda it: (it["state"]["recording"] or {"samples": 0})["samples"] > 5)
    warm.post("/recording/stop")
    (file,) = warm.get("/recordings")["recordings"]
    then = warm.get("/channels/RCOK/value", recording=file["id"])
    raw = int(then["raw"], 16)
    assert then["value"] == (raw - 128) / 256 - 0.5
    assert then["otherwise"]["family"] == (raw + 128) / 256


def test_other_names_are_listed_understood_and_kept_as_mnemonics(warm):
    assert {"rpm", "обороты", "оборот"} <= set(channel(warm, "FREQ")["names"])
    tried = warm.post("/channels/try", {"formula": "обороты / 2"})
    assert [each["name"] for each in tried["inputs"]] == ["FREQ"]
    assert tried["problem"] is None
    warm.put("/channels/TWICE", {**DOUBLE, "formula": "Обороты * factor"})
    assert channel(warm, "TWICE")["formula"] == "FREQ * factor"


def test_a_doubtful_channel_lists_its_other_readings(warm):
    known = {each["name"]: each for each in warm.get("/catalog")["parameters"]}
    assert [(it["name"], it["formula"]) for it in known["RCOK"]["otherwise"]] == [
        ("alternative", "(b − 128)/256"),
        ("family", "(b + 128)/256"),
    ]
    assert known["FREQ"]["otherwise"][0]["unit"] == {"en": "1/s", "ru": "1/с"}
    assert known["TWAT"]["otherwise"] == known["TAIR"]["otherwise"] == []
