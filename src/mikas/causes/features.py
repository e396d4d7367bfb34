"""Features: one number each about a drive, in the regime where it says most.

Each has its rows, so that a person can look at the moments. What was not seen long enough has no
value. What the engine should breathe is the engine model's (`mikas.virtual.model.physics`): known
from the model and from service literature, not from cars.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import isnan, log1p, nan
from typing import Final

from mikas.causes.regimes import Drive, Regime
from mikas.causes.samples import PAUSE, Column, Span, median, quantile, spans_of
from mikas.virtual.model import physics as ph

FADING: Final = 5.0  # s of an idle until it is even
NEUTRAL: Final = -0.5  # E3: RCOK without a correction, by the letter


@dataclass(frozen=True, slots=True)
class Seen:
    """A feature's value, the value to show (before any logarithm), where it was seen."""

    value: float
    shown: float
    spans: tuple[Span, ...]


Compute = Callable[["View"], Seen | None]


class View:
    """A drive as features look at it."""

    def __init__(self, drive: Drive) -> None:
        self.drive = drive
        self.times = drive.samples.times
        self.warm = self._settled(self._late(drive.at(Regime.WARM_IDLE)))
        self.cold = self._settled(drive.at(Regime.COLD_IDLE))
        mild = self._late(drive.at(Regime.MILD_IDLE))
        self.idle = self._settled(sorted([*self._late(drive.at(Regime.WARM_IDLE)), *mild]))
        self.load = drive.at(Regime.PART_LOAD, Regime.FULL_LOAD)
        self._expected: dict[int, float] | None = None

    def column(self, name: str) -> Column | None:
        """Return a column; None: not read."""
        return self.drive.samples.column(name)

    def _late(self, rows: Sequence[int]) -> list[int]:
        return [row for row in rows if self.drive.run_time[row] > 25.0]

    def _settled(self, rows: Sequence[int]) -> list[int]:
        """Return the rows without the first seconds of each idle: the speed is still falling."""
        kept = []
        since = last = -1e9
        for row in rows:
            time = self.times[row]
            if time - last > PAUSE:
                since = time
            last = time
            if time - since >= FADING:
                kept.append(row)
        return kept

    def values(self, name: str, rows: Sequence[int]) -> list[float]:
        """Return the values of a channel in these rows, the missing left out."""
        column = self.column(name)
        if column is None:
            return []
        return [value for row in rows if not isnan(value := column[row])]

    def seconds(self, rows: Sequence[int]) -> float:
        """Return about how long these rows last."""
        if not rows:
            return 0.0
        count = len(self.times)
        step = self.drive.samples.seconds / (count - 1) if count > 1 else 0.0
        return len(rows) * min(step, 1.0) if step else 0.0

    def expected(self) -> dict[int, float]:
        """Return by row under load the air, kg/h, of throttle, idle valve and speed."""
        if self._expected is None:
            self._expected = self._compute_expected()
        return self._expected

    def _compute_expected(self) -> dict[int, float]:
        throttle, valve = self.column("THR"), self.column("FSM") or self.column("SSM")
        intake = self.column("TAIR")
        if throttle is None or self.column("JAIR") is None:
            return {}
        found = {}
        for row in self.drive.running:
            if isnan(throttle[row]):
                continue
            steps = valve[row] if valve is not None and not isnan(valve[row]) else 30.0
            demand = ph.demand(self.drive.speed[row])
            inlet = ph.throttle_air(throttle[row]) + steps * ph.VALVE_FLOW
            warmth = intake[row] if intake is not None and not isnan(intake[row]) else 20.0
            found[row] = ph.manifold(inlet, demand) * demand * ph.density(warmth)
        return found

    def steady_load(self) -> list[int]:
        """Return rows under load in which the throttle has been steady for a while."""
        throttle = self.column("THR")
        if throttle is None:
            return []
        rows = []
        for row in self.load:
            if row >= 4:
                window = throttle[row - 4 : row + 1]
                if max(window) - min(window) <= 3.0 and self.times[row] - self.times[row - 4] < 4:
                    rows.append(row)
        return rows

    def seen(self, value: float, rows: Sequence[int], shown: float | None = None) -> Seen | None:
        """Return what was seen in these rows; None: no number."""
        if isnan(value):
            return None
        return Seen(value, value if shown is None else shown, spans_of(self.times, rows))


