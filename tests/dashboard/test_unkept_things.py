"""What the dashboard can't save: work goes on, and each kind is said once, on the page, too."""

from __future__ import annotations

from dashboard.rig import ME, rig

CAR = "sim:?scenario=warm-idle&faults=71"
NAMES = ("FREQ", "TWAT", "MINERR")
VOLGA = {"car": "Волга 3110", "plate": "А123ВС 52", "mileage": 154000, "workshop": "Гараж"}


def stores(it, *codes):
    """The unit stores more faults; waits until their frames are shown."""
    it.cars.car(CAR).faults.extend(codes)
    it.until(lambda _: {*codes} <= {one["code"] for one in it.get("/freeze-frames")["frames"]})


def said_on_the_page(it, count):
    """The sentences, which the page asks for when it has heard that there is one more."""
    it.until(lambda message: message["state"]["unkept"] == count)
    return it.get("/about")["problems"]


def test_frames_and_cars_that_can_not_be_saved_stay_and_are_said_once(tmp_path, said):
    state = tmp_path / "state"
    state.mkdir()
    (state / "freeze-frames").write_text("in the place of the folder")
    with rig(tmp_path, CAR, names=NAMES) as it:
        it.until(lambda message: message["state"]["fault_count"] == 1)
        assert said_on_the_page(it, 0) == []
        stores(it, 13)
        (frames,) = said_on_the_page(it, 1)
        assert f"can't be saved in {state / 'freeze-frames'} (" in frames["en"]
        assert "Стоп-кадры не сохраняются" in frames["ru"]
        stores(it, 14, 17)
        assert said_on_the_page(it, 1) == [frames]
        (frame, *others) = it.get("/freeze-frames")["frames"]
        rest = it.delete(f"/freeze-frames/{frame['id']}")["frames"]
        assert [one["id"] for one in rest] == [one["id"] for one in others]

        (state / "cars.json.new").mkdir()
        it.post("/recording/start", {"name": "one"})
        for _ in range(2):
            assert it.put("/car", VOLGA) == {**VOLGA, "unit": True, "asked": True}
        it.post("/recording/stop")
        it.post("/recording/start", {"name": "two"})
        it.post("/recording/stop")
        listed = {each["id"]: each["car"] for each in it.get("/recordings")["recordings"]}
        assert listed == {"one.pcapng": VOLGA, "two.pcapng": {**VOLGA, "mileage": None}}
        assert said_on_the_page(it, 2)[0] == frames
        assert it.get("/about")["problems"][1]["en"].startswith("The car's details can't be saved")
        assert [sentence.en for sentence in said] == [
            each["en"] for each in it.get("/about")["problems"]
        ]


def test_details_given_to_a_recording_are_in_it_though_they_can_not_be_kept(tmp_path, said):
    with rig(tmp_path, CAR) as it:
        it.until(lambda message: message["state"]["model"])
        it.post("/recording/start", {"name": "one"})
        it.until(lambda message: message["state"]["recording"]["samples"] > 3)
        it.post("/recording/stop")
        (tmp_path / "state" / "cars.json.new").mkdir(parents=True)
        assert it.put("/recordings/one.pcapng/car", VOLGA) == VOLGA
        assert it.get("/recordings/one.pcapng")["car"] == VOLGA
        assert it.get("/car", headers=ME)["plate"] == VOLGA["plate"]
        assert len(said) == 1
