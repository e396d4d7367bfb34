"""Air, petrol and spark in the ZMZ-4062.10: constants and pure functions, no state.

A mean-value model: one number for a whole engine cycle, not for a crank angle. The fixed points
come from the facts about the car (2286 cm³, 106 kW at 5200 rpm, 385 kg/h of air there, 15 kg/h at
850 rpm, an injector of 2.5 mg/ms with 0.8 ms dead time); the curves between them are the model's
assumptions. Air is in kg/h, charge and petrol in mg a stroke, torque in Nm.
"""

from __future__ import annotations

from itertools import pairwise
from math import pi, sqrt

STEP = 1 / 32  # s: the grid of integration; a power of two, so n·STEP is exact
STROKE_AIR = 686.0  # mg: one cylinder full of air at 20 °C and 1 bar
STOICHIOMETRIC = 14.7
INJECTOR = 2.5  # mg/ms
PETROL = 0.74  # kg/l
PETROL_HEAT = 43.0  # kJ/g
THROTTLE_FLOW = 1900.0  # kg/h through a fully open, choked 60 mm throttle
THROTTLE_LEAK = 4.0  # kg/h past the closed one
VALVE_FLOW = 0.33  # kg/h a step of the idle valve
CHOKED = 0.528  # pressure ratio below which the flow through a gap no longer grows
DISPLACEMENT_TORQUE = 2.286e-3 / (4 * pi)  # Nm per Pa of mean pressure
TO_RADIANS = pi / 30  # rpm -> rad/s


class LookupTable:
    """A piecewise linear function as an evenly spaced table: a look-up costs one index."""

    __slots__ = ("_last", "_low", "_per", "_table")

    def __init__(self, points: dict[float, float], cell: float) -> None:
        knots = sorted(points.items())
        self._low, self._per = knots[0][0], 1 / cell
        self._last = round((knots[-1][0] - self._low) * self._per)
        self._table = [_between(knots, self._low + i * cell) for i in range(self._last + 1)]

    def __call__(self, x: float) -> float:
        """Return the value at `x`; outside the curve that of the nearest end."""
        place = (x - self._low) * self._per
        if place <= 0:
            return self._table[0]
        index = int(place)
        if index >= self._last:
            return self._table[-1]
        left = self._table[index]
        return left + (self._table[index + 1] - left) * (place - index)


def _between(knots: list[tuple[float, float]], x: float) -> float:
    for (x0, y0), (x1, y1) in pairwise(knots):
        if x <= x1:
            return y0 + (y1 - y0) * (x - x0) / (x1 - x0)
    return knots[-1][1]


# Share of STROKE_AIR that a cylinder takes with the throttle wide open, over rpm.
FILLING = LookupTable(
    {0: 0.74, 600: 0.76, 1000: 0.79, 1500: 0.82, 2000: 0.85, 2500: 0.88, 3000: 0.91, 4000: 0.94,
     4500: 0.93, 5200: 0.91, 6000: 0.80, 7000: 0.62},
    100,
)  # fmt: skip
# Friction of a cold engine against a warm one, over coolant °C (thick oil).
VISCOSITY = LookupTable(
    {-40: 3.6, -20: 2.5, 0: 1.85, 20: 1.5, 40: 1.25, 60: 1.1, 85: 1.0, 120: 0.96}, 5
)
# Torque against the best mixture's, over λ.
BURN = LookupTable({0.4: 0.55, 0.6: 0.8, 0.75: 0.94, 0.88: 1.0, 0.95: 0.99, 1.0: 0.96, 1.15: 0.86,
              1.3: 0.6, 1.5: 0.1, 1.6: 0}, 0.01)  # fmt: skip
# Advance at full load, over rpm: as early as knock allows.
SPARK = LookupTable({0: 6, 600: 7, 1000: 9, 2000: 16, 3000: 22, 4000: 25, 5200: 28, 7000: 29}, 100)


def air_per_stroke(air: float, rpm: float) -> float:
    """Return the charge in mg of an air flow in kg/h: 147 mg of 15 kg/h at 850 rpm."""
    return air * 1e6 / (120 * rpm) if rpm > 0 else 0.0