@dataclass(frozen=True, slots=True)
class Feature:
    """A feature by name. `context`: the value that it depends on in a sound car, too."""

    name: str
    compute: Compute
    context: str = ""


def _middle(name: str, rows: str, seconds: float, share: float = 0.5) -> Compute:
    def compute(view: View) -> Seen | None:
        chosen: list[int] = getattr(view, rows)
        if view.seconds(chosen) < seconds:
            return None
        return view.seen(quantile(view.values(name, chosen), share), chosen)

    return compute


def _width(name: str, rows: str, seconds: float) -> Compute:
    def compute(view: View) -> Seen | None:
        chosen: list[int] = getattr(view, rows)
        values = view.values(name, chosen)
        if view.seconds(chosen) < seconds or not values:
            return None
        return view.seen(quantile(values, 0.95) - quantile(values, 0.05), chosen)

    return compute


def _key_on(view: View) -> list[int]:
    first = view.drive.running[0] if view.drive.running else len(view.times)
    return [row for row in view.drive.at(Regime.KEY_ON) if row < first]


def _rest_voltage(view: View) -> Seen | None:
    rows = _key_on(view)
    if len(rows) < 3:
        return None
    return view.seen(quantile(view.values("UACC", rows), 0.8), rows)


def _rest_air(view: View) -> Seen | None:
    rows = view.drive.at(Regime.KEY_ON)
    values = view.values("JAIR", rows[3:])
    return view.seen(median(values), rows) if values else None


def _colder_than_air(view: View) -> Seen | None:
    rows = _key_on(view) or view.drive.starts[:1]
    coolant, intake = view.values("TWAT", rows), view.values("TAIR", rows)
    if not coolant or not intake:
        return None
    difference = median(coolant) - median(intake)
    return view.seen(max(-40.0, min(25.0, difference)), rows, difference)


DRAWN: Final = 1.5  # V below rest that only a starter draws


def _cranking(view: View) -> list[int]:
    """Return where the starter turns the engine, or draws its current in vain."""
    rows = view.drive.at(Regime.CRANKING)
    if len(rows) > 2:
        return rows[1:]
    voltage, standing = view.column("UACC"), _key_on(view)
    if voltage is None or not standing:
        return []
    rest = quantile(view.values("UACC", standing), 0.9)
    return [row for row in standing if voltage[row] < rest - DRAWN]


def _crank_speed(view: View) -> Seen | None:
    rows = _cranking(view)
    if len(rows) < 3:
        return None
    speeds = [view.drive.speed[row] for row in rows if view.drive.speed[row] < 360]
    return view.seen(median(speeds), rows)


def _crank_voltage(view: View) -> Seen | None:
    rows = _cranking(view)
    return view.seen(median(view.values("UACC", rows)), rows) if len(rows) > 2 else None


def _crank_dip(view: View) -> Seen | None:
    rest, low = _rest_voltage(view), _crank_voltage(view)
    if rest is None or low is None:
        return None
    return view.seen(rest.value - low.value, _cranking(view))


def _crank_pull(view: View) -> Seen | None:
    speed, voltage = _crank_speed(view), _crank_voltage(view)
    if speed is None or voltage is None or voltage.value <= 0:
        return None
    return view.seen(speed.value / voltage.value, _cranking(view))


def _crank_turns(view: View) -> Seen | None:
    rows = view.drive.at(Regime.CRANKING)
    starts = view.drive.starts
    if not rows or not starts:
        return None
    turns = 0.0
    for row in rows:
        if row < starts[0] and row + 1 < len(view.times):
            turns += view.drive.speed[row] / 60 * (view.times[row + 1] - view.times[row])
    coolant = view.values("TWAT", rows)
    cold = max(0.0, 60.0 - median(coolant)) * 0.06 if coolant else 0.0
    beyond = turns - cold
    return view.seen(log1p(max(0.0, beyond)), rows, turns)


def _stalls(view: View) -> Seen | None:
    rows = view.drive.stalls
    if view.drive.samples.seconds < 30 or not view.drive.running:
        return None
    return view.seen(log1p(len(rows)), rows, float(len(rows)))


