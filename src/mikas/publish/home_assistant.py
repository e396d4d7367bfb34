"""The car as a device of Home Assistant, by its MQTT discovery of devices (2024.12 or newer).

One retained message names every entity, its topic and the template that takes its value from our
JSON. Home Assistant has one name for each entity: it is in the language of the command.

What the unit gives is available only while the program runs *and* the line is sampling. A value
that was not read is JSON's null, which the template makes `None`: the entity is then “unknown”.
`expire_after` is for a broker that keeps the connection and gets nothing more.
"""

from __future__ import annotations

import itertools
import json
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Final

from mikas.catalog import Derived, InstrumentChannel, Level, Parameter
from mikas.cleaning import clean_line
from mikas.i18n import Language, Text
from mikas.publish.outbox import Message, MessageKind, compact
from mikas.publish.publication import STATES, Publication
from mikas.publish.topics import Topics, check_topic, identifier
from mikas.publish.values import unit_of
from mikas.sampling.events import STATE_TEXTS, LineState, UnitFound
from mikas.sampling.fault_watch import MINERR

DISCOVERY_PREFIX: Final = "homeassistant"
_URL: Final = "https://github.com/mikas-diagnostics/mikas"
_EXPIRES: Final = 30.0  # s without a message, or five intervals if these are longer


_MOST_ENTITIES: Final = 1000
_KEY: Final = re.compile("[A-Za-z0-9_-]{1,200}")
_PLATFORMS: Final = ("sensor", "binary_sensor")


_SPELLINGS: Final = {"l": "L", "l/h": "L/h", "° crank": "°"}
_CLASSES: Final = {
    "°C": "temperature",
    **dict.fromkeys(("V", "mV"), "voltage"),
    **dict.fromkeys(("A", "mA"), "current"),
    "Hz": "frequency",
    **dict.fromkeys(("ms", "s", "h"), "duration"),
    **dict.fromkeys(("Pa", "hPa", "kPa", "mbar", "bar"), "pressure"),
    "km/h": "speed",
    "km": "distance",
    "kW": "power",
    "l": "volume",
}
"""The class of sensors, by the catalog's unit. Another unit, and for versions before 2025.7 a flow
rate, has none."""

_SUMS: Final = ("volume", "distance", "duration")  # the classes that a sum may have
_MOST_NUMBERS: Final = 50  # of faults; a state has room for 255 characters

_TEXTS: Final = {
    "state": Text("Line", "Линия"),
    "fault": Text("Faults stored", "Есть ошибки в памяти"),
    "faults": Text("Fault numbers", "Номера ошибок"),
    "alarm": Text("Alarm", "Тревога"),
    "none": Text("none", "нет"),
}
_LINE_STATES: Final = (*STATES.values(), *STATE_TEXTS)