def air_flow(charge: float, rpm: float) -> float:
    """Return the air flow in kg/h of a charge in mg a stroke."""
    return charge * rpm * 120e-6


def fuel_flow(fuel: float, rpm: float) -> float:
    """Return the litres an hour of `fuel` mg a stroke."""
    return fuel * rpm * 120e-6 / PETROL


def dead_time(voltage: float) -> float:
    """Return the injector's dead time in ms: 0.8 at 14 V, more as voltage falls."""
    lack = 14.0 - voltage
    return max(0.5, 0.8 + 0.15 * lack + (0.012 * lack * lack if lack > 0 else 0.0))


def injected(pulse: float, voltage: float) -> float:
    """Return the petrol of a pulse at this voltage, mg."""
    return max(0.0, (pulse - dead_time(voltage)) * INJECTOR) if pulse > 0 else 0.0


def injection(fuel: float, voltage: float) -> float:
    """Return the pulse in ms for `fuel` mg a stroke; no fuel, no pulse."""
    return dead_time(voltage) + fuel / INJECTOR if fuel > 0 else 0.0


def throttle_air(percent: float) -> float:
    """Return the choked flow through the throttle, kg/h."""
    return THROTTLE_LEAK + THROTTLE_FLOW * (percent / 100) ** 2


def throttle_for(flow: float) -> float:
    """Return the opening in % whose choked flow is `flow`: the inverse of `throttle_air`."""
    return min(100.0, 100 * sqrt(max(0.0, flow - THROTTLE_LEAK) / THROTTLE_FLOW))


def density(intake_air: float) -> float:
    """Return the density of the intake air against 20 °C."""
    return 293.0 / (273.0 + intake_air)


def demand(rpm: float) -> float:
    """Return the air that the cylinders take with the throttle wide open, kg/h at 20 °C."""
    return air_flow(STROKE_AIR * FILLING(rpm), rpm)


def manifold(inlet: float, demand: float) -> float:
    """Return the steady manifold pressure against outside, for a choked inlet flow and a demand.

    Below `CHOKED` the inlet lets `inlet` through, above it less and less (an ellipse); the
    cylinders take `demand` times the pressure ratio: where the two meet is a quadratic.
    """
    if inlet <= CHOKED * demand:
        return inlet / demand
    width = (inlet / (1 - CHOKED)) ** 2
    height = width + demand * demand
    middle = width * CHOKED
    return (middle + sqrt(middle * middle - height * (middle * CHOKED - inlet * inlet))) / height


def inlet_for(ratio: float, demand: float) -> float:
    """Return the choked inlet flow for a manifold at `ratio`: the inverse of `manifold`."""
    if ratio <= CHOKED:
        return ratio * demand
    shape = 1 - ((ratio - CHOKED) / (1 - CHOKED)) ** 2
    return ratio * demand / sqrt(shape) if shape > 1e-4 else 100 * demand


def base_advance(rpm: float, filling: float) -> float:
    """Return degrees before top dead centre: the full-load line, earlier for a smaller charge."""
    return SPARK(rpm) + 22 * (0.9 - filling)


def knock_limit(rpm: float, filling: float, intake_air: float, coolant: float) -> float:
    """Return the advance at which this charge begins to knock."""
    cool = 0.12 * (25 - intake_air) + 0.1 * (88 - coolant)
    return SPARK(rpm) + 2.5 + 60 * (0.9 - filling) + cool


def indicated_torque(charge: float, rpm: float, mixture: float, advance: float) -> float:
    """Return the torque of the charge, before friction; at low speed the walls take more heat."""
    best = SPARK(rpm) + 4 + 25 * (0.9 - charge / STROKE_AIR)
    late = best - advance
    spark = max(0.2, 1 - 0.00025 * late * late)
    return 0.423 * charge * rpm / (rpm + 450) * BURN(mixture) * spark


def friction(rpm: float) -> float:
    """Return the friction of a warm engine, Nm; a cold one has `VISCOSITY` times as much."""
    return 12.6 + rpm * (0.0035 + 4.4e-7 * rpm)


def pumping(ratio: float) -> float:
    """Return the torque lost by suction from a manifold at `ratio` of the outside pressure."""
    return (1 - ratio) * 1e5 * DISPLACEMENT_TORQUE
