"""A car that leaves the state that a step needs: its figures are of that state all the same."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from math import inf
from pathlib import Path
from typing import cast

from bench.blind_units import DrivenTimeline, Driver
from survey_harness import by_name

from mikas.catalog import shipped
from mikas.client.connecting import ConnectionOptions, open_ecu
from mikas.i18n import Text
from mikas.link.virtual import VirtualLink
from mikas.survey import Survey, SurveyFile, SurveyOptions, SurveyVerdict
from mikas.survey.steps.step import SurveyStep
from mikas.virtual.build import MODELS, wired
from mikas.virtual.cars import EngineCar
from mikas.virtual.model.engine import Engine
from mikas.virtual.responder import Identity, Responder
from mikas.virtual.scenarios.scenario import SCENARIOS, Start
from mikas.virtual.scenarios.timeline import Inputs, ScenarioTimeline

_OFF = 2.0  # s that the key is turned off


class KeyTimeline(DrivenTimeline):
    """A driver who also turns the key off, for two seconds each time."""

    def __init__(self) -> None:
        super().__init__()
        self.key_off: list[float] = []

    def at(self, time: float) -> Inputs:
        return super().at(time)._replace(key=self.key_on(time))

    def key_on(self, time: float) -> bool:
        return not any(begin <= time < begin + _OFF for begin in self.key_off)

    def next_key_change(self, after: float) -> float:
        edges = [edge for begin in self.key_off for edge in (begin, begin + _OFF)]
        return min((edge for edge in edges if edge > after), default=inf)


@dataclass
class Person(Driver):
    """Does what is said, and `mischief` once, at the begin of the step of that name."""

    mischief: dict[str, Callable[[Person], None]] = field(default_factory=dict)
    said: list[str] = field(default_factory=list)
    steps: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        super().__init__()
        self.timeline: KeyTimeline = KeyTimeline()

    def say(self, text: Text, /) -> None:
        self.said.append(text.en)
        super().say(text)
        if "idle; do not touch" in text.en:
            self.timeline.starts.append(self.now() + 3.0)

    def on_step(self, step: SurveyStep, *_: int) -> None:
        self.steps.append(step.name)
        self.mischief.pop(step.name, lambda _: None)(self)


def run_with(person: Person, folder: Path, **settings: str) -> Survey:
    """Surveys a virtual car that this person drives."""
    start = Start(ambient=20, coolant=82, coolant_at_start=20)
    timeline = cast("ScenarioTimeline", person.timeline)
    scenario = replace(SCENARIOS["warm-idle"], start=start, timeline=timeline)
    car = EngineCar(Engine(scenario, 1), shipped(), faults=[])
    link = VirtualLink(wired(Responder(car, Identity(MODELS["7.1"], ("",) * 8)), settings))
    person.now = link.now
    with open_ecu(link, ConnectionOptions()) as ecu:
        survey = Survey(ecu, folder / "unit.zip", SurveyOptions(), person)
        survey.run(person.on_step)
    return survey


def surveyed_with(person: Person, folder: Path, **settings: str) -> SurveyFile:
    return run_with(person, folder, **settings).save()


def key_off_in(seconds: float) -> Callable[[Person], None]:
    return lambda person: person.timeline.key_off.append(person.now() + seconds)


def released_in(seconds: float) -> Callable[[Person], None]:
    return lambda person: person.timeline.pedal.append((person.now() + seconds, 0.0))


def test_an_engine_that_stalls_at_idle_has_its_strokes_counted_once_it_runs_again(tmp_path):
    """Else silence of a standing engine would be a unit without 7F–83."""
    person = Person({"strokes": key_off_in(3.0)})
    found = surveyed_with(person, tmp_path)
    assert person.steps.count("strokes") == 2
    assert found.unit["strokes"].keys() == {"7F", "80", "81", "82", "83"}
    assert not {"7F", "80", "81", "82", "83"} & set(found.unit["missing"])


def test_a_pedal_that_is_released_early_is_asked_for_again(tmp_path):
    person = Person({"samples_raised": released_in(0.3)})
    found = surveyed_with(person, tmp_path)
    assert person.steps.count("samples_raised") == 2
    assert sum("Hold the engine" in text for text in person.said) >= 2
    assert by_name(found)["moves"].value["29"] == "rpm"


def test_an_engine_started_too_early_is_stopped_before_the_next_step(tmp_path):
    """The codes found meanwhile stay; what a standing engine shows is not of a running one."""

    def start(person: Person) -> None:
        person.timeline.starts.append(person.now() + 10.0)

    class Stops(Person):
        def say(self, text: Text, /) -> None:
            super().say(text)
            if "engine OFF" in text.en and self.steps:
                self.timeline.key_off.append(self.now() + 4.0)

    person = Stops({"codes": start})
    found = surveyed_with(person, tmp_path)
    assert person.steps.count("codes") == 1
    assert found.measured["streams"]["standing"]["rpm"] == 0
    assert set(found.measured["samples"]["standing"]["29"]) == {"00"}
    assert by_name(found)["freq"].value["cranking"]


def test_a_car_that_never_stays_so_leaves_the_rest_of_that_state_open(tmp_path):
    def again(person: Person) -> None:
        key_off_in(3.0)(person)
        person.mischief["strokes"] = again

    found = surveyed_with(Person({"strokes": again}), tmp_path)
    answers = by_name(found)
    assert answers["strokes"].verdict is SurveyVerdict.NOT_ASKED
    assert "did not stay so" in answers["strokes"].text.en
    assert not {"7F", "83"} & set(found.unit["missing"])


def test_what_was_skipped_is_asked_for_by_the_next_run(tmp_path):
    """A pedal that was not held: the same command goes on with what is left."""

    class Lazy(Person):
        def say(self, text: Text, /) -> None:
            if "Hold" not in text.en:
                super().say(text)

    assert "raised" in run_with(Lazy(), tmp_path).measured["skipped"]
    person = Person()
    person.timeline.starts.append(1.0)
    again = run_with(person, tmp_path)
    assert again.measured["skipped"] == {}
    assert {"samples_raised", "strokes_raised"} <= set(person.steps)
    assert "codes" not in person.steps


def test_a_unit_with_freqx_alone_shows_that_its_engine_runs(tmp_path):
    found = surveyed_with(Person(), tmp_path, lacking="29")
    assert found.measured["seconds"]["cranking"] < 30
    assert found.measured["cranking"]
