"""The car of the connected unit, and of a recording."""

from __future__ import annotations

from dashboard.rig import rig

VOLGA = {"car": "Волга 3110", "plate": "А123ВС 52", "mileage": 154000, "workshop": "Гараж"}


def test_a_car_is_asked_once_kept_and_written_into_the_recording(tmp_path) -> None:
    with rig(tmp_path, "sim:?scenario=warm-idle") as it:
        it.until(lambda now: now["state"]["model"])
        assert it.get("/car") == {
            "car": "", "plate": "", "mileage": None, "workshop": "", "unit": True, "asked": False,
        }  # fmt: skip
        it.post("/recording/start", {"name": "one"})
        assert it.put("/car", VOLGA) == {**VOLGA, "unit": True, "asked": True}
        it.post("/recording/stop")
        it.post("/recording/start", {"name": "two"})
        it.post("/recording/stop")
        listed = {each["id"]: each["car"] for each in it.get("/recordings")["recordings"]}
        assert listed == {"one.pcapng": VOLGA, "two.pcapng": {**VOLGA, "mileage": None}}
        newer = {**VOLGA, "mileage": 160000}
        assert it.put("/recordings/two.pcapng/car", newer) == newer
        assert it.get("/recordings/two.pcapng")["car"] == newer
        assert "160\N{NO-BREAK SPACE}000 km" in it.get("/recordings/two.pcapng/report").text
        assert "154\N{NO-BREAK SPACE}000 км" in it.get("/report", lang="ru").text
        it.put("/car", {**VOLGA, "mileage": None})
        assert it.get("/car")["mileage"] == 154000  # the last one, to be offered
        text = it.get("/report").text
        assert "А123ВС 52" in text
        assert "154" not in text.split("</header>")[0]
        assert it.put("/car", {"mileage": -1}, 400)["code"] == "BadRequest"
        assert it.put("/recordings/none.pcapng/car", VOLGA, 404)["code"] == "NotFound"


def test_a_car_that_was_put_off_counts_as_asked_and_stays_empty(tmp_path) -> None:
    with rig(tmp_path, "sim:?scenario=warm-idle") as it:
        it.until(lambda now: now["state"]["model"])
        it.put("/car", {})
        assert it.get("/car")["asked"] is True
        it.post("/recording/start", {"name": "one"})
        it.post("/recording/stop")
        (listed,) = it.get("/recordings")["recordings"]
        assert listed["car"] == {"car": "", "plate": "", "mileage": None, "workshop": ""}


def test_given_to_the_first_recording_it_is_kept_for_the_next(tmp_path) -> None:
    with rig(tmp_path, "sim:?scenario=warm-idle") as it:
        it.until(lambda now: now["state"]["model"])
        it.put("/car", {})  # the question was put off
        for name in ("one", "two"):
            it.post("/recording/start", {"name": name})
            it.until(lambda now: now["state"]["recording"]["samples"] > 3)
            it.post("/recording/stop")
            if name == "one":
                it.put("/recordings/one.pcapng/car", VOLGA)
        assert it.get("/recordings/two.pcapng")["car"] == {**VOLGA, "mileage": None}
        other = {**VOLGA, "plate": "В777ВВ 52"}
        it.put("/recordings/two.pcapng/car", other)  # known by now: of this recording only
        assert it.get("/car")["plate"] == VOLGA["plate"]
