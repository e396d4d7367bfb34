"""Scenarios as data: the car at the start, the driver's actions, and pinned values.

The shipped ones are the files in `scenarios/`; a user's own file has the same form
(docs/reference/scenarios.md). The engine model does not use the pinned parameters, faults,
passports and memory cells; the virtual unit does.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from mikas.catalog.loading.source import CatalogFile, read_source
from mikas.errors import usage_error
from mikas.i18n import Text
from mikas.virtual.scenarios.form import read_form
from mikas.virtual.scenarios.timeline import ScenarioTimeline, Track

DEFAULT = "warm-idle"
ROOM = 20.0  # °C


@dataclass(frozen=True, slots=True)
class Start:
    """The car at second 0. `coolant_at_start`: °C when a running engine was started."""

    ambient: float = ROOM
    coolant: float = ROOM
    coolant_at_start: float = ROOM
    running: bool = False
    battery: float = 1.0  # health: the lower, the deeper the dip while the starter turns
    discharged: float = 0.0  # Ah taken from the battery


@dataclass(frozen=True, slots=True)
class Condition:
    """Wear and defects of the car that raise no fault number by themselves.

    The default is a sound car. The amounts are the model's, not a measurement.
    """

    alternator: float = 1.0  # share of its current; 0: it gives nothing
    regulator: float = 14.15  # V that it aims at
    starter: float = 1.0  # share of its torque
    fuel_drained: float = 0.0  # turns of the crankshaft until the petrol has its pressure again
    thermostat: float = 0.0  # share that it stays open, cold or not
    radiator: float = 1.0  # share of its cooling
    leak: float = 0.0  # kg/h of air downstream of the throttle, past the meter, at full suction
    idle_valve: float = 0.0  # steps by which its set position must differ before it moves
    idle_passage: float = 1.0  # share of the air that the idle valve lets through: deposits
    idle_advance: float = 13.0  # ° that the program aims at while the engine idles
    air_meter: float = 1.0  # what it shows, against the true flow
    air_meter_zero: float = 0.0  # kg/h that it shows too much, as with a bad ground
    air_meter_loose: tuple[float, float] | None = None  # % of throttle between which it shows 0
    coolant_sensor: float = 0.0  # °C that it shows too much
    throttle_dead: tuple[float, float] | None = None  # % between which its sensor shows 0
    throttle_stops: tuple[float, float] = (0.0, 100.0)  # % between which its plate can move
    knock: float = 0.0  # ° by which the engine knocks earlier: bad petrol, deposits


SOUND = Condition()


@dataclass(frozen=True, slots=True)
class Scenario:
    """One scenario. `values`, `raw`, `faults`, `passports` and `memory` are pinned."""

    name: str
    text: Text
    start: Start
    timeline: ScenarioTimeline
    condition: Condition = SOUND
    values: Mapping[str, float | bool] = field(default_factory=dict)  # physical, by parameter
    raw: Mapping[str, bytes] = field(default_factory=dict)  # by parameter
    faults: frozenset[int] = frozenset()
    passports: tuple[str, ...] | None = None  # eight
    memory: Mapping[str, Mapping[int, bytes]] = field(default_factory=dict)  # space, address


def load(path: Path) -> Scenario:
    """Return the scenario in a file. Raises `CatalogError`."""
    return from_source(read_source(path))


def from_source(source: CatalogFile) -> Scenario:
    """Return the scenario in `source`. Raises `CatalogError`."""
    form = read_form(source)
    name = form.get("name") or Path(source.name).stem
    text = {"en": name, "ru": name} | form.get("text", {})
    pins: dict[str, Any] = {
        key: form[key] for key in ("faults", "passports", "memory") if key in form
    }
    for key in ("values", "raw"):
        pins[key] = {name.upper(): value for name, value in form.get(key, {}).items()}
    start = form.get("start", {})
    ambient = start.get("ambient", ROOM)
    start = {"ambient": ambient, "coolant": ambient, "coolant_at_start": ambient} | start
    condition = Condition(**form.get("condition", {}))
    return Scenario(name, Text(**text), Start(**start), _timeline(form), condition, **pins)


def find(name: str) -> Scenario:
    """Return the shipped scenario `name`, or that of the file `name`.

    Raises `UsageError` if neither exists, `CatalogError` for an invalid file.
    """
    if name in SCENARIOS:
        return SCENARIOS[name]
    if Path(name).is_file():
        return load(Path(name))
    known = ", ".join(SCENARIOS)
    raise usage_error(
        f"there is no scenario and no file “{name}”; scenarios: {known}",
        f"нет ни сценария, ни файла «{name}»; сценарии: {known}",
    )


def _timeline(form: dict[str, Any]) -> ScenarioTimeline:
    tracks = {"key": _always(1)} | dict.fromkeys(("starter", "load", "consumers"), _always(0))
    return ScenarioTimeline(
        duration=form["duration"],
        loops=form.get("after_end") == "loop",
        loop_from=form.get("loop_from", 0.0),
        **(tracks | form.get("timeline", {})),
    )


def _always(value: float) -> Track:
    return Track((0.0,), (value,), smooth=False)


def _shipped() -> dict[str, Scenario]:
    files = Path(__file__).parent.glob("*.toml")
    scenarios = {path.stem: load(path) for path in sorted(files)}
    return {DEFAULT: scenarios.pop(DEFAULT)} | scenarios


SCENARIOS: Mapping[str, Scenario] = _shipped()
