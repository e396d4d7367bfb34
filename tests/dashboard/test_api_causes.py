"""The causes through the API: of the running connection, of recordings, and what is refused."""

from __future__ import annotations

from dashboard.recordings_rig import record
from dashboard.rig import rig
from mikas.client.cars import CarDetails
from mikas.recording.annotations.events import car_note
from mikas.recording.capture.writer import append_note
from mikas.sampling.events import UnitFound

LEAK = "&scenario=warm-idle&car=leak:9"
OWN = """\
id = "gremlin"
[text]
en = "A gremlin"
[check]
en = "Look for it."
[effects]
nonsense = 5
"""


def test_a_recording_has_its_causes_with_moments_and_the_next_measurement(tmp_path):
    folder = tmp_path / "recordings"
    folder.mkdir()
    record(folder / "leak.pcapng", LEAK, count=2500)
    record(folder / "unread.pcapng", count=20).write_bytes(b"no capture")
    with rig(tmp_path, None) as it:
        found = it.get("/recordings/leak.pcapng/causes", complaint="idles-high")
        assert found["verdict"] in ("causes", "cannot-tell")  # two minutes of idle are little
        first = found["causes"][0]
        assert first["id"] == "leak"
        assert first["likely"]["en"]
        evidence = first["speaks_for"][0]
        assert evidence["recording"] == "leak.pcapng"
        rows = it.get("/recordings/leak.pcapng/rows", names="FREQ")["times"]
        assert all(rows[0] <= m["begin"] <= m["end"] <= rows[-1] for m in evidence["moments"])
        assert {"test", "guided", "text", "why", "outcomes"} == found["next"][0].keys()
        assert len(found["complaints"]) == 8
        again = {"with": ["leak.pcapng", "leak.pcapng"]}
        twice = it.get("/recordings/leak.pcapng/causes", complaint="hunts", **again)
        assert twice["seconds"] == found["seconds"]
        it.get("/recordings/none.pcapng/causes", 404)
        it.get("/recordings/unread.pcapng/causes", 400)
        it.get("/recordings/leak.pcapng/causes", 400, complaint="nonsense")


def owned(path, plate: str, settings: str = ""):
    """A minute's recording of somebody's car."""
    record(path, f"&scenario=warm-idle{settings}", count=600)
    append_note(path, car_note(1.0, CarDetails(plate=plate)))
    return path


def test_several_recordings_of_a_car_count_together_and_others_are_refused_by_name(tmp_path):
    folder = tmp_path / "recordings"
    folder.mkdir()
    for name, plate, settings in (
        ("one", "A1", "&car=leak:9"), ("two", "а 1", "&car=leak:9"), ("three", "B2", ""),
        ("old", "A1", "&model=5.4"),
    ):  # fmt: skip
        owned(folder / f"{name}.pcapng", plate, settings)
    (folder / "unread.pcapng").write_bytes(b"no capture")
    with rig(tmp_path, None) as it:
        alone = it.get("/recordings/one.pcapng/causes")
        both = it.get("/recordings/one.pcapng/causes", **{"with": "two.pcapng"})
        assert both["seconds"] > 1.9 * alone["seconds"]
        evidence = [each for cause in both["causes"] for each in cause["speaks_for"]]
        assert {each["recording"] for each in evidence} <= {"one.pcapng", "two.pcapng"}
        for other, words in {
            "three": "it is a recording of B2, and one.pcapng is one of",
            "old": "it is a recording of a Mikas 5.4, and one.pcapng is one of a Mikas 7.1",
            "unread": "unread.pcapng",
        }.items():
            asked = {"with": f"{other}.pcapng"}
            error = it.get("/recordings/one.pcapng/causes", 400, **asked)
            assert f"{other}.pcapng" in error["en"]
            assert words in error["en"]
        gone = it.get("/recordings/one.pcapng/causes", 404, **{"with": "gone.pcapng"})
        assert "gone.pcapng" in gone["en"]


def test_of_the_connected_car_too_little_says_what_is_missing(tmp_path):
    with rig(tmp_path, "sim:?scenario=warm-idle") as it:
        it.until(lambda now: now["state"]["line"] == "sampling")
        found = it.get("/causes")
        assert found["verdict"] in ("cannot-tell", "sound")
        assert found["not_seen"]
        assert found["doubts"]


def test_without_a_connection_there_are_no_causes(tmp_path):
    with rig(tmp_path, None) as it:
        it.get("/causes", 503)


def test_a_wrong_file_of_one_s_own_is_reported_with_its_line(tmp_path):
    folder = tmp_path / "causes"
    folder.mkdir()
    (folder / "gremlin.toml").write_text(OWN, "utf-8")
    with rig(tmp_path, "sim:?scenario=warm-idle") as it:
        it.until(lambda now: now["state"]["line"] == "sampling")
        (error,) = it.get("/causes")["errors"]
        assert error["file"].endswith("gremlin.toml")
        assert error["line"] == 7


def test_another_virtual_car_is_not_judged_by_the_values_of_the_one_before(tmp_path):
    """All virtual units have the same passport, so only the address knows them apart."""
    with rig(tmp_path, "sim:?scenario=warm-idle") as it:
        for car in ("leak:8", "leak:8", "leak:9"):
            it.sampling()
            it.post("/connect", {"port": f"sim:?scenario=warm-idle&car={car}"})
        it.sampling()
        found = [each for each in it.dashboard.monitor.logged if isinstance(each, UnitFound)]
        assert [each.another for each in found] == [False, True, False, True]
        rows = it.dashboard.history.rows(7200)
        assert it.get("/causes")["seconds"] <= it.dashboard.connection.now() - found[-1].time
        assert rows.times[0] < found[-1].time
