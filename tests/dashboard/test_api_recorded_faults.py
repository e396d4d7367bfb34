"""The faults in a recording through the API, with the freeze frame of the one that appeared."""

from __future__ import annotations

from dashboard.recordings_rig import record, record_fault
from dashboard.rig import rig


def test_a_recording_has_its_faults_and_the_frame_of_a_new_one(tmp_path):
    folder = tmp_path / "recordings"
    folder.mkdir()
    record_fault(folder / "drive.pcapng")
    record(folder / "unread.pcapng", count=20).write_bytes(b"no capture")
    with rig(tmp_path, None) as it:
        found = it.get("/recordings/drive.pcapng/faults")
        old, new = found["faults"]
        assert [(old["code"], old["stored_before"], old["frame"])] == [(71, True, None)]
        assert (new["code"], new["stored_before"]) == (13, False)
        (frame,) = found["frames"]
        assert frame["id"] == new["frame"]
        assert frame["without"] < frame["seen"] <= new["first_seen"] <= found["time"]
        assert frame["shown"] == ["JAIR", "FREQ", "TWAT", "UACC", "MINERR"]
        then = {value["name"]: value["value"] for value in frame["values"]}
        span = {"from": frame["without"], "to": frame["seen"], "names": "MINERR"}
        (lowest,) = it.get("/recordings/drive.pcapng/rows", **span)["values"]
        assert (lowest[0], lowest[-1], then["MINERR"]) == (71, 13, 13)
        assert it.get("/recordings/none.pcapng/faults", 404)["code"] == "NotFound"
        it.get("/recordings/unread.pcapng/faults", 400)
        page = it.client.get("/api/recordings/drive.pcapng/report").text
        assert "The unit stored the fault between" in page
        assert "No freeze frame (71): stored before the first reading" in page


def test_a_fault_that_came_before_the_recording_was_stored_before(tmp_path):
    """Its first reading, of the session before, is in the file's notes."""
    url = "sim:?scenario=warm-idle&faults=71"
    with rig(tmp_path, url) as it:
        it.until(lambda now: now["state"]["fault_count"] == 1)
        it.cars.car(url).faults.append(13)
        it.until(lambda now: now["state"]["fault_count"] == 2)
        it.post("/recording/start", {"name": "after"})
        it.until(lambda now: now["state"]["recording"]["samples"] > 3)
        it.post("/recording/stop")
        faults = it.get("/recordings/after.pcapng/faults")["faults"]
        assert [(each["code"], each["stored_before"]) for each in faults] == [
            (71, True),
            (13, True),
        ]