@dataclass(frozen=True, slots=True)
class HomeAssistant:
    """Makes the discovery of the car of a `publication`. `name`: of the device.

    `version`: of mikas. `gone`: the entities of an earlier discovery, with their platforms alone:
    Home Assistant deletes those that are not in this one. Raises `UsageError` for a `prefix` that
    is no topic.
    """

    publication: Publication
    name: str
    version: str
    language: Language = "en"
    prefix: str = DISCOVERY_PREFIX
    gone: Mapping[str, dict[str, str]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        check_topic(self.prefix)

    @property
    def topics(self) -> Topics:
        """The topics of the publication."""
        return self.publication.topics

    @property
    def topic(self) -> str:
        """The topic of the discovery."""
        return discovery_topic(self.prefix, self.topics)

    def discovery(self, unit: UnitFound | None = None) -> Message:
        """Return the message that makes the device; with `unit`, its model and passport."""
        payload = compact(
            {
                "device": self._device(unit),
                "origin": {"name": "mikas", "sw_version": self.version, "support_url": _URL},
                "components": {**self.gone, **dict(self._components())},
                "qos": 1,
            }
        )
        return Message(self.topic, payload, MessageKind.RETAINED)

    def after(self, earlier: bytes) -> HomeAssistant:
        """Return the same, with the entities of an `earlier` discovery that are not in this one.

        Otherwise they would stay in Home Assistant, without a value, when fewer names are
        published.
        """
        return replace(self, gone=_platforms(earlier))

    def _device(self, unit: UnitFound | None) -> dict[str, Any]:
        device: dict[str, Any] = {
            "identifiers": [f"mikas_{self.topics.identifier}"],
            "name": self.name,
            "manufacturer": "Mikas",
        }
        if unit is not None and unit.model is not None:
            device["model"] = unit.model.to(self.language)
        if unit is not None and unit.passport is not None:
            program = " ".join(filter(None, unit.passport.program))
            if clean_line(program).strip():
                device["sw_version"] = clean_line(program).strip()
        return device

    def _components(self) -> Iterator[tuple[str, dict[str, Any]]]:
        for channel in self.publication.channels:
            yield self._entity(channel.name, self._of_channel(channel))
        for key, config in self._of_line():
            yield self._entity(key, {"name": _TEXTS[key].to(self.language), **config})

    def _entity(self, key: str, config: dict[str, Any]) -> tuple[str, dict[str, Any]]:
        own, availability = identifier(key), [{"topic": self.topics.availability}]
        if key != "state":  # which is known whenever the program runs
            sampling = f"'online' if value_json.state == '{LineState.SAMPLING}' else 'offline'"
            template = f"{{{{ {sampling} }}}}"
            availability.append({"topic": self.topics.state, "value_template": template})
        named = {
            "unique_id": f"mikas_{self.topics.identifier}_{own}",
            "default_entity_id": f"{config['platform']}.{_entity(self.topics.base, key)}",
            "availability": availability,
            "availability_mode": "all",
        }
        return own, {**config, **named}

    # The entities

    def _of_channel(self, channel: Parameter | Derived | InstrumentChannel) -> dict[str, Any]:
        value = f"value_json['values'].get({json.dumps(channel.name)})"
        config: dict[str, Any] = {
            "name": channel.text.to(self.language),
            "state_topic": self.topics.values,
            "expire_after": round(max(_EXPIRES, 5 * self.publication.every)),
        }
        if channel.is_flag:
            config["platform"] = "binary_sensor"
            config["value_template"] = (
                f"{{{{ {{true: 'ON', false: 'OFF'}}.get({value}, 'None') }}}}"
            )
            lamp = channel.lamp if isinstance(channel, Parameter) else None
            if lamp is not None and lamp.trouble is not Level.NONE:
                config["device_class"] = "problem"
            return config
        config["platform"] = "sensor"
        config["value_template"] = f"{{{{ {value} }}}}"
        config["suggested_display_precision"] = channel.decimals
        sums = isinstance(channel, Derived) and channel.accumulates
        if channel.name != MINERR:  # a number of a fault has no average
            config["state_class"] = "total_increasing" if sums else "measurement"
        key, text = unit_of(channel, self.publication.interpretation)
        if key:
            kind = _CLASSES.get(key)
            local = key if kind is not None else text.to(self.language)
            config["unit_of_measurement"] = _SPELLINGS.get(key, local)
            if sums and kind not in _SUMS:
                kind = None
            elif kind == "volume" and not sums:
                kind = "volume_storage"
            if kind is not None:
                config["device_class"] = kind
        return config

    def _of_line(self) -> Iterator[tuple[str, dict[str, Any]]]:
        """Yield the entities of the faults, of the alarms and of the line, by `_TEXTS`."""
        problem = {"platform": "binary_sensor", "device_class": "problem"}
        stored = "value_json.faults | rejectattr('informational') | list"
        is_stored = _if_current(f"'ON' if {stored} else 'OFF'")
        yield "fault", {**problem, "state_topic": self.topics.faults, "value_template": is_stored}
        none = _TEXTS["none"].to(self.language)
        codes = "(value_json.faults | map(attribute='code') | list)"
        more = f"(' …' if value_json.faults | length > {_MOST_NUMBERS} else '')"
        numbers = f"({codes}[:{_MOST_NUMBERS}] | join(', ') ~ {more}) or '{none}'"
        shown = _with_attributes(self.topics.faults, _if_current(numbers))
        yield "faults", {"platform": "sensor", "icon": "mdi:engine", **shown}
        is_on = _if_current("'ON' if value_json.alarms else 'OFF'")
        yield "alarm", {**problem, **_with_attributes(self.topics.alarms, is_on)}
        yield (
            "state",
            {
                "platform": "sensor",
                "device_class": "enum",
                "options": [text.to(self.language) for text in _LINE_STATES],
                "entity_category": "diagnostic",
                **_with_attributes(self.topics.state, f"{{{{ value_json.text.{self.language} }}}}"),
            },
        )


def discovery_topic(prefix: str, topics: Topics) -> str:
    """Return the topic of the discovery of the car under `topics`."""
    return f"{prefix}/device/{topics.identifier}/config"


def _platforms(discovery: bytes) -> dict[str, dict[str, str]]:
    """Return the entities of a discovery, which anybody may have sent, with no more than that."""
    try:
        components = json.loads(discovery)["components"].items()
    except (ValueError, RecursionError, TypeError, KeyError, AttributeError):
        return {}
    return {
        key: {"platform": each["platform"]}
        for key, each in itertools.islice(components, _MOST_ENTITIES)
        if _KEY.fullmatch(key)
        and isinstance(each, dict)
        and each.get("platform") in _PLATFORMS
        and len(each) > 1  # else it is one that was deleted
    }


def _entity(*words: str) -> str:
    """Return words as in the name of an entity."""
    return re.sub("[^a-z0-9]+", "_", " ".join(words).lower()).strip("_")


def _if_current(expression: str) -> str:
    return f"{{{{ ({expression}) if value_json.current else 'None' }}}}"


def _with_attributes(topic: str, template: str) -> dict[str, str]:
    """Return the keys of an entity that shows a topic, and has all of it as attributes."""
    return {"state_topic": topic, "value_template": template, "json_attributes_topic": topic}