def _fast(view: View) -> list[int]:
    return [r for r in view.load if view.drive.speed[r] > 1500 and view.drive.run_time[r] > 60]


def _charging_fast(view: View) -> Seen | None:
    rows = _fast(view)
    return view.seen(median(view.values("UACC", rows)), rows) if len(rows) > 20 else None


def _charging_most(view: View) -> Seen | None:
    rows = _fast(view)
    if len(rows) < 20:
        return None
    return view.seen(quantile(view.values("UACC", rows), 0.95), rows)


def _charging_spread(view: View) -> Seen | None:
    rows = _fast(view)
    values = view.values("UACC", rows)
    if len(rows) < 20:
        return None
    return view.seen(quantile(values, 0.9) - quantile(values, 0.1), rows)


def _charging_fall(view: View) -> Seen | None:
    """How far the voltage falls from driving to idle."""
    rows = _fast(view)
    if len(rows) < 20 or view.seconds(view.idle) < 8:
        return None
    high = quantile(view.values("UACC", rows), 0.9)
    return view.seen(high - quantile(view.values("UACC", view.idle), 0.1), view.idle)


def _recovery(view: View) -> Seen | None:
    """The voltage late against early in the run: a battery that was low takes current at first."""
    run = view.drive.run_time
    if not view.drive.starts:
        return None
    early = [row for row in view.drive.running if 10 < run[row] < 60]
    late = [row for row in view.drive.running if run[row] > 240]
    if len(early) < 20 or len(late) < 50:
        return None
    return view.seen(median(view.values("UACC", late)) - median(view.values("UACC", early)), early)


def _valve_lag(view: View) -> Seen | None:
    want, have = view.column("SSM"), view.column("FSM")
    rows = view.idle or view.cold
    if want is None or have is None or view.seconds(rows) < 8:
        return None
    off = [abs(want[row] - have[row]) for row in rows if not isnan(want[row] + have[row])]
    return view.seen(quantile(off, 0.9), rows)


def _passage(rows_of: Callable[[View], list[int]]) -> Compute:
    """Air through the idle valve, against that of a clean passage at its position."""

    def compute(view: View) -> Seen | None:
        rows = rows_of(view)
        air, valve, intake = view.column("JAIR"), view.column("FSM"), view.column("TAIR")
        if air is None or valve is None or view.seconds(rows) < 6:
            return None
        throttle = view.column("THR")
        ratios = []
        for row in rows:
            warmth = intake[row] if intake is not None and not isnan(intake[row]) else 20.0
            opening = throttle[row] if throttle is not None and not isnan(throttle[row]) else 0.0
            due = (ph.throttle_air(opening) + valve[row] * ph.VALVE_FLOW) * ph.density(warmth)
            if not isnan(air[row] + due) and due > 0:
                ratios.append(air[row] / due)
        return view.seen(median(ratios), rows)

    return compute


def _air_below_set(view: View) -> Seen | None:
    goal, air = view.column("UGB"), view.column("JAIR")
    if goal is None or air is None or view.seconds(view.idle) < 8:
        return None
    off = [goal[row] - air[row] for row in view.idle if not isnan(goal[row] + air[row])]
    return view.seen(median(off), view.idle)


def _trim(rows_of: Callable[[View], list[int]], seconds: float) -> Compute:
    def compute(view: View) -> Seen | None:
        rows = [row for row in rows_of(view) if view.drive.run_time[row] > 45]
        values = view.values("RCOK", rows)
        if view.seconds(rows) < seconds or not values:
            return None
        trim = 100 * (sum(values) / len(values) - NEUTRAL)
        return view.seen(trim, rows)

    return compute


def _trim_difference(view: View) -> Seen | None:
    idle, load = _trim(lambda v: v.idle, 12)(view), _trim(_thin, 12)(view)
    if idle is None or load is None:
        return None
    return view.seen(idle.value - load.value, view.idle)


def _thin(view: View) -> list[int]:
    air = view.column("JAIR")
    return [] if air is None else [row for row in view.load if 12 < air[row] < 70]


def _thick(view: View) -> list[int]:
    air = view.column("JAIR")
    return [] if air is None else [row for row in view.load if air[row] >= 70]


