"""Every route that makes something of values, with a λ meter and a GPS beside the unit: of a
recording, and of the running connection.
"""

from __future__ import annotations

from urllib.parse import parse_qsl

import pytest

import mikas
from dashboard.rig import ME, rig

CITY = "sim:?clock=simulated&scenario=city&seed={}"
NAMES = ("FREQ", "TWAT", "JAIR", "INJ", "VALF", "UACC", "THR", "FUEL_FLOW")
BESIDE = ["LAMBDA", "AFR", "GPS_SPEED", "GPS_LAT", "GPS_LON", "GPS_ALT", "GPS_COURSE"]
METER = {"definition": "aem", "port": "sim:"}
GPS = {"definition": "nmea", "port": "sim:"}
ONE = "/recordings/one.pcapng"


def drive(path, seed):
    """A drive in town with both instruments, as the program records it."""
    with mikas.session(
        CITY.format(seed),
        NAMES,
        record=path,
        duration=60,
        rate=4,
        instruments=("aem=sim:", "nmea=sim:"),
    ) as session:
        assert session.run() > 150
    return path


@pytest.fixture(scope="module")
def desk(tmp_path_factory):
    """A dashboard with two such drives, and nothing connected."""
    folder = tmp_path_factory.mktemp("desk")
    (folder / "recordings").mkdir()
    for name, seed in (("one", 3), ("two", 4)):
        drive(folder / "recordings" / f"{name}.pcapng", seed)
    with rig(folder, None) as it:
        yield it


@pytest.fixture(scope="module")
def driven(tmp_path_factory):
    """A dashboard connected to a unit and both instruments, whose values have come."""
    with rig(tmp_path_factory.mktemp("driven"), "sim:?scenario=warm-idle&faults=13") as it:
        it.sampling()
        it.post("/instruments", METER)
        it.post("/instruments", GPS)

        def has_both(message):
            if (data := message.get("data")) is None or "LAMBDA" not in data["names"]:
                return False
            last = dict(zip(data["names"], (it[-1] for it in data["values"]), strict=True))
            return None not in (last["LAMBDA"], last["GPS_SPEED"], last["FREQ"])

        for _ in range(8):
            it.until(has_both)
        yield it


def ask(it, address):
    """What is at an address with its query."""
    path, _, query = address.partition("?")
    return it.get(path, **dict(parse_qsl(query, keep_blank_values=True)))


def column(rows, name):
    return [it for it in rows["values"][rows["names"].index(name)] if it is not None]


RECORDED = {
    "": lambda it: it["channels"][-7:] == BESIDE and not it["problems"],
    "/rows?points=100": lambda it: it["names"][-7:] == BESIDE and len(column(it, "GPS_LAT")) > 50,
    "/rows?names=GPS_SPEED,FREQ,LAMBDA": lambda it: column(it, "GPS_SPEED") and column(it, "FREQ"),
    "/report?lang=en": lambda it: "Trip" in it.text,
    "/report?lang=ru&inline=true": lambda it: "Поездка" in it.text,
    "/causes": lambda it: it["seconds"] > 40,
    "/causes?complaint=thirsty&with=two.pcapng": lambda it: it["seconds"] > 80,
    "/find?expression=FREQ>0": lambda it: it["count"] > 0,
    "/find?expression=GPS_SPEED>20 and LAMBDA>0.5": lambda it: it["count"] > 0,
    "/faults": lambda it: "frames" in it,
    "/tests/charging": lambda it: "result" in it,
    "/tests/idle": lambda it: "result" in it,
    "/tests/knock": lambda it: "result" in it,
    "/file": lambda it: len(it.content) > 10_000,
    "/export?format=csv": lambda it: all(name in it.text.splitlines()[0] for name in BESIDE),
    "/export?format=csv&dialect=excel&lang=ru": lambda it: "Скорость по GPS" in it.text,
    "/export?format=csv&names=GPS_SPEED,FREQ": lambda it: it.text.startswith(
        "Time (msec),GPS_SPEED"
    ),
    "/export?format=msl": lambda it: "LAMBDA\tAFR\tGPS_SPEED" in it.text,
    "/export?format=mlg": lambda it: b"GPS_SPEED" in it.content,
    "/export?format=gpx": lambda it: "<trkpt" in it.text and "LAMBDA" in it.text,
    "/export?format=geojson": lambda it: "LAMBDA" in it["channels"],
}
TABLES = {
    "/export?format=parquet": lambda it: b"GPS_SPEED" in it.content,
    "/export?format=mf4": lambda it: b"GPS_SPEED" in it.content,
}


