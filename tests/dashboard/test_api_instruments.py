"""Instruments beside the unit in the dashboard: chosen, read on its line, recorded, kept."""

from __future__ import annotations

import pytest

from dashboard.rig import ME, OTHER, rig

IDLE = "sim:?scenario=warm-idle"
METER = {"definition": "aem", "port": "sim:"}
GPS = {"definition": "nmea", "port": "sim:"}
PHONE = {"definition": "phone", "port": "position:"}
BOOST = {
    "text": {"en": "Boost gauge", "ru": "Манометр наддува"},
    "baud": 115200,
    "patterns": ["P={BOOST_BAR} bar, {} C*"],
    "stale": 0.5,
    "channels": [
        {
            "name": "BOOST_BAR", "text": {"en": "Boost", "ru": "Наддув"}, "unit": "bar",
            "range": [-1, 4],
        }
    ],
}  # fmt: skip
HERE = {"latitude": 55.75, "longitude": 37.62, "altitude": 150.5, "speed": 10, "heading": 90}


def states(message):
    return {each["name"]: each["state"] for each in message["state"]["instruments"]}


def with_values(it, *names):
    """The first live message that has values of all these channels."""

    def has(message):
        data = message.get("data")
        return data is not None and all(
            name in data["names"] and data["values"][data["names"].index(name)][-1] is not None
            for name in names
        )

    return it.until(has)


def test_there_are_none_at_first_and_the_definitions_say_where_each_is_read(off):
    found = off.get("/instruments")
    assert (found["instruments"], found["channels"], found["problems"]) == ([], [], [])
    assert {each["name"]: each["at"] for each in found["definitions"]} == {
        "aem": "port", "innovate": "port", "14point7": "port", "nmea": "port",
        "gpsd": "gpsd", "phone": "position",
    }  # fmt: skip
    assert "LAMBDA" in [each["name"] for each in found["known"]]


def test_a_meters_values_are_columns_beside_the_units_with_units_and_limits(idle):
    before = idle.get("/state")["instruments_version"]
    added = idle.post("/instruments", METER)
    assert [each["name"] for each in added["instruments"]] == ["aem"]
    (channel,) = [each for each in added["channels"] if each["name"] == "LAMBDA"]
    assert (channel["instrument"], channel["unit"]["en"], channel["gauge"]) == (
        True, "λ", [0.6, 1.4],
    )  # fmt: skip
    message = with_values(idle, "FREQ", "LAMBDA", "AFR")
    assert states(message) == {"aem": "values"}
    assert message["state"]["instruments_version"] > before
    data = message["data"]
    assert data["values"][data["names"].index("LAMBDA")][-1] == pytest.approx(1, abs=0.3)
    assert idle.get("/channels/LAMBDA/value")["value"] == pytest.approx(1, abs=0.3)
    assert "LAMBDA" in idle.get("/history")["names"]


def test_pages_hear_of_each_change_of_an_instrument(idle):
    with idle.live() as live:
        idle.post("/instruments", METER)
        seen = []

        def gives_values(message):
            seen.extend(e for e in message.get("events", []) if e["kind"] == "instrument")
            return any(e["state"] == "values" for e in seen)

        live.until(gives_values)
    assert [e["state"] for e in seen] == ["connected", "values"]
    assert seen[0]["text"]["en"] == "the instrument aem is connected at sim:"


def test_a_recording_has_them_and_goes_on_in_another_file_when_one_is_added(idle):
    idle.post("/recording/start", {"name": "drive"})
    idle.post("/instruments", METER)
    with_values(idle, "LAMBDA")
    idle.post("/recording/stop")
    found = {each["id"] for each in idle.get("/recordings")["recordings"]}
    assert found == {"drive.pcapng", "drive-2.pcapng"}
    rows = idle.get("/recordings/drive-2.pcapng/rows", names="FREQ,LAMBDA")
    column = rows["values"][rows["names"].index("LAMBDA")]
    assert [value for value in column if value is not None]


