"""`mikas report`: of a recording, and measured now."""

from __future__ import annotations

import json
import re
import shutil
from dataclasses import replace
from pathlib import Path

import pytest
from cli_harness import is_one_short_paragraph, is_russian

from dashboard.recordings_rig import record_fault
from drives.drive_rig import Road, Session, Unit, recorded
from mikas.client.cars import CarDetails
from mikas.recording import CaptureWriter
from mikas.recording.summary import summarise


@pytest.fixture(scope="module")
def kept(tmp_path_factory):
    """Where the drive is kept once it is recorded: the tests get copies."""
    return tmp_path_factory.mktemp("kept") / "drive.pcapng"


@pytest.fixture
def drive(mikas, kept, tmp_path):
    if not kept.exists():
        argv = ("log", "-o", str(kept), "--duration", "25")
        assert mikas(*argv, sim="&faults=13").status == 0
    return Path(shutil.copy(kept, tmp_path))


def page(tmp_path, name="car.html"):
    return (tmp_path / name).read_text("utf-8")


def test_a_recording_is_reported_with_its_findings(mikas, drive, tmp_path) -> None:
    before = drive.read_bytes()
    ran = mikas("report", "drive.pcapng", "-o", "car.html")
    assert ran.status == 0, ran.err
    assert "are normal at warm idle" in ran.err
    assert ran.err.strip().endswith("car.html")
    assert '<html lang="en">' in page(tmp_path)
    assert "drive.pcapng" in page(tmp_path)
    assert drive.read_bytes() == before
    assert not list(tmp_path.glob("*.part"))


def test_a_fault_that_appeared_has_its_freeze_frame(mikas, tmp_path) -> None:
    record_fault(tmp_path / "fault.pcapng")
    ran = mikas("report", "fault.pcapng", "-o", "car.html", "--json")
    assert ran.status == 0, ran.err
    (frame,) = json.loads(ran.out)["freeze_frames"]
    assert frame["code"] == 13
    assert 0 < frame["seen"] - frame["without"] < 5
    assert frame["values"]["MINERR"]["value"] == 13
    coolant = frame["values"]["TWAT"]
    assert 80 < coolant["low"] <= coolant["value"] <= coolant["high"] < 100


def test_a_unit_is_measured_and_reported_with_its_faults(mikas, tmp_path) -> None:
    ran = mikas("report", "-o", "car.html", sim="&faults=13,53,55&scenario=key-off")
    assert ran.status == 0, ran.err
    assert "3 faults are stored: 13, 53, 55;" in ran.err
    assert "measured on a virtual car" in page(tmp_path)
    assert "a stream from the unit (71)" in page(tmp_path)
    assert [path.name for path in tmp_path.iterdir() if path.is_file()] == ["car.html"]


def test_a_measurement_can_be_kept_as_a_recording(mikas, tmp_path) -> None:
    ran = mikas(
        "report", "-o", "car.html", "--duration", "20", "--capture", "kept.pcapng", "--json", sim=""
    )
    assert ran.status == 0, ran.err
    reported = ran.object
    assert reported["outcome"] == "good"
    assert reported["faults"] == []
    assert reported["warm_idle_seconds"] > 10
    assert reported["values"]["UACC"]["mark"] == "inside"
    assert reported["values"]["UACC"]["reference"] == [13.5, 14.5]
    assert "kept.pcapng" in page(tmp_path)
    again = mikas("report", "kept.pcapng", "-o", "again.html", "--json").object
    assert again["values"] == reported["values"]


def test_a_report_in_russian_is_russian(mikas, drive, tmp_path) -> None:
    ran = mikas("report", "drive.pcapng", "-o", "car.html", "--lang", "ru")
    assert ran.status == 0
    is_russian(ran.err.replace("car.html", ""))
    assert "Отчёт о двигателе" in page(tmp_path)


@pytest.mark.parametrize(
    ("argv", "message"),
    [
        (("drive.pcapng", "-o", "car.pdf"), "browser prints it"),
        (("drive.pcapng", "-o", "drive.pcapng"), "browser prints it"),
        (("drive.pcapng", "-o", "there.html"), "--overwrite"),
        (("drive.pcapng", "-o", "nowhere/car.html"), "no such folder"),
        (("drive.pcapng", "-o", "car.html", "--duration", "5"), "nothing is measured"),
        (("drive.pcapng", "-o", "car.html", "--capture", "x.pcapng"), "nothing is measured"),
        (("there.html", "-o", "car.html"), "there.html"),
        (("drive.pcapng",), "--out is missing"),
        (("none.pcapng", "-o", "car.html"), "there is no file"),
    ],
)
def test_wrong_usage_is_refused_and_no_file_is_touched(
    mikas, drive, tmp_path, argv, message
) -> None:
    (tmp_path / "there.html").write_text("mine", "utf-8")
    before = drive.read_bytes()
    ran = mikas("report", *argv)
    assert ran.status == 2
    assert message in ran.err
    is_one_short_paragraph(ran.err)
    assert page(tmp_path, "there.html") == "mine"
    assert drive.read_bytes() == before
    assert not (tmp_path / "car.html").exists()
    if argv[-1] != "drive.pcapng":
        is_russian(mikas("report", *argv, "--lang", "ru").err, names={"html", "pcapng"})