def _breathing(low: float, high: float) -> Compute:
    """The air of the meter against that of throttle and speed."""

    def compute(view: View) -> Seen | None:
        expected, air = view.expected(), view.column("JAIR")
        if air is None:
            return None
        rows = [r for r in view.steady_load() if low <= expected.get(r, -1.0) < high]
        ratios = [air[row] / expected[row] for row in rows if not isnan(air[row])]
        if view.seconds(rows) < 5 or not ratios:
            return None
        return view.seen(median(ratios), rows)

    return compute


def _spread_of_breathing(view: View) -> Seen | None:
    expected, air = view.expected(), view.column("JAIR")
    if air is None:
        return None
    ratios = [air[r] / expected[r] for r in view.steady_load() if r in expected]
    if len(ratios) < 40:
        return None
    width = quantile(ratios, 0.97) - quantile(ratios, 0.03)
    return view.seen(log1p(max(0.0, width)), view.load, width)


def _no_air(view: View) -> Seen | None:
    """Seconds without air through the meter while the engine runs."""
    air = view.column("JAIR")
    if air is None or view.seconds(view.drive.running) < 20:
        return None
    rows = [r for r in view.drive.running if air[r] < 2.0]
    seconds = view.seconds(rows)
    return view.seen(log1p(2 * seconds), rows, seconds)


def _hidden_throttle(view: View) -> Seen | None:
    """Seconds in which the engine breathes much more than a closed throttle lets through."""
    throttle, expected, air = view.column("THR"), view.expected(), view.column("JAIR")
    if throttle is None or air is None or view.seconds(view.drive.running) < 20:
        return None
    rows = [
        row
        for row in view.drive.running
        if throttle[row] < 0.8
        and view.drive.speed[row] > 1000
        and air[row] > 1.7 * expected.get(row, 1e9) + 8
    ]
    seconds = view.seconds(rows)
    return view.seen(log1p(2 * seconds), rows, seconds)


def _throttle_jumps(view: View) -> Seen | None:
    """Falls of the throttle to 0 from an opening that the air does not follow, a minute."""
    throttle, air = view.column("THR"), view.column("JAIR")
    if throttle is None or air is None or view.seconds(view.load) < 20:
        return None
    rows = [
        row
        for row in view.drive.running[1:]
        if throttle[row] < 0.6
        and throttle[row - 1] > 1.5
        and air[row] > 0.75 * air[row - 1]
        and air[row] > 22
    ]
    rate = len(rows) / (view.seconds(view.drive.running) / 60)
    return view.seen(log1p(2 * rate), rows, rate)


def _least_throttle(view: View) -> Seen | None:
    values = view.values("THR", view.drive.running)
    if view.seconds(view.drive.running) < 20 or not values:
        return None
    return view.seen(quantile(values, 0.04), view.idle or view.drive.running)


def _flat_top(view: View) -> Seen | None:
    """The share of the wide openings that is exactly the widest: a plate that meets a stop."""
    throttle = view.column("THR")
    if throttle is None or view.seconds(view.load) < 60:
        return None
    values = view.values("THR", view.load)
    widest = max(values, default=0.0)
    if widest < 15 or widest > 93:
        return view.seen(0.0, view.load, 0.0)
    top = [row for row in view.load if throttle[row] >= widest - 0.8]
    wide = [row for row in view.load if throttle[row] >= 0.75 * widest]
    share = len(top) / len(wide) * min(1.0, view.seconds(top) / 3.0)
    return view.seen(share, top)


def _widest(view: View) -> Seen | None:
    values = view.values("THR", view.load)
    if view.seconds(view.load) < 60 or not values:
        return None
    return view.seen(max(values), view.load)


def _knock_rate(view: View) -> Seen | None:
    """Readings with knock, a minute of load."""
    flag, throttle = view.column("DET"), view.column("THR")
    rows = [r for r in view.load if throttle is not None and throttle[r] > 12]
    if flag is None or view.seconds(rows) < 15:
        return None
    heard = [row for row in rows if flag[row] == 1]
    rate = len(heard) / (view.seconds(rows) / 60)
    return view.seen(log1p(rate), heard, rate)


def _retard(view: View) -> Seen | None:
    throttle = view.column("THR")
    rows = [r for r in view.load if throttle is not None and throttle[r] > 12]
    values = view.values("UOZOC", rows)
    if view.seconds(rows) < 15 or not values:
        return None
    middle = sum(values) / len(values)
    return view.seen(-log1p(max(0.0, -middle)), rows, middle)