def test_a_recording_names_their_channels_also_labelled_ones_that_are_gone(idle):
    idle.post("/instruments", METER | {"label": "left"})
    idle.post("/recording/start", {"name": "drive"})
    with_values(idle, "LAMBDA_LEFT")
    idle.post("/recording/stop")
    idle.delete("/instruments/left:aem")
    beside = idle.get("/recordings/drive.pcapng")["instruments"]
    assert [each["name"] for each in beside] == ["LAMBDA_LEFT", "AFR_LEFT"]
    assert beside[0]["text"]["en"] == "Mixture λ, measured, left"
    assert (beside[0]["unit"]["en"], beside[0]["decimals"]) == ("λ", 3)
    recorded = {"recording": "drive.pcapng"}
    value = idle.get("/channels/LAMBDA_LEFT/value", **recorded)["value"]
    assert value == pytest.approx(1, abs=0.3)
    unknown = idle.get("/channels/LAMBDA_RIGHT/value", status=400, **recorded)
    assert unknown["code"] == "UnknownParameter"


def alarms_of(message, name):
    return [each["level"] for each in message["state"]["alarms"] if each["name"] == name]


def test_a_limit_of_an_instruments_channel_alarms_and_the_alarm_ends_with_its_values(idle):
    idle.post("/instruments", METER)
    with_values(idle, "LAMBDA")
    version = idle.get("/state")["instruments_version"]
    idle.put("/channels/LAMBDA/keys", {"limits": {"danger_high": 0.5}})
    found = idle.get("/instruments")
    (channel,) = [each for each in found["channels"] if each["name"] == "LAMBDA"]
    assert (channel["limits"]["danger_high"], channel["own"]) == (0.5, ["limits"])
    assert idle.get("/state")["instruments_version"] > version
    idle.until(lambda it: alarms_of(it, "LAMBDA") == ["danger"])
    with idle.live() as live:
        idle.delete("/channels/LAMBDA/keys")
        live.until(lambda it: not alarms_of(it, "LAMBDA"))
    assert idle.get("/instruments")["channels"][0]["limits"] is None


def test_one_that_is_removed_gives_no_more_values(idle):
    idle.post("/instruments", METER)
    idle.post("/instruments", GPS)
    with_values(idle, "LAMBDA", "GPS_SPEED")
    left = idle.delete("/instruments/aem")
    assert [each["name"] for each in left["instruments"]] == ["nmea"]
    message = with_values(idle, "GPS_SPEED")
    assert "LAMBDA" not in message["data"]["names"]
    assert idle.delete("/instruments/aem", status=404)["code"] == "NotFound"


def test_they_outlive_the_program_and_what_is_damaged_is_said(tmp_path):
    with rig(tmp_path, IDLE) as it:
        it.post("/instruments", METER)
    with rig(tmp_path, IDLE) as it:
        with_values(it, "LAMBDA")
        file = it.dashboard.settings.in_state("instruments.json")
    file.write_text(
        '[{"definition": "gone", "port": "sim:", "label": ""},'
        ' {"definition": "aem", "port": "sim:", "label": "left"}]'
    )
    with rig(tmp_path, IDLE) as it:
        found = it.get("/instruments")
        assert [each["name"] for each in found["instruments"]] == ["left:aem"]
        assert found["channels"][0]["name"] == "LAMBDA_LEFT"
        assert "“gone”" in found["problems"][0]["en"]


def test_two_of_a_kind_need_a_label(idle):
    idle.post("/instruments", METER)
    assert "label" in idle.post("/instruments", METER, status=400)["en"]
    idle.post("/instruments", METER | {"label": "right"})
    with_values(idle, "LAMBDA", "LAMBDA_RIGHT")


