"""Values of instruments beside the unit, as MQTT messages: as old as they are, or none."""

from __future__ import annotations

import json

from publication_harness import CATALOG, TOPICS, content

import mikas
from mikas.i18n import Text
from mikas.instruments.reading import InstrumentReading, InstrumentState
from mikas.publish.home_assistant import HomeAssistant
from mikas.publish.publication import Publication
from mikas.publish.values import LatestValues
from mikas.sampling.events import Sampled, StateChanged
from mikas.sampling.instrument_changes import InstrumentChanged
from mikas.sampling.states import LineState

METER = CATALOG.instruments["LAMBDA"]


def published(**options: object) -> Publication:
    return Publication(TOPICS, CATALOG, [CATALOG.channel("TWAT"), METER], every=0.1, **options)


def sample(time: float, value: float | None, age: float = 0.0) -> Sampled:
    given = {} if value is None else {"LAMBDA": InstrumentReading(METER, value, time - age)}
    return Sampled(time, {}, {}, {}, given)


def values_of(made: Publication, event: object) -> dict:
    (message,) = [it for it in made.messages_of(event) if it.topic == TOPICS.values]
    return content(message)


def test_a_value_is_there_as_long_as_the_sample_has_it() -> None:
    made = published()
    first = values_of(made, sample(10.0, 0.98))
    assert (first["values"], first["ages"]) == ({"TWAT": None, "LAMBDA": 0.98}, {})
    old = values_of(made, sample(10.2, 0.98, age=2.4))  # a receiver's value may be so old
    assert (old["values"]["LAMBDA"], old["ages"]) == (0.98, {"LAMBDA": 2.4})
    assert values_of(made, sample(10.4, None))["values"]["LAMBDA"] is None
    assert values_of(made, sample(10.6, 1.01))["values"]["LAMBDA"] == 1.01
    broken = StateChanged(10.7, LineState.NO_PORT)
    assert values_of(made, broken)["values"] == {"TWAT": None, "LAMBDA": None}


def test_of_the_units_channels_nothing_is_taken_back() -> None:
    latest = LatestValues(["TWAT", "LAMBDA"], ["LAMBDA"])
    latest.add_sample(1.0, {"TWAT": 80, "LAMBDA": 1.0})
    latest.add_sample(1.5, {})
    assert latest.at(1.5).values == {"TWAT": 80, "LAMBDA": None}


def test_channels_every_sample_and_each_change_of_an_instrument() -> None:
    made = published(samples=True, each=True)
    (channels,) = [content(it) for it in made.begin() if it.topic == TOPICS.channels]
    assert channels["channels"][1] == {
        "name": "LAMBDA", "unit": "λ", "text": METER.text._asdict(), "flag": False,
    }  # fmt: skip
    messages = {it.topic: it.payload for it in made.messages_of(sample(10.0, 0.98))}
    assert messages[TOPICS.value("LAMBDA")] == b"0.98"
    rows = json.loads(messages[TOPICS.samples])
    assert (rows["names"], rows["samples"]) == (["TWAT", "LAMBDA"], [[10.0, None, 0.98]])
    words = Text("the instrument aem is not there", "прибора aem нет")
    lost = InstrumentChanged(11.0, "aem", InstrumentState.LOST, words, Text("gone", "нет"))
    (message,) = made.messages_of(lost)
    told = content(message)
    assert (message.topic, told["kind"], told["state"]) == (TOPICS.event, "instrument", "lost")
    assert (told["name"], told["reason"]["ru"]) == ("aem", "нет")


def test_home_assistant_has_an_entity_of_it() -> None:
    home = HomeAssistant(published(), "Volga", "1.2.3")
    entity = content(home.discovery())["components"]["LAMBDA"]
    assert (entity["platform"], entity["unit_of_measurement"]) == ("sensor", "λ")
    assert (entity["state_class"], entity["suggested_display_precision"]) == ("measurement", 3)


def test_a_sessions_values_are_those_of_the_virtual_meter() -> None:
    url = "sim:?clock=simulated&seed=3&scenario=city"
    with mikas.session(
        url, ["FREQ", "VALF"], duration=20, rate=5, instruments=("aem=sim:", "roof:nmea=sim:")
    ) as session:
        made = Publication(TOPICS, CATALOG, session.channels)
        found = [content(it) for event in session.events() for it in made.messages_of(event)]
    last = [it["values"] for it in found if "values" in it][-1]
    assert list(last)[:4] == ["FREQ", "VALF", "LAMBDA", "AFR"]
    assert abs(last["LAMBDA"] - last["VALF"]) < 0.3
    assert last["GPS_LAT_ROOF"] > 56
    kinds = [it["state"] for it in found if it.get("kind") == "instrument"]
    assert kinds == ["connected", "connected", "values", "values"]