def _most_retard(view: View) -> Seen | None:
    values = view.values("UOZOC", view.load)
    if view.seconds(view.load) < 60 or not values:
        return None
    return view.seen(min(values), view.load)


def _plateau_rows(view: View) -> list[int]:
    """Rows of a run that is warm: long enough, or past the greatest warmth of a slow one."""
    coolant, run = view.column("TWAT"), view.drive.run_time
    if coolant is None:
        return []
    top = quantile(view.values("TWAT", view.drive.running), 0.98)
    rows = [r for r in view.drive.running if run[r] > 330 and not isnan(coolant[r])]
    if not rows:
        return []
    first = next((r for r in view.drive.running if coolant[r] >= top - 4), rows[-1])
    return [row for row in rows if row >= first]


def _driven(view: View) -> list[int]:
    """Rows of a warm engine in a car that has been driven for a while (wind at the radiator)."""
    rows = set(_plateau_rows(view))
    return [row for row in view.load if row in rows]


def _warmth_driven(view: View) -> Seen | None:
    rows = _driven(view)
    return view.seen(median(view.values("TWAT", rows)), rows) if len(rows) > 40 else None


def _most_warmth(view: View) -> Seen | None:
    values = view.values("TWAT", view.drive.running)
    if view.seconds(view.drive.running) < 60 or not values or max(values) < 78:
        return None
    return view.seen(quantile(values, 0.99), view.drive.running)


def _cooling_by_wind(view: View) -> Seen | None:
    """How far the coolant falls again after it was warm, driven."""
    rows = _plateau_rows(view)
    values = view.values("TWAT", rows)
    if view.seconds(rows) < 100 or view.seconds(_driven(view)) < 60:
        return None
    return view.seen(max(values) - quantile(values, 0.03), rows)


def _rise_at_idle(view: View) -> Seen | None:
    """How much warmer the coolant gets at idle than while driving."""
    warm = set(_plateau_rows(view))
    driven = [row for row in view.load if row in warm]
    idle = [row for row in view.idle if row in warm]
    if len(driven) < 40 or view.seconds(idle) < 15:
        return None
    rise = quantile(view.values("TWAT", idle), 0.9) - median(view.values("TWAT", driven))
    return view.seen(rise, idle)


def _evenness(view: View) -> Seen | None:
    """The range of the coolant once it is warm."""
    values = view.values("TWAT", _plateau_rows(view))
    if len(values) < 200 or view.seconds(_driven(view)) < 60:
        return None
    return view.seen(quantile(values, 0.95) - quantile(values, 0.05), _plateau_rows(view))


def _warm_up(view: View) -> Seen | None:
    """Degrees a litre of petrol while the engine warms up."""
    coolant, fuel = view.column("TWAT"), view.column("JQT")
    if coolant is None or fuel is None or not view.drive.running:
        return None
    burnt, begin, rows = 0.0, nan, []
    for before, row in zip(view.drive.running, view.drive.running[1:], strict=False):
        if isnan(coolant[row]) or isnan(fuel[row]):
            continue
        if isnan(begin):
            if coolant[row] > 65:
                return None
            begin = coolant[row]
        step = view.times[row] - view.times[before]
        burnt += fuel[row] * (step if step < 3 else 0.0) / 3600
        rows.append(row)
        if coolant[row] >= 74 or (coolant[row] - begin >= 45):
            break
    rise = coolant[rows[-1]] - begin if rows else 0.0
    if burnt < 0.1 or rise < 15:
        return None
    return view.seen(rise / burnt, rows)


def _late_warm_up(view: View) -> Seen | None:
    """Degrees a litre from 50 to 72 °C: there an open thermostat shows most."""
    coolant, fuel = view.column("TWAT"), view.column("JQT")
    if coolant is None or fuel is None:
        return None
    rows = [r for r in view.drive.running if 48 <= coolant[r] <= 72]
    if not rows or view.seconds(rows) < 40 or min(coolant[r] for r in rows) > 53:
        return None
    burnt = sum(fuel[r] for r in rows if not isnan(fuel[r])) / len(rows)
    burnt *= view.seconds(rows) / 3600
    rise = max(coolant[r] for r in rows) - min(coolant[r] for r in rows)
    return view.seen(rise / max(burnt, 0.02), rows)