@pytest.mark.parametrize("asked", RECORDED)
def test_a_recording_with_instruments(desk, asked):
    answer = ask(desk, f"{ONE}{asked}")
    assert RECORDED[asked](answer), answer


@pytest.mark.parametrize("asked", TABLES)
def test_a_recording_with_instruments_as_a_table_of_others(desk, asked):
    assert TABLES[asked](ask(desk, f"{ONE}{asked}"))


@pytest.mark.parametrize("name", ["LAMBDA", "GPS_SPEED", "FREQ"])
def test_a_channel_of_it_has_its_value(desk, name):
    value = desk.get(f"/channels/{name}/value", recording="one.pcapng")["value"]
    assert isinstance(value, float)


def test_it_is_marked_named_and_taken_as_a_reference(desk):
    desk.put("/recordings/two.pcapng/note", {"text": "lean"})
    desk.put("/recordings/two.pcapng/reference", {"on": True})
    assert "two.pcapng" in str(desk.get("/references"))
    first = desk.get("/recordings/two.pcapng")["first"]
    mark = {"markers": [{"time": first + 1.0, "label": "hill"}]}
    desk.post("/recordings/two.pcapng/markers", mark)
    found = desk.get("/recordings/two.pcapng")
    assert (found["note"], found["reference"], found["markers"]) == ("lean", True, 1)
    assert found["channels"][-7:] == BESIDE
    tried = desk.post("/channels/try", {"formula": "TWAT / 2", "recording": "two.pcapng"})
    assert "value" in str(tried)


def test_its_export_opens_as_another_programs_log(desk):
    for form in ("csv", "msl", "mlg"):
        log = desk.get(f"{ONE}/export", format=form).content
        url = f"/api/foreign-logs/preview?name=a.{form}"
        found = desk.client.post(url, content=log, headers=ME).json()
        assert {"LAMBDA", "GPS_SPEED"} <= {each["name"].split()[0] for each in found["columns"]}


LIVE = {
    "/report?lang=en": lambda it: "html" in it.text,
    "/report?lang=ru&inline=true": lambda it: "html" in it.text,
    "/causes": lambda it: "verdict" in it,
    "/causes?complaint=thirsty": lambda it: "verdict" in it,
    "/history?seconds=60&points=100": lambda it: column(it, "LAMBDA") and column(it, "GPS_SPEED"),
    "/history/find?expression=FREQ>0": lambda it: it["count"] > 0,
    "/history/find?expression=LAMBDA>0.5 and FREQ>0": lambda it: it["count"] > 0,
    "/channels/GPS_SPEED/value": lambda it: it["value"] is not None,
    "/faults": lambda it: it["faults"][0]["code"] == 13,
    "/freeze-frames": lambda it: "frames" in it,
    "/catalog": lambda it: it["version"],
    "/presets": lambda it: "presets" in it,
    "/searches": lambda it: "searches" in it,
    "/actions": lambda it: "rules" in it,
    "/tests": lambda it: it["tests"],
    "/car": lambda it: "car" in it,
}


@pytest.mark.parametrize("asked", LIVE)
def test_the_running_connection_with_instruments(driven, asked):
    """`/report` was an error: its rows have columns that are no channels of the unit."""
    answer = ask(driven, asked)
    assert LIVE[asked](answer), answer


def test_what_is_asked_of_the_unit_goes_on_beside_instruments(driven):
    assert driven.post("/plan/price", {"wanted": [{"name": "TWAT"}]})
    assert driven.post("/channels/try", {"formula": "TWAT / 2"})
    assert driven.post("/channels/try", {"formula": "LAMBDA - VALF"})
    driven.post("/tests/idle/start")
    driven.post("/tests/run/cancel")
    driven.cars.car(driven.dashboard.connection.port.url).faults.append(14)
    driven.until(lambda it: it["state"]["fault_count"] == 2)
    frames = driven.get("/freeze-frames")["frames"]
    assert frames
    driven.get(f"/freeze-frames/{frames[0]['id']}")
    driven.get("/report")  # with the frame of the moment
