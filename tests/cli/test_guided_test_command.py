"""`mikas test`: the list, a guided test on a virtual car, over a recording, and wrong names."""

from __future__ import annotations

import time

import pytest

from link_rig import registered
from mikas.link import open_link
from mixture_by_meter import MIXTURE
from sampling.computer_harness import BEGAN, NIGHT, YEARS

CAR = "duration = 999\n[start]\nambient = 12\n[condition]\ncoolant_sensor = 15\n"


@pytest.fixture
def port(tmp_path):
    (tmp_path / "car.toml").write_text(CAR, "utf-8")
    return "--port", "sim:?clock=simulated&scenario=car.toml"


def test_without_a_name_the_tests_are_listed(mikas):
    listed = mikas("test", "--json").object
    assert "charging" in [it["name"] for it in listed["tests"]]
    assert listed["errors"] == []
    assert "Датчики в покое" in mikas("test", "--lang", "ru").out


def test_a_fault_is_found_live_and_in_a_recording(mikas, port):
    ran = mikas(*port, "test", "sensors", "--json", "--capture", "cold.pcapng")
    assert ran.status == 0
    result = ran.object["result"]
    assert (ran.object["test"], result["outcome"]) == ("sensors", "attention")
    assert "coolant 27 °C, intake air 12 °C" in result["verdict"]["en"]
    assert "1/1. Ignition on, engine off." in ran.err
    again = mikas("test", "sensors", "--recording", "cold.pcapng", "--json").object["result"]
    assert again["findings"] == result["findings"]
    words = mikas("test", "sensors", "--recording", "cold.pcapng", "--lang", "ru").out
    assert words.startswith("Датчики в покое (холодный двигатель): обратите внимание")
    for test, advice in (("charging", "skip them: load"), ("idle", "")):
        ran = mikas("test", test, "--recording", "cold.pcapng", "--json")
        assert ran.object["result"] is None
        assert advice in ran.err


def test_a_skipped_step_decides_nothing_and_an_unfinished_test_has_no_result(mikas, port):
    ran = mikas(*port, "test", "cranking", "--skip", "crank", "--json")
    assert ran.object["result"]["outcome"] == "unknown"
    ran = mikas(*port, "test", "cranking", "--duration", "6", "--json")
    assert ran.object["result"] is None
    assert "did not come to its end" in ran.err


IDLING = (
    "duration = 999\n[start]\nrunning = true\ncoolant = 86\n[timeline]\ngear = 0\nthrottle = 0\n"
)


def test_an_unmet_condition_is_said_with_value_and_limit(mikas, tmp_path):
    (tmp_path / "open.toml").write_text(
        IDLING + "[condition]\nthrottle_stops = [7, 100]\n", "utf-8"
    )
    port = "--port", "sim:?clock=simulated&scenario=open.toml"
    ran = mikas(*port, "test", "idle", "--duration", "60", "--capture", "open.pcapng")
    said = ran.err.replace("\u00a0", " ")
    assert "waiting: Throttle position 7 %: at most 5 % is needed" in said
    assert "verdict: Throttle position 7 %" in said
    assert "it does not close" in said
    again = mikas("test", "idle", "--recording", "open.pcapng", "--lang", "ru")
    assert "ближе всего было: Дроссель 7 %: нужно не больше 5 %" in again.err.replace("\u00a0", " ")


def test_a_coolant_sensor_that_shows_too_little_ends_in_a_verdict(mikas, tmp_path):
    (tmp_path / "cold.toml").write_text(
        IDLING.replace("throttle = 0", "throttle = [[0, 0], [130, 0], [132, 9], [999, 9]]")
        + "[condition]\ncoolant_sensor = -40\n",
        "utf-8",
    )
    ran = mikas("--port", "sim:?clock=simulated&scenario=cold.toml", "test", "idle", "--json")
    assert [it["rule"] for it in ran.object["result"]["findings"]] == ["coolant_sensor"]
    assert "at least 75" in ran.err


PULLS = """duration = 200
[start]
running = true
coolant = 86
[timeline]
gear = [[0, 3], [200, 3]]
throttle = [[0, 15], [20, 15], [21, 80], [27, 80], [28, 15], [60, 15], [61, 80], [68, 80], [69, 15]]
speed = [[0, 60], [21, 60], [27, 80], [40, 60], [61, 60], [68, 85], [90, 60]]
[condition]
knock = {knock}
"""


