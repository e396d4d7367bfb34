"""A whole virtual car from a handful of settings: what `sim:` URLs and `mikas sim` have in common.

Every setting is a text, as it stands in a URL or on a command line; each is checked, and an unknown
one is refused with the list of those that there are.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from difflib import get_close_matches
from typing import TypeVar

from mikas.catalog import shipped
from mikas.errors import UsageError
from mikas.i18n import Text
from mikas.virtual.adapter import AdapterKind
from mikas.virtual.bus import Bus
from mikas.virtual.ecu import EcuEvent, VirtualEcu
from mikas.virtual.elm327 import Elm327
from mikas.virtual.engine_car import EngineCar
from mikas.virtual.fault_injector import LATE_BY, FaultInjector, LineFault, parse_rates
from mikas.virtual.memory import EcuMemory
from mikas.virtual.model.engine import Engine
from mikas.virtual.quirks import ASSUMPTION_NAMES, SWITCH, words
from mikas.virtual.responder import Identity, Responder
from mikas.virtual.scenarios.scenario import DEFAULT, find

T = TypeVar("T")

MODELS = {"5.4": 0x09, "7.1": 0x0A}
ADAPTERS = ("kkl", "elm327")
_TROUBLES = tuple(trouble.value for trouble in LineFault)
_OWN = (
    "scenario",
    "seed",
    "model",
    "faults",
    "baud",
    "adapter",
    "echo",
    "latency_ms",
    "supplied",
    "late_by",
)
SETTINGS = (*_OWN, *ASSUMPTION_NAMES, *_TROUBLES)
"""Names of all settings; docs/simulator.md tells what each does.

`adapter`: kkl, or elm327, which can't carry the protocol; `latency_ms`: the adapter's latency
timer; `supplied=0`: it has no 12 V; a line fault's name with its chance, `damaged=0.01`; the
switches of `EcuQuirks`.
"""
CAR_SETTINGS = ("scenario", "model", "faults")
WIRE_SETTINGS = tuple(name for name in SETTINGS if name not in CAR_SETTINGS)
"""Those that hold for any unit, wherever its data come from."""


def build_bus(
    settings: Mapping[str, str],
    *,
    start: float = 0.0,
    watcher: Callable[[EcuEvent], None] | None = None,
) -> Bus:
    """The wire with a unit on it; the engine begins to run at `start` of the owner's clock.

    Raises `UsageError` for a setting that does not exist or makes no sense.
    """
    check_names(settings, SETTINGS)
    own = {name: settings[name] for name in _OWN if name in settings}
    seed = _number(own, "seed", int, 0)
    scenario = find(own.get("scenario", DEFAULT))
    car = EngineCar(
        Engine(scenario, seed), shipped(), faults=_faults(own.get("faults", "")), start=start
    )
    model = own.get("model", "7.1")
    if model not in MODELS:
        raise _bad("model", model, ", ".join(MODELS))
    passports = scenario.passports or _passports(model)
    identity = Identity(MODELS[model], passports)
    responder = Responder(car, identity, memory=EcuMemory(scenario.memory))
    return wired(responder, settings, watcher=watcher)


def wired(
    responder: Responder,
    settings: Mapping[str, str],
    *,
    watcher: Callable[[EcuEvent], None] | None = None,
) -> Bus:
    """The unit on a wire and behind an adapter, as the `WIRE_SETTINGS` among `settings` say.

    What they say of the unit's assumptions stands over what those are. Raises `UsageError`.
    """
    own = {name: settings[name] for name in _OWN if name in settings}
    responder.assumptions = responder.assumptions.with_options(
        {name: settings[name] for name in ASSUMPTION_NAMES if name in settings}
    )
    seed = _number(own, "seed", int, 0)
    baud = _number(own, "baud", int, 9600)
    if not 50 <= baud <= 4_000_000:
        raise _bad("baud", own["baud"], "50 … 4000000")
    bus = Bus(
        VirtualEcu(responder, baud=baud, watcher=watcher),
        adapter=AdapterKind(
            echo=_switch(own, "echo"),
            latency=_seconds(own, "latency_ms", 0.0, 1000.0) / 1000,
            supplied=_switch(own, "supplied"),
        ),
        disturbance=FaultInjector(
            parse_rates({name: settings[name] for name in _TROUBLES if name in settings}),
            seed=seed,
            late_by=_seconds(own, "late_by", LATE_BY, 60.0),
        ),
    )
    adapter = own.get("adapter", "kkl")
    if adapter not in ADAPTERS:
        raise _bad("adapter", adapter, ", ".join(ADAPTERS))
    return bus if adapter == "kkl" else Elm327(bus.ecu)


def check_names(settings: Mapping[str, str], allowed: Sequence[str]) -> None:
    """Raises `UsageError` for a setting that is not `allowed`."""
    for name in settings:
        if name not in allowed:
            raise _unknown(name, allowed)


def _passports(model: str) -> tuple[str, ...]:
    return (f"МИКАС {model}", "ВИРТУАЛЬНЫЙ БЛОК", "", "2000.09.27", "ЗМЗ-4062.10", "", "", "")


def _faults(text: str) -> list[int]:
    try:
        faults = [int(word) for word in words(text)]
    except ValueError:
        faults = [-1]
    if any(not 0 <= fault <= 255 for fault in faults):
        raise _bad("faults", text, "13,53 … (0 … 255)")
    return faults


def _number(own: Mapping[str, str], name: str, kind: Callable[[str], T], default: T) -> T:
    try:
        return kind(own[name]) if name in own else default
    except ValueError:
        raise _bad(name, own[name], "0, 1, 2 …") from None


def _seconds(own: Mapping[str, str], name: str, default: float, highest: float) -> float:
    number = _number(own, name, float, default)
    if not 0 <= number <= highest:
        raise _bad(name, own[name], f"0 … {highest:g}")
    return number


def _switch(own: Mapping[str, str], name: str) -> bool:
    value = own.get(name, "1").lower()
    if value not in SWITCH:
        raise _bad(name, value, "0, 1")
    return SWITCH[value]


def _bad(name: str, value: str, allowed: str) -> UsageError:
    return UsageError(
        problem=Text(
            f"“{value}” is no value for {name}; allowed: {allowed}",
            f"«{value}» не подходит для {name}; можно: {allowed}",
        )
    )


def _unknown(name: str, allowed: Sequence[str]) -> UsageError:
    nearest = ", ".join(get_close_matches(name, allowed) or allowed)
    return UsageError(
        problem=Text(
            f"the virtual ECU has no setting “{name}”; there is {nearest}",
            f"у виртуального блока нет настройки «{name}»; есть {nearest}",
        )
    )
