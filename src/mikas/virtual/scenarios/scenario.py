"""Scenarios as data: the car at the start, the driver's actions, and pinned values.

The shipped ones are the files in `scenarios/`; a user's own file has the same form
(docs/reference/scenarios.md). A field with a rule in its annotation is a key of the file
(`schema_of`). The engine model does not use the pinned parameters, faults, passports and memory
cells; the virtual unit does.
"""

from __future__ import annotations

import errno
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

from mikas.catalog.loading.fields import (
    ANY,
    TEXT,
    Schema,
    boolean,
    choice,
    made,
    read_table,
    schema_of,
    string,
)
from mikas.catalog.loading.source import CatalogFile, read_source
from mikas.errors import UsageError, system_error
from mikas.i18n import Text
from mikas.options import with_nearest
from mikas.virtual.memory import SIZES
from mikas.virtual.scenarios import form
from mikas.virtual.scenarios.timeline import ScenarioTimeline, Track

DEFAULT = "warm-idle"
ROOM = 20.0  # °C


@dataclass(frozen=True, slots=True)
class Start:
    """The car at second 0. `coolant_at_start`: °C when a running engine was started."""

    ambient: Annotated[float, form.number(-40, 50)] = ROOM
    coolant: Annotated[float, form.number(-40, 120)] = ROOM
    coolant_at_start: Annotated[float, form.number(-40, 120)] = ROOM
    running: Annotated[bool, boolean] = False
    # health: the lower, the deeper the dip while the starter turns
    battery: Annotated[float, form.number(0.3, 1)] = 1.0
    discharged: Annotated[float, form.number(0, 45)] = 0.0  # Ah taken from the battery


@dataclass(frozen=True, slots=True)
class Condition:
    """Wear and defects of the car that raise no fault number by themselves.

    The default is a sound car. The amounts are the model's, not a measurement.
    """

    alternator: Annotated[float, form.number(0, 1)] = 1.0  # share of its current; 0: it gives none
    regulator: Annotated[float, form.number(12, 18)] = 14.15  # V that it aims at
    starter: Annotated[float, form.number(0.2, 1)] = 1.0  # share of its torque
    # turns of the crankshaft until the petrol has its pressure again
    fuel_drained: Annotated[float, form.number(0, 60)] = 0.0
    thermostat: Annotated[float, form.number(0, 1)] = 0.0  # share that it stays open, cold or not
    radiator: Annotated[float, form.number(0, 1)] = 1.0  # share of its cooling
    # kg/h of air downstream of the throttle, past the meter, at full suction
    leak: Annotated[float, form.number(0, 30)] = 0.0
    # steps by which its set position must differ before it moves
    idle_valve: Annotated[float, form.number(0, 60)] = 0.0
    # share of the air that the idle valve lets through: deposits
    idle_passage: Annotated[float, form.number(0.1, 1)] = 1.0
    idle_advance: Annotated[float, form.number(-5, 40)] = 13.0  # ° aimed at while the engine idles
    # rpm that the program's idle speed lies above its usual one: another program, another unit
    idle_target: Annotated[float, form.number(-150, 300)] = 0.0
    air_meter: Annotated[float, form.number(0.3, 2)] = 1.0  # what it shows, against the true flow
    # kg/h that it shows too much, as with a bad ground
    air_meter_zero: Annotated[float, form.number(0, 20)] = 0.0
    # % of throttle between which it shows 0
    air_meter_loose: Annotated[tuple[float, float] | None, form.openings] = None
    coolant_sensor: Annotated[float, form.number(-40, 40)] = 0.0  # °C that it shows too much
    # % between which the throttle's sensor shows 0, and between which its plate can move
    throttle_dead: Annotated[tuple[float, float] | None, form.openings] = None
    throttle_stops: Annotated[tuple[float, float], form.openings] = (0.0, 100.0)
    # ° by which the engine knocks earlier: bad petrol, deposits
    knock: Annotated[float, form.number(0, 20)] = 0.0


TIMELINE: Schema = {
    "key": form.track(1, smooth=False),
    "starter": form.track(1, smooth=False),
    "load": form.track(100),
    "consumers": form.track(60),
    "throttle": form.track(100),
    "gear": form.track(5, smooth=False),
    "speed": form.track(200),
}
MEMORY: Schema = {space: {ANY: form.hex_bytes} for space in SIZES}