@pytest.mark.parametrize(("knock", "outcome", "rule"), [(6, "bad", "knock"), (0, "good", "good")])
def test_a_pull_is_found_wherever_it_stands_in_a_recording(mikas, tmp_path, knock, outcome, rule):
    (tmp_path / "pulls.toml").write_text(PULLS.format(knock=knock), "utf-8")
    port = "--port", "sim:?clock=simulated&scenario=pulls.toml"
    names = "FREQ", "THR", "TWAT/20", "UOZ", "UOZOC", "DET", "RDET"
    mikas(*port, "log", *names, "-o", "pulls.pcapng", "--duration", "80")
    result = mikas("test", "knock", "--recording", "pulls.pcapng", "--json").object["result"]
    assert (result["outcome"], [it["rule"] for it in result["findings"]]) == (outcome, [rule])
    assert [it["name"] for it in result["steps"]] == ["pull"]
    (times,) = (it["value"] for it in result["numbers"] if it["name"] == "TIMES")
    assert (times >= 3) is (knock > 0)


def test_an_ignition_only_unit_is_found_out_and_said(mikas, tmp_path):
    (tmp_path / "idling.toml").write_text(
        IDLING.replace("throttle = 0", "throttle = [[0, 0], [45, 0], [47, 10], [999, 10]]"), "utf-8"
    )
    url = "sim:?clock=simulated&model=5.4&ignition_only=yes&scenario=idling.toml"
    ran = mikas("--port", url, "test", "idle", "--json", "--capture", "old.pcapng")
    result = ran.object["result"]
    assert (result["outcome"], [it["rule"] for it in result["findings"]]) == (
        "good",
        ["good_ignition"],
    )
    mikas("report", "old.pcapng", "-o", "report.html", "--lang", "en")
    page = (tmp_path / "report.html").read_text("utf-8")
    assert "this unit controls the ignition alone" in page
    assert "outside the normal range" not in page


def test_a_wrong_name_is_answered_with_those_there_are(mikas, port):
    assert "there is: charging" in mikas(*port, "test", "chargin").err
    assert "its steps: rest, crank" in mikas(*port, "test", "cranking", "--skip", "x").err


@pytest.mark.parametrize("seconds", [YEARS, -NIGHT])
def test_a_result_has_its_true_date_though_that_was_set_meanwhile(
    mikas, port, monkeypatch, seconds
):
    links = []

    def open_real(*_):
        link = open_link(port[1])
        link.is_simulated = link.is_virtual = False
        links.append(link)
        return link

    def date():
        now = links[-1].now() if links else 0.0
        return BEGAN + now + (seconds if now > 2.5 else 0.0)

    monkeypatch.setattr(time, "time", date)
    with registered("car", open_real):
        result = mikas("--port", "car:", "test", "sensors", "--json").object["result"]
    step, curve = result["steps"][0], result["curves"][0]
    for moment in (result["began"], result["ended"], step["began"], curve["times"][0]):
        assert moment == pytest.approx(BEGAN + seconds, abs=60)


def test_a_test_of_ones_own_takes_the_meter_beside_the_unit(mikas, tmp_path, monkeypatch):
    (tmp_path / "config" / "mikas" / "tests").mkdir(parents=True)
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "config"))
    (tmp_path / "config" / "mikas" / "tests" / "mixture.toml").write_text(MIXTURE, "utf-8")
    port = ("--port", "sim:?clock=simulated&scenario=warm-idle")
    refused = mikas(*port, "test", "mixture")
    assert refused.status == 2
    assert "needs LAMBDA, which no instrument of this run gives" in refused.err
    meter = ("--instrument", "aem=sim:")
    ran = mikas(*port, "test", "mixture", "--json", "--capture", "m.pcapng", *meter)
    assert ran.status == 0
    (number,) = ran.object["result"]["numbers"]
    assert number["value"] == pytest.approx(1, abs=0.3)
    again = mikas("test", "mixture", "--recording", "m.pcapng", "--json").object["result"]
    assert again["numbers"][0]["value"] == pytest.approx(number["value"], abs=0.05)
    assert mikas(*port, "log", "-o", "no.pcapng", "FREQ", "--duration", "5").status == 0
    without = mikas("test", "mixture", "--recording", "no.pcapng")
    assert "the recording has no values of LAMBDA" in without.err