@pytest.mark.parametrize(
    ("body", "words"),
    [
        ({"definition": "nothing", "port": "sim:"}, "no instrument"),
        ({"definition": "aem", "port": "nowhere://x"}, "nowhere"),
        ({"definition": "aem", "port": "gpsd:localhost"}, "gpsd serves GPS receivers"),
        ({"definition": "aem", "port": "position:"}, "position"),
        ({"definition": "phone", "port": "sim:"}, "position"),
        ({"definition": "aem", "port": "sim:", "label": "1"}, "label"),
        ({"definition": "aem", "port": IDLE}, "no options"),
    ],
)
def test_what_can_not_be_read_is_refused_and_why(idle, body, words):
    assert words in idle.post("/instruments", body, status=400)["en"]
    assert idle.get("/instruments")["instruments"] == []


def test_a_phones_position_is_an_instrument_whose_values_the_page_sends(idle):
    assert idle.post("/instruments/position", HERE, status=404)["code"] == "NotFound"
    idle.post("/instruments", PHONE)
    idle.post("/recording/start", {"name": "drive"})
    with idle.live() as live:
        for _ in range(200):  # of the fast time: a position holds for seconds only
            idle.post("/instruments/position", HERE, headers=OTHER)  # a phone that looks on
            data = live.next().get("data")
            if data and data["values"][data["names"].index("GPS_LAT")][-1] is not None:
                break
    row = dict(zip(data["names"], (column[-1] for column in data["values"]), strict=True))
    assert (row["GPS_LAT"], row["GPS_LON"], row["GPS_ALT"]) == (55.75, 37.62, 150.5)
    assert (row["GPS_SPEED"], row["GPS_COURSE"]) == (36, 90)
    idle.post("/recording/stop")
    (found,) = idle.get("/recordings")["recordings"]
    rows = idle.get(f"/recordings/{found['id']}/rows", names="GPS_LAT")
    assert 55.75 in rows["values"][rows["names"].index("GPS_LAT")]


@pytest.mark.parametrize(
    "wrong", [{"latitude": 91}, {"longitude": "x"}, {"speed": -1}, {"heading": 400}]
)
def test_no_position_out_of_this_world_is_taken(idle, wrong):
    assert idle.post("/instruments/position", HERE | wrong, status=400)["code"] == "BadRequest"


def test_a_definition_of_ones_own_is_a_file_and_can_be_changed(off):
    found = off.put("/instruments/definitions/boost-gauge", BOOST)
    (own,) = [each for each in found["definitions"] if each["own"]]
    assert (own["name"], own["baud"], own["patterns"]) == ("boost-gauge", 115200, BOOST["patterns"])
    assert [each["name"] for each in own["channels"]] == ["BOOST_BAR"]
    file = off.dashboard.settings.in_state("instruments") / "boost-gauge.toml"
    assert "P={BOOST_BAR} bar" in file.read_text("utf-8")
    off.post("/instruments", {"definition": "boost-gauge", "port": "/dev/ttyUSB9"})
    changed = off.put("/instruments/definitions/boost-gauge", BOOST | {"baud": 9600})
    assert [each["baud"] for each in changed["definitions"] if each["own"]] == [9600]
    refused = off.delete("/instruments/definitions/boost-gauge", status=409)
    assert "remove it first" in refused["en"]
    off.delete("/instruments/boost-gauge")
    left = off.delete("/instruments/definitions/boost-gauge")
    assert not any(each["own"] for each in left["definitions"])
    assert not file.exists()


