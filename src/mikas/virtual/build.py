"""A virtual car from settings, for `sim:` URLs and `mikas sim`.

Every setting is a text, as in a URL or on a command line, and is checked.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from mikas.catalog import shipped
from mikas.catalog.ignition_only import DEAD
from mikas.errors import usage_error
from mikas.options import OptionParser, check_names, invalid_value
from mikas.virtual import VIRTUAL_PASSPORT
from mikas.virtual.bus import AdapterKind, Bus, Elm327, Stalls
from mikas.virtual.cars import EngineCar
from mikas.virtual.defects.choosing import car_of
from mikas.virtual.ecu import EcuEvent, VirtualEcu
from mikas.virtual.fault_injector import LATE_BY, FaultInjector, LineFault, parse_rates
from mikas.virtual.memory import EcuMemory
from mikas.virtual.model.engine import Engine
from mikas.virtual.quirks import QUIRK_NAMES, words
from mikas.virtual.responder import Identity, Responder
from mikas.virtual.scenarios.scenario import DEFAULT, find

if TYPE_CHECKING:
    from mikas.virtual.unit_profile import UnitProfile

MODELS = {"5.4": 0x09, "7.1": 0x0A}
ADAPTERS = ("kkl", "elm327")
PROTOCOLS = ("mikas", "kwp2000", "kwp2000-fast", "kwp2000-slow")
_LINE_FAULTS = tuple(fault.value for fault in LineFault)
SETTINGS = (
    "scenario", "car", "seed", "model", "ignition_only", "faults", "baud", "adapter", "protocol",
    "adapter_baud", "echo", "unit", "latency_ms", "supplied", "stall_every", "stall_ms", "late_by",
    *QUIRK_NAMES, *_LINE_FAULTS,
)  # fmt: skip
"""Names of all settings; docs/reference/simulator.md describes each."""
CAR_SETTINGS = ("scenario", "car", "model", "ignition_only", "faults", "unit")
WIRE_SETTINGS = tuple(name for name in SETTINGS if name not in CAR_SETTINGS)
"""Settings that apply to any source of data."""


def build_bus(
    settings: Mapping[str, str],
    *,
    start: float = 0.0,
    watcher: Callable[[EcuEvent], None] | None = None,
) -> Bus:
    """Return the wire with a unit; the engine begins to run at `start` of the caller's clock.

    Raises `UsageError` for an unknown setting or an invalid value, and for the file of a `unit`.
    """
    check_names(settings, SETTINGS)
    if "unit" in settings:
        return met_bus(_profile(Path(settings["unit"])), settings, start=start, watcher=watcher)
    return wired(_responder(_car(settings, start), settings), settings, watcher=watcher)


def met_bus(
    profile: UnitProfile,
    settings: Mapping[str, str] | None = None,
    *,
    start: float = 0.0,
    watcher: Callable[[EcuEvent], None] | None = None,
) -> Bus:
    """Return the wire with a unit that behaves as `profile` says; `settings` change it further.

    Raises `UsageError` for settings that do not fit.
    """
    from mikas.virtual.met_unit import MetCar, identity_of, quirks_of

    settings = settings or {}
    check_names(settings, SETTINGS)
    if "model" in settings:
        raise usage_error(
            "model can't be set with a unit: the file says which one it is",
            "model нельзя задать вместе с unit: какой это блок, сказано в файле",
        )
    models = {code: model for model, code in MODELS.items()}
    found = {"model": models.get(profile.version_code or 0, "7.1")}
    if profile.echo is not None:
        found["echo"] = "1" if profile.echo else "0"
    wanted = found | dict(settings)
    car = _car(wanted, start)
    stored = profile.faults or ()
    car.past = frozenset(stored) - frozenset(car.faults)  # the engine of that unit ran with them
    car.faults = [*stored, *(each for each in car.faults if each not in stored)]
    responder = _responder(car, wanted)
    responder.identity = identity_of(profile, responder.identity)
    responder.quirks = quirks_of(profile)
    responder.car = MetCar(car, profile)
    return wired(responder, wanted, watcher=watcher)


def _profile(path: Path) -> UnitProfile:
    """Read the profile of a unit. Raises `UsageError`."""
    try:
        from mikas.virtual.unit_files import load  # most virtual units are made of no file
    except ImportError as error:  # the page without installation, which has no files
        raise usage_error(
            "a unit from a file needs mikas on a computer; this page has no files",
            "блок из файла возможен в программе на компьютере; у этой страницы нет файлов",
        ) from error
    return load(path)


def _car(settings: Mapping[str, str], start: float) -> EngineCar:
    """Return the car of the engine model."""
    given = OptionParser(settings)
    scenario, seed = find(settings.get("scenario", DEFAULT)), given.integer("seed", 0)
    if "car" in settings:
        scenario = car_of(settings["car"], seed).applied_to(scenario)
    if given.switch("ignition_only", default=False):
        zeros = {name: bytes(shipped().parameter(name).size) for name in DEAD}
        scenario = replace(scenario, raw={**zeros, **scenario.raw})
    engine = Engine(scenario, seed)
    return EngineCar(engine, shipped(), faults=_faults(settings.get("faults", "")), start=start)


def _responder(car: EngineCar, settings: Mapping[str, str]) -> Responder:
    """Return the unit in `car`."""
    scenario = car.engine.scenario
    model = OptionParser(settings).choice("model", "7.1", MODELS)
    passports = f"МИКАС {model}", VIRTUAL_PASSPORT, "", "2000.09.27", "ЗМЗ-4062.10", "", "", ""
    identity = Identity(MODELS[model], scenario.passports or passports)
    return Responder(car, identity, memory=EcuMemory(scenario.memory))


def wired(
    responder: Responder,
    settings: Mapping[str, str],
    *,
    watcher: Callable[[EcuEvent], None] | None = None,
) -> Bus:
    """Return a wire with `responder` and an adapter, by the `WIRE_SETTINGS` among `settings`.

    Quirks among `settings` replace those of `responder`. Raises `UsageError`.
    """
    given = OptionParser(settings)
    responder.quirks = responder.quirks.with_options(
        {name: settings[name] for name in QUIRK_NAMES if name in settings}
    )
    bus = Bus(
        VirtualEcu(
            responder,
            baud=given.integer("baud", 9600, lowest=50, highest=4_000_000),
            watcher=watcher,
        ),
        adapter=AdapterKind(
            echo=given.switch("echo", default=True),
            latency=given.number("latency_ms", 0.0, highest=1000) / 1000,
            supplied=given.switch("supplied", default=True),
        ),
        fault_injector=FaultInjector(
            parse_rates({name: settings[name] for name in _LINE_FAULTS if name in settings}),
            seed=given.integer("seed", 0),
            late_by=given.number("late_by", LATE_BY, highest=60),
        ),
        stalls=Stalls(
            given.number("stall_every", 0.0, highest=3600),
            given.number("stall_ms", 180.0, highest=10_000) / 1000,
            seed=given.integer("seed", 0),
        ),
    )
    if given.choice("adapter", "kkl", ADAPTERS) != "kkl":
        return Elm327(bus.ecu)
    if (protocol := given.choice("protocol", "mikas", PROTOCOLS)) != "mikas":
        from mikas.virtual.kwp2000_unit import Kwp2000Bus, Kwp2000Unit, Wake

        return Kwp2000Bus(bus.ecu, Kwp2000Unit(Wake(protocol)), adapter=bus.adapter.kind)
    bus.set_baud(given.integer("adapter_baud", bus.ecu.baud, lowest=50, highest=4_000_000))
    return bus


def _faults(text: str) -> list[int]:
    try:
        faults = [int(word) for word in words(text)]
    except ValueError:
        faults = [-1]
    if any(not 0 <= fault <= 255 for fault in faults):
        raise invalid_value("faults", text, "13,53 … (0 … 255)")
    return faults