FEATURES: Final = (
    Feature("rest-voltage", _rest_voltage, "air"),
    Feature("rest-air", _rest_air),
    Feature("coolant-against-air", _colder_than_air),
    Feature("crank-speed", _crank_speed, "coolant"),
    Feature("crank-voltage", _crank_voltage, "coolant"),
    Feature("crank-dip", _crank_dip, "coolant"),
    Feature("crank-pull", _crank_pull, "coolant"),
    Feature("crank-turns", _crank_turns, "coolant"),
    Feature("stalls", _stalls),
    Feature("voltage-idle", _middle("UACC", "idle", 6)),
    Feature("voltage-cold-idle", _middle("UACC", "cold", 6)),
    Feature("voltage-driven", _charging_fast),
    Feature("voltage-driven-high", _charging_most),
    Feature("voltage-driven-spread", _charging_spread),
    Feature("voltage-fall", _charging_fall),
    Feature("voltage-recovery", _recovery),
    Feature("idle-speed", _middle("FREQX", "warm", 6)),
    Feature("idle-hunting", _width("FREQX", "idle", 8)),
    Feature("cold-idle-hunting", _width("FREQX", "cold", 8), "cold-warmth"),
    Feature("cold-idle-speed", _middle("FREQX", "cold", 6), "cold-warmth"),
    Feature("idle-advance", _middle("UOZ", "idle", 6)),
    Feature("cold-idle-advance", _middle("UOZ", "cold", 6)),
    Feature("idle-air", _middle("JAIR", "warm", 6)),
    Feature("idle-valve", _middle("FSM", "warm", 6), "air"),
    Feature("cold-idle-valve", _middle("FSM", "cold", 6), "cold-warmth"),
    Feature("idle-throttle", _middle("THR", "idle", 4)),
    Feature("valve-lag", _valve_lag),
    Feature("air-per-step", _passage(lambda v: v.idle)),
    Feature("cold-air-per-step", _passage(lambda v: v.cold)),
    Feature("air-below-set", _air_below_set),
    Feature("trim-idle", _trim(lambda v: v.idle, 10)),
    Feature("trim-light", _trim(_thin, 12)),
    Feature("trim-heavy", _trim(_thick, 12)),
    Feature("trim-difference", _trim_difference),
    Feature("breathing-light", _breathing(10, 45)),
    Feature("breathing-middle", _breathing(45, 110)),
    Feature("breathing-heavy", _breathing(110, 500)),
    Feature("breathing-spread", _spread_of_breathing),
    Feature("no-air", _no_air),
    Feature("hidden-throttle", _hidden_throttle),
    Feature("throttle-jumps", _throttle_jumps),
    Feature("least-throttle", _least_throttle),
    Feature("flat-top", _flat_top),
    Feature("widest-throttle", _widest),
    Feature("knock", _knock_rate),
    Feature("retard", _retard),
    Feature("most-retard", _most_retard),
    Feature("coolant-driven", _warmth_driven, "air"),
    Feature("coolant-rise", _rise_at_idle, "air"),
    Feature("coolant-range", _evenness, "air"),
    Feature("coolant-most", _most_warmth),
    Feature("coolant-drop", _cooling_by_wind, "air"),
    Feature("warm-up", _warm_up, "air"),
    Feature("late-warm-up", _late_warm_up, "air"),
)
BY_NAME: Final = {feature.name: feature for feature in FEATURES}


def context_of(view: View) -> dict[str, float]:
    """Return what features depend on: the air's and the coolant's temperature at the beginning."""
    begin = list(range(min(20, len(view.times))))
    starting = _key_on(view) or begin
    return {
        "air": median(view.values("TAIR", starting)),
        "coolant": median(view.values("TWAT", starting)),
        "cold-warmth": median(view.values("TWAT", view.cold)),
    }


def features_of(drive: Drive) -> dict[str, Seen]:
    """Return what was seen of each feature in a drive."""
    view = View(drive)
    found = {feature.name: feature.compute(view) for feature in FEATURES}
    return {name: seen for name, seen in found.items() if seen is not None}