def test_what_else_a_definitions_file_has_stays_when_it_is_changed(off):
    off.put("/instruments/definitions/mine", BOOST)
    file = off.dashboard.settings.in_state("instruments") / "mine.toml"
    file.write_text(
        'text = { en = "Boost", ru = "Наддув" }\ndecoder = "line"\npatterns = ["{BOOST_BAR}"]\n'
        'source = "its manual"\n[instrument.BOOST_BAR]\ntext = { en = "B", ru = "Н" }\n'
        "range = [-1, 4]\ndecimals = 3\nlimits = { danger_high = 1.5 }\n",
        "utf-8",
    )
    (channel,) = BOOST["channels"]
    changed = BOOST | {"baud": 9600, "channels": [channel | {"range": None, "unit": "psi"}]}
    found = off.put("/instruments/definitions/mine", changed)
    (own,) = [each for each in found["definitions"] if each["own"]]
    (boost,) = own["channels"]
    assert (own["baud"], boost["unit"]["en"], boost["range"]) == (9600, "psi", None)
    assert (boost["decimals"], boost["limits"]["danger_high"]) == (3, 1.5)
    assert "its manual" in file.read_text("utf-8")


@pytest.mark.parametrize(
    ("name", "change", "words"),
    [
        ("aem", {}, "taken"),
        ("mine", {"patterns": ["{X"]}, "{"),
        ("mine", {"patterns": ["{OTHER}"]}, "OTHER"),
        ("mine", {"channels": []}, "BOOST_BAR"),
        ("mine", {"patterns": ["R={FREQ}"]}, "FREQ, which the unit itself sends"),
        ("mine", {"patterns": ["{LAMBDA}"]}, "BOOST_BAR"),
        ("Mine", {}, "name"),
    ],
)
def test_a_wrong_definition_is_refused_and_why(off, name, change, words):
    error = off.put(f"/instruments/definitions/{name}", BOOST | change, status=400)
    assert words in error["en"]
    assert not any(each["own"] for each in off.get("/instruments")["definitions"])


def test_a_damaged_file_of_a_definition_is_said_with_its_line(off):
    off.put("/instruments/definitions/mine", BOOST)
    file = off.dashboard.settings.in_state("instruments") / "mine.toml"
    file.write_text('decoder = "line"\nbaud = "fast"\n')
    (problem,) = off.get("/instruments")["problems"]
    assert "mine.toml:2" in problem["en"]


def test_only_who_has_control_changes_them(idle):
    idle.post("/control/take", headers=ME)
    for refused in (
        idle.post("/instruments", METER, 409, OTHER),
        idle.delete("/instruments/aem", 409, OTHER),
        idle.put("/instruments/definitions/mine", BOOST, 409, OTHER),
        idle.delete("/instruments/definitions/mine", 409, OTHER),
    ):
        assert refused["code"] == "NotController"
    assert idle.get("/instruments", headers=OTHER)["instruments"] == []


def test_its_channels_may_be_shown_though_they_are_not_asked_of_the_unit(idle):
    idle.post("/instruments", METER)
    assert idle.put("/plan/first", {"names": ["FREQ", "LAMBDA"]})["plan"]["first"] == ["FREQ"]


def test_an_adapter_of_an_instrument_is_not_taken_for_the_units(off):
    off.post("/instruments", {"definition": "aem", "port": "/dev/ttyUSB7"})
    assert off.post("/connect", {"port": None}, status=503)["code"] == "NoPortGiven"


def test_the_unit_is_not_looked_for_at_the_port_of_an_instrument(off, tmp_path):
    link = tmp_path / "by-id"
    link.symlink_to("/dev/null")
    off.post("/instruments", {"definition": "aem", "port": "/dev/null"})
    for port in ("/dev/null", "/dev/null?baud=9600", str(link)):
        refused = off.post("/connect", {"port": port}, status=400)
        assert "an instrument beside the unit" in refused["en"]
    refused = off.post(
        "/instruments", {"definition": "innovate", "port": str(link), "label": "rear"}, status=400
    )
    assert "aem is at the port" in refused["en"]
    off.delete("/instruments/aem")
    off.post("/connect", {"port": "/dev/null"})
    refused = off.post("/instruments", {"definition": "aem", "port": str(link)}, status=400)
    assert "the unit itself is at /dev/null" in refused["en"]
