"""The discovery of Home Assistant: its templates on our own messages, rendered as it does.

By hand the whole was tried with Home Assistant 2025.4; the units and classes below are its own.
"""

from __future__ import annotations

import json
import re
from functools import cache

import pytest
from hypothesis import given
from hypothesis import strategies as st
from jinja2 import StrictUndefined, Template
from jinja2.sandbox import SandboxedEnvironment
from publication_harness import CATALOG, TOPICS, Published, content, drive, publication

from mikas.catalog import load
from mikas.client.identity import Passport
from mikas.i18n import Text
from mikas.publish.home_assistant import HomeAssistant, discovery_topic
from mikas.publish.outbox import MessageKind
from mikas.publish.publication import Publication
from mikas.sampling.events import UnitFound

NAMES = ("TWAT", "FREQ", "RXX", "FUEL_FLOW", "FUEL_USED", "MINERR", "0x3F:2", "UOZ", "INJ", "RDET")
KEY_OFF = "&scenario=key-off&faults=12,13"  # the ignition is off from 20 s to 35 s
CLASSES = {  # Home Assistant's units by class of sensor (components/sensor/const.py), ours of them
    "temperature": {"°C", "°F", "K"},
    "voltage": {"V", "mV"},
    "current": {"A", "mA"},
    "frequency": {"Hz", "kHz"},
    "duration": {"d", "h", "min", "s", "ms"},
    "pressure": {"Pa", "hPa", "kPa", "bar", "mbar"},
    "speed": {"km/h", "m/s"},
    "distance": {"km", "m"},
    "power": {"kW", "W"},
    "volume": {"L", "mL"},
    "volume_storage": {"L", "mL"},
}
SUMS = {"total", "total_increasing"}
STATE_CLASSES = {  # the state classes that go with a class (DEVICE_CLASS_STATE_CLASSES there)
    "duration": {"measurement"} | SUMS, "distance": {"measurement"} | SUMS, "volume": SUMS,
}  # fmt: skip
LONGEST_STATE = 255  # characters; a longer one makes the entity unknown


def made(*names: str, **settings: object) -> HomeAssistant:
    options = {key: settings.pop(key) for key in ("every", "interpretation") if key in settings}
    published = publication(*(names or NAMES), **options)
    return HomeAssistant(published, "Volga", "1.2.3", **settings)


def components(home: HomeAssistant) -> dict[str, dict]:
    return content(home.discovery())["components"]


def rendered(template: str, message: dict) -> str:
    """What Home Assistant makes of a message; `None` is “unknown” to it."""
    return compiled(template).render(value_json=message, value=json.dumps(message))


@cache
def compiled(template: str) -> Template:
    return SandboxedEnvironment(undefined=StrictUndefined).from_string(template)


def test_the_device_is_one_retained_message_with_an_origin():
    message = made().discovery()
    assert message.topic == "homeassistant/device/garage--volga/config"
    assert (message.kind, message.qos) == (MessageKind.RETAINED, 1)
    whole = content(message)
    assert whole["device"]["identifiers"] == ["mikas_garage--volga"]
    assert whole["origin"]["sw_version"] == "1.2.3"
    assert len(message.payload) < 64 << 10
    assert made(prefix="ha/x").topic == "ha/x/device/garage--volga/config"


def test_the_unit_gives_the_device_its_model_and_program():
    passport = Passport(("П\x1b1", "", None), (None,) * 5)
    unit = UnitFound(1.0, 0x0A, passport, model=Text("Mikas 7.1", "Микас 7.1"))
    device = content(made(language="ru").discovery(unit))["device"]
    assert (device["model"], device["sw_version"]) == ("Микас 7.1", "П\ufffd1")
    nothing = content(made().discovery(UnitFound(1.0, None, None)))["device"]
    assert not {"model", "sw_version"} & set(nothing)


def test_every_entity_has_what_its_platform_needs():
    for catalog_names in (NAMES, [it.name for it in CATALOG.parameters], list(CATALOG.derived)):
        for language in ("en", "ru"):
            found = components(made(*catalog_names, language=language))
            assert len(found) == len(catalog_names) + 4
            for key, entity in found.items():
                assert re.fullmatch("[A-Za-z0-9_-]+", key)
                assert entity["unique_id"] == f"mikas_garage--volga_{key}"
                assert re.fullmatch("(binary_)?sensor[.][a-z0-9_]+", entity["default_entity_id"])
                assert entity["name"]
                assert entity["state_topic"].startswith("garage/volga/")
                unit, kind = entity.get("unit_of_measurement"), entity.get("device_class")
                if entity["platform"] == "sensor" and kind not in (None, "enum"):
                    assert unit in CLASSES[kind]
                    agrees(entity)
                assert kind != "enum" or "state_class" not in entity
            assert len({each["unique_id"] for each in found.values()}) == len(found)