def test_overwrite_replaces_the_file(mikas, drive, tmp_path) -> None:
    (tmp_path / "car.html").write_text("mine", "utf-8")
    assert mikas("report", "drive.pcapng", "-o", "car.html", "--overwrite").status == 0
    assert "Engine report" in page(tmp_path)


def test_without_a_unit_there_is_no_report(mikas, tmp_path) -> None:
    ran = mikas("report", "-o", "car.html", "--port", str(tmp_path / "no-adapter"))
    assert ran.status == 3
    is_one_short_paragraph(ran.err)
    assert not (tmp_path / "car.html").exists()


def test_ended_by_hand_it_reports_the_samples_so_far(mikas, tmp_path, monkeypatch) -> None:
    from mikas.cli import measuring

    events = measuring.SamplingRun.events

    def stops(current):
        for event in events(current):
            yield event
            if current.samples == 40:
                raise KeyboardInterrupt

    monkeypatch.setattr(measuring.SamplingRun, "events", stops)
    ran = mikas("report", "-o", "car.html", sim="")
    assert ran.status == 0
    assert "Stopped early" in ran.err
    samples = re.search(r"<dt>Samples</dt><dd>(\d+), ", page(tmp_path))
    assert samples is not None
    assert 40 <= int(samples[1]) < 400  # with those by which the method was chosen


def test_ended_before_the_first_sample_there_is_no_report(mikas, tmp_path, monkeypatch) -> None:
    from mikas.cli import measuring

    def stops(current):
        raise KeyboardInterrupt

    monkeypatch.setattr(measuring.SamplingRun, "events", stops)
    assert mikas("report", "-o", "car.html", sim="").status == 130
    assert not (tmp_path / "car.html").exists()


def test_the_car_is_kept_and_stands_in_recording_and_report(mikas, tmp_path) -> None:
    options = ("--car", "Волга 3110", "--plate", "А123ВС 52", "--workshop", "Гараж")
    ran = mikas(
        "log", "-o", "one.pcapng", "TWAT", "--count", "3", *options, "--mileage", "154000", sim=""
    )
    assert ran.status == 0, ran.err
    details = summarise(tmp_path / "one.pcapng").car
    assert details == CarDetails("Волга 3110", "А123ВС 52", 154_000, "Гараж")
    assert mikas("log", "-o", "two.pcapng", "TWAT", "--count", "3").status == 0
    assert summarise(tmp_path / "two.pcapng").car == replace(details, mileage=None)
    assert mikas("report", "one.pcapng", "-o", "car.html", "--lang", "ru").status == 0
    head = page(tmp_path).split("</header>")[0]
    for text in ("Волга 3110", "А123ВС 52", "154\N{NO-BREAK SPACE}000 км", "Гараж"):
        assert f"<dd>{text}</dd>" in head
    ran = mikas("report", "two.pcapng", "-o", "other.html", "--mileage", "160000")
    assert ran.status == 0
    assert "160\N{NO-BREAK SPACE}000 km" in (tmp_path / "other.html").read_text("utf-8")
    assert summarise(tmp_path / "two.pcapng").car.mileage is None  # the file stays as it was
    assert mikas("report", "two.pcapng", "-o", "x.html", "--mileage", "-1").status == 2


def test_a_recording_from_which_all_packets_were_cut_says_so(mikas, tmp_path):
    """`editcap -B` with an early date leaves the section and the port."""
    with CaptureWriter(tmp_path / "none.pcapng", url="/dev/ttyUSB0"):
        pass
    ran = mikas("report", "none.pcapng", "-o", "out.html")
    assert ran.status == 0, ran.err
    sentence = "The file has no packets"
    assert sentence in ran.out + ran.err
    assert sentence in (tmp_path / "out.html").read_text("utf-8")


def test_what_instruments_add_is_in_the_json(mikas, tmp_path):
    unit = [Unit(at / 4, 1200, 7.2, aimed=1.0, throttle=10) for at in range(480)]
    road = [Road(2 + at / 10, 36.0, lambda_=1.05) for at in range(1170)]
    recorded(tmp_path / "a.pcapng", Session(unit, road))
    found = mikas("report", "a.pcapng", "-o", "a.html", "--json").object
    assert found["trip"]["kilometres"] == pytest.approx(1.17, rel=0.01)
    (cell,) = found["mixture"]["cells"]
    assert (cell["verdict"], cell["rpm"], found["mixture"]["load"]) == (
        "leaner",
        [1100, 1600],
        "THR",
    )
    recorded(tmp_path / "b.pcapng", Session(unit))
    found = mikas("report", "b.pcapng", "-o", "b.html", "--json").object
    assert (found["trip"], found["mixture"]) == (None, None)