@dataclass(frozen=True, slots=True, kw_only=True)
class Scenario:
    """One scenario. `values`, `raw`, `faults`, `passports` and `memory` are pinned."""

    name: Annotated[str, string]
    text: Annotated[Text, TEXT]
    start: Annotated[Start, schema_of(Start)]
    timeline: Annotated[ScenarioTimeline, TIMELINE]
    condition: Annotated[Condition, schema_of(Condition)]
    values: Annotated[Mapping[str, float | bool], {ANY: form.pinned}]  # physical, by parameter
    raw: Annotated[Mapping[str, bytes], {ANY: form.hex_bytes}]  # by parameter
    faults: Annotated[frozenset[int], form.numbers] = frozenset()
    passports: Annotated[tuple[str, ...] | None, form.passports] = None  # eight
    memory: Annotated[Mapping[str, Mapping[int, bytes]], MEMORY]  # by space and address


FORM: Schema = {
    "name": string,
    "duration": form.number(1, 1e6),
    "after_end": choice(str, "hold", "loop"),
    "loop_from": form.number(0, 1e6),
    **schema_of(Scenario),
}


def load(path: Path) -> Scenario:
    """Return the scenario in a file. Raises `CatalogError`."""
    return from_source(read_source(path))


def from_source(source: CatalogFile) -> Scenario:
    """Return the scenario in `source`. Raises `CatalogError`."""
    keys = read_table(source, (), source.tables, FORM)
    memory = {
        space: {_address(source, space, key, data): data for key, data in cells.items()}
        for space, cells in keys.get("memory", {}).items()
    }
    _check_times(source, keys)
    name = keys.get("name") or Path(source.name).stem
    ambient = keys.get("start", {}).get("ambient", ROOM)
    start = {"ambient": ambient, "coolant": ambient, "coolant_at_start": ambient}
    return made(
        Scenario,
        keys,
        name=name,
        text=Text(**{"en": name, "ru": name} | keys.get("text", {})),
        start=Start(**start | keys.get("start", {})),
        timeline=_timeline(keys),
        condition=Condition(**keys.get("condition", {})),
        values={key.upper(): value for key, value in keys.get("values", {}).items()},
        raw={key.upper(): value for key, value in keys.get("raw", {}).items()},
        memory=memory,
    )


def find(name: str) -> Scenario:
    """Return the shipped scenario `name`, or that of the file `name`.

    Raises `UsageError` if neither exists, `CatalogError` for an invalid file.
    """
    if name in SCENARIOS:
        return SCENARIOS[name]
    if os.path.lexists(name):  # false, too, for what can be no file's name
        return load(Path(name))
    known = ", ".join(SCENARIOS)
    problem = Text(
        f"there is no scenario and no file “{name}”; scenarios: {known}",
        f"нет ни сценария, ни файла «{name}»; сценарии: {known}",
    )
    absent = UsageError(problem=with_nearest(problem, name, SCENARIOS))
    raise absent.caused_by(system_error(errno.ENOENT), name)


def _check_times(source: CatalogFile, keys: dict[str, Any]) -> None:
    duration = keys.get("duration")
    if duration is None:
        raise source.error(
            (),
            "has no `duration` (seconds that the timeline lasts)",
            "нет `duration` (длительность сценария в секундах)",
        )
    for name, points in keys.get("timeline", {}).items():
        if points.times[-1] > duration:
            problem = Text(
                f"has a point after the end; `duration` is {duration:g} s",
                f"точка после конца; `duration` — {duration:g} с",
            )
            raise source.wrong(("timeline", name), problem)
    if keys.get("loop_from", 0) > duration - 1:
        problem = Text(
            f"must be at least 1 s before the end, which is at {duration:g} s",
            f"должно быть хотя бы за 1 с до конца ({duration:g} с)",
        )
        raise source.wrong(("loop_from",), problem)


def _address(source: CatalogFile, space: str, key: str, data: bytes) -> int:
    try:
        address = int(key, 16)
    except ValueError:
        address = -1
    if 0 <= address <= SIZES[space] - len(data):
        return address
    last = SIZES[space] - 1
    problem = Text(
        f"must be an address in hex, and its bytes must end by {last:X}",
        f"нужен адрес в шестнадцатеричном виде, а байты — не дальше {last:X}",
    )
    raise source.wrong(("memory", space, key), problem)


def _timeline(keys: dict[str, Any]) -> ScenarioTimeline:
    tracks = {"key": _always(1)} | dict.fromkeys(("starter", "load", "consumers"), _always(0))
    return ScenarioTimeline(
        duration=keys["duration"],
        loops=keys.get("after_end") == "loop",
        loop_from=keys.get("loop_from", 0.0),
        **(tracks | keys.get("timeline", {})),
    )


def _always(value: float) -> Track:
    return Track((0.0,), (value,), smooth=False)


def _shipped() -> dict[str, Scenario]:
    files = Path(__file__).parent.glob("*.toml")
    scenarios = {path.stem: load(path) for path in sorted(files)}
    return {DEFAULT: scenarios.pop(DEFAULT)} | scenarios


SCENARIOS: Mapping[str, Scenario] = _shipped()