def agrees(entity: dict) -> None:
    """Check that the class of a sensor has such states: Home Assistant warns of others."""
    kind = entity.get("device_class")
    assert kind is None or entity["state_class"] in STATE_CLASSES.get(kind, {"measurement"})


def test_a_level_in_litres_is_no_sum_and_a_sum_has_a_class_of_sums(tmp_path):
    own = tmp_path / "own.toml"
    own.write_text(
        '[parameter.TANK]\ncode = 0x33\nsize = 1\nunit = "l"\ntext = { en = "Tank", ru = "Бак" }\n'
        '[derived.HEAT]\nformula = "TWAT"\naccumulates = true\nunit = "°C"\n'
        'text = { en = "Heat", ru = "Тепло" }\n',
        "utf-8",
    )
    catalog = load(own)
    names = ("TANK", "HEAT", "FUEL_USED")
    published = Publication(TOPICS, catalog, [*map(catalog.channel, names)])
    found = components(HomeAssistant(published, "Volga", "1"))
    assert (found["TANK"]["device_class"], found["TANK"]["state_class"]) == (
        "volume_storage",
        "measurement",
    )
    assert found["HEAT"]["state_class"] == "total_increasing"
    for name in names:
        agrees(found[name])


def test_very_many_faults_are_as_many_as_a_state_has_room_for():
    template = components(made())["faults"]["value_template"]
    codes = range(100, 228)  # a response has no more
    message = {"current": True, "faults": [{"code": code} for code in codes]}
    shown = rendered(template, message)
    assert shown.startswith("100, 101, ")
    assert shown.endswith(", 149 …")
    assert len(shown) <= LONGEST_STATE


def test_units_and_classes_are_in_home_assistants_spelling():
    found = components(made())
    assert found["TWAT"]["device_class"] == "temperature"
    assert found["TWAT"]["state_class"] == "measurement"
    assert found["INJ"]["device_class"] == "duration"
    assert found["FUEL_FLOW"]["unit_of_measurement"] == "L/h"
    assert (found["FUEL_USED"]["state_class"], found["FUEL_USED"]["unit_of_measurement"]) == (
        "total_increasing", "L",
    )  # fmt: skip
    assert found["UOZ"]["unit_of_measurement"] == "°"
    assert "state_class" not in found["MINERR"]
    assert found["RDET"]["device_class"] == "problem"
    literal = components(made("FREQ", interpretation="literal"))
    assert literal["FREQ"]["unit_of_measurement"] == "1/s"
    assert components(made("FREQ", language="ru"))["FREQ"]["unit_of_measurement"] == "об/мин"


def test_names_are_in_the_language():
    assert components(made("TWAT"))["TWAT"]["name"] == CATALOG.channel("TWAT").text.en
    assert (
        components(made("TWAT", language="ru"))["TWAT"]["name"] == CATALOG.channel("TWAT").text.ru
    )


@pytest.fixture(scope="module")
def outage() -> Published:
    made = publication(*NAMES)
    return Published.of(drive(KEY_OFF, *NAMES, seconds=45, rate=4.0), made)


def test_templates_give_the_values_and_none_for_null(outage):
    found, empty = components(made()), 0
    for message in outage.under("values"):
        for name in NAMES:
            value = message["values"][name]
            entity = found["0x3F-3A2" if name == "0x3F:2" else name]
            wanted = {None: "None", True: "ON", False: "OFF"}.get(value, str(value))
            wanted = str(value) if value in (0, 1) and entity["platform"] == "sensor" else wanted
            assert rendered(entity["value_template"], message) == wanted
            empty += value is None
    assert empty
    # An entity that is not published any more becomes unknown, not the last value.
    assert rendered(found["TWAT"]["value_template"], {"values": {}}) == "None"


