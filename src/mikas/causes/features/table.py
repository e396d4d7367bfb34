"""All features, by name."""

from __future__ import annotations

from typing import Final

from mikas.causes.features.air import breathing, no_air, spread_of_breathing
from mikas.causes.features.cooling import (
    cooling_by_wind,
    evenness,
    late_warm_up,
    most_warmth,
    rise_at_idle,
    warm_up,
    warmth_driven,
)
from mikas.causes.features.electric import (
    charging_fall,
    charging_fast,
    charging_held,
    charging_most,
    charging_spread,
    recovery,
)
from mikas.causes.features.idle import air_below_set, passage, stalls, valve_lag
from mikas.causes.features.ignition import knock_rate, most_retard, retard
from mikas.causes.features.mixture import thick, thin, trim, trim_difference
from mikas.causes.features.starting import (
    colder_than_air,
    crank_dip,
    crank_pull,
    crank_speed,
    crank_turns,
    crank_voltage,
    key_on,
    rest_air,
    rest_voltage,
)
from mikas.causes.features.throttle import (
    flat_top,
    hidden_throttle,
    least_throttle,
    throttle_jumps,
    widest_throttle,
)
from mikas.causes.features.view import Feature, Seen, View, middle, width
from mikas.causes.regimes import DriveByRegime
from mikas.causes.samples import median

FEATURES: Final = (
    Feature("rest-voltage", rest_voltage, "air"),
    Feature("rest-air", rest_air),
    Feature("coolant-against-air", colder_than_air),
    Feature("crank-speed", crank_speed, "coolant"),
    Feature("crank-voltage", crank_voltage, "coolant"),
    Feature("crank-dip", crank_dip, "coolant"),
    Feature("crank-pull", crank_pull, "coolant"),
    Feature("crank-turns", crank_turns, "coolant"),
    Feature("stalls", stalls),
    Feature("voltage-idle", middle("UACC", "idle", 6)),
    Feature("voltage-cold-idle", middle("UACC", "cold", 6)),
    Feature("voltage-driven", charging_fast),
    Feature("voltage-driven-high", charging_most),
    Feature("voltage-driven-spread", charging_spread),
    Feature("voltage-held", charging_held),
    Feature("voltage-fall", charging_fall),
    Feature("voltage-recovery", recovery),
    Feature("idle-speed", middle("FREQX", "warm", 6)),
    Feature("idle-hunting", width("FREQX", "idle", 8)),
    Feature("cold-idle-hunting", width("FREQX", "cold", 8), "cold-warmth"),
    Feature("cold-idle-speed", middle("FREQX", "cold", 6), "cold-warmth"),
    Feature("idle-advance", middle("UOZ", "idle", 6)),
    Feature("cold-idle-advance", middle("UOZ", "cold", 6)),
    Feature("idle-air", middle("JAIR", "warm", 6)),
    Feature("idle-valve", middle("FSM", "warm", 6), "air"),
    Feature("cold-idle-valve", middle("FSM", "cold", 6), "cold-warmth"),
    Feature("idle-throttle", middle("THR", "idle", 4)),
    Feature("valve-lag", valve_lag),
    Feature("air-per-step", passage(lambda v: v.idle)),
    Feature("cold-air-per-step", passage(lambda v: v.cold)),
    Feature("air-below-set", air_below_set),
    Feature("trim-idle", trim(lambda v: v.idle, 10)),
    Feature("trim-light", trim(thin, 12)),
    Feature("trim-heavy", trim(thick, 12)),
    Feature("trim-difference", trim_difference),
    Feature("breathing-light", breathing(10, 45)),
    Feature("breathing-middle", breathing(45, 110)),
    Feature("breathing-heavy", breathing(110, 500)),
    Feature("breathing-spread", spread_of_breathing),
    Feature("no-air", no_air),
    Feature("hidden-throttle", hidden_throttle),
    Feature("throttle-jumps", throttle_jumps),
    Feature("least-throttle", least_throttle),
    Feature("flat-top", flat_top),
    Feature("widest-throttle", widest_throttle),
    Feature("knock", knock_rate),
    Feature("retard", retard),
    Feature("most-retard", most_retard),
    Feature("coolant-driven", warmth_driven, "air"),
    Feature("coolant-rise", rise_at_idle, "air"),
    Feature("coolant-range", evenness, "air"),
    Feature("coolant-most", most_warmth),
    Feature("coolant-drop", cooling_by_wind, "air"),
    Feature("warm-up", warm_up, "air"),
    Feature("late-warm-up", late_warm_up, "air"),
)


BY_NAME: Final = {feature.name: feature for feature in FEATURES}


def context_of(view: View) -> dict[str, float]:
    """Return what features depend on: the air's and the coolant's temperature at the beginning."""
    begin = list(range(min(20, len(view.times))))
    starting = key_on(view) or begin
    return {
        "air": median(view.values("TAIR", starting)),
        "coolant": median(view.values("TWAT", starting)),
        "cold-warmth": median(view.values("TWAT", view.cold)),
    }


def features_of(drive: DriveByRegime) -> dict[str, Seen]:
    """Return what was seen of each feature in a drive."""
    view = View(drive)
    found = {feature.name: feature.compute(view) for feature in FEATURES}
    return {name: seen for name, seen in found.items() if seen is not None}