def test_entities_of_the_unit_are_available_only_while_it_is_sampled(outage):
    found = components(made())
    running, sampling = found["TWAT"]["availability"]
    assert running == {"topic": "garage/volga/availability"}
    assert found["TWAT"]["availability_mode"] == "all"
    states = [rendered(sampling["value_template"], each) for each in outage.under("state")]
    assert states[:3] == ["offline", "online", "offline"]  # answers, sampling, ignition off
    assert found["state"]["availability"] == [running]
    words = [rendered(found["state"]["value_template"], each) for each in outage.under("state")]
    assert set(words) <= set(found["state"]["options"])
    assert len(set(found["state"]["options"])) == len(found["state"]["options"])


def test_faults_and_alarms_are_unknown_while_they_are_not_current(outage):
    found = components(made())
    for message in outage.under("faults"):
        known = message["current"]
        assert rendered(found["faults"]["value_template"], message) == (
            "12, 13" if known else "None"
        )
        assert rendered(found["fault"]["value_template"], message) == ("ON" if known else "None")
    nothing = {"current": True, "count": 0, "faults": []}
    message_only = {"current": True, "faults": [{"code": 12, "informational": True}]}
    assert rendered(found["faults"]["value_template"], nothing) == "none"
    assert rendered(components(made(language="ru"))["faults"]["value_template"], nothing) == "нет"
    assert rendered(found["fault"]["value_template"], nothing) == "OFF"
    assert rendered(found["fault"]["value_template"], message_only) == "OFF"  # 12 is no fault
    unknown = content(publication("FREQ").begin()[1])
    assert rendered(found["fault"]["value_template"], unknown) == "None"
    alarm = found["alarm"]["value_template"]
    assert rendered(alarm, {"current": True, "alarms": []}) == "OFF"
    assert rendered(alarm, {"current": True, "alarms": [{}]}) == "ON"
    assert rendered(alarm, {"current": False, "alarms": [{}]}) == "None"


def test_values_expire_later_than_they_come():
    assert components(made("FREQ"))["FREQ"]["expire_after"] == 30
    assert components(made("FREQ", every=60.0))["FREQ"]["expire_after"] == 300


def test_entities_of_names_that_are_not_published_any_more_are_deleted():
    before = made("TWAT", "FREQ", "RXX")
    now = made("FREQ").after(before.discovery().payload)
    found = components(now)
    assert found["TWAT"] == {"platform": "sensor"}
    assert found["RXX"] == {"platform": "binary_sensor"}
    assert found["FREQ"] == components(before)["FREQ"]
    again = made("FREQ").after(now.discovery().payload)
    assert "TWAT" not in components(again)
    back = made("TWAT").after(now.discovery().payload)
    assert components(back)["TWAT"] == components(before)["TWAT"]


JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.text(max_size=5),
    lambda inner: (
        st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=9), inner, max_size=3)
    ),
)


@given(st.binary(max_size=60) | st.builds(lambda x: json.dumps({"components": x}).encode(), JSON))
def test_what_anybody_left_there_does_no_harm(earlier):
    found = components(made("FREQ").after(earlier))
    assert found["FREQ"] == components(made("FREQ"))["FREQ"]
    assert all(entity["platform"] in ("sensor", "binary_sensor") for entity in found.values())


def test_a_users_own_unit_and_text_are_taken_as_they_are(tmp_path):
    own = tmp_path / "own.toml"
    own.write_text(
        '[unit.kPa]\ntext = { en = "kPa", ru = "кПа" }\n'
        '[unit.xy]\ntext = { en = "x/y", ru = "х/у" }\n'
        '[parameter.BOOST]\ncode = 0x33\nsize = 1\nunit = "kPa"\n'
        'text = { en = "{{ 1/0 }} \\"\'", ru = "Наддув" }\n'
        '[parameter.ODD]\ncode = 0x34\nsize = 1\nunit = "xy"\ntext = { en = "Odd", ru = "Х" }\n',
        "utf-8",
    )
    catalog = load(own)
    published = Publication(TOPICS, catalog, [catalog.channel("BOOST"), catalog.channel("ODD")])
    found = components(HomeAssistant(published, "Volga", "1", language="ru"))
    assert (found["BOOST"]["device_class"], found["BOOST"]["unit_of_measurement"]) == (
        "pressure",
        "kPa",
    )
    assert found["ODD"]["unit_of_measurement"] == "х/у"
    assert rendered(found["BOOST"]["value_template"], {"values": {"BOOST": 7}}) == "7"


def test_the_topic_is_that_of_the_removal():
    assert made(prefix="ha").topic == discovery_topic("ha", TOPICS)
