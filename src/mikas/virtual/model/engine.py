"""The engine model as the virtual unit sees it: advance it to a time, read its state.

    engine = Engine(SCENARIOS["warm-idle"], seed=1)
    engine.advance(12.5)             # seconds since the start; going back does nothing
    engine.state.coolant             # physical units, named by what §4's mnemonics mean
    engine.faults.add(13)            # from the next step on the air meter's substitute is used
    engine.next_cycle_time(1, 12.5)  # when the next engine cycle starts (D15)

Values hold for a step of the grid (1/32 s), only `cycles` runs on in between. The same scenario,
seed and changes of faults give the same states at the same times, however often they are read.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable
from math import floor, inf

from mikas.virtual.model.engine_state import FIELDS, EngineState, state_of
from mikas.virtual.model.physics import STEP
from mikas.virtual.model.plant import Plant, plant_at_start
from mikas.virtual.model.substitutes import Lost
from mikas.virtual.scenarios.scenario import DEFAULT, SCENARIOS, Scenario

__all__ = ["FIELDS", "HORIZON", "Engine", "EngineState"]

ROUNDING = 5e-5  # cycles: what is nearer to the last one is the same one, asked for in rounded time
HORIZON = 4.0  # s that `next_cycle_time` looks ahead


class Engine:
    """An engine in its car with its control unit, in one scenario.

    `faults`: the numbers of those present; may be changed or replaced at any time.
    """

    def __init__(
        self, scenario: Scenario = SCENARIOS[DEFAULT], seed: int = 0, faults: Iterable[int] = ()
    ) -> None:
        self.scenario = scenario
        self.faults = set(faults)
        self.time = 0.0
        self._applied = frozenset(self.faults)
        lost = Lost.by(self._applied)
        self._plant = plant_at_start(scenario.start, scenario.timeline, seed, lost)
        self._state: EngineState | None = None  # at `time`, once somebody has asked
        self._scout: Plant | None = None  # a copy of the plant that has gone ahead
        self._ahead: deque[tuple[float, float]] = deque()  # (cycles, rpm) of each step from now on

    def advance(self, to: float) -> None:
        """Advance to `to`, seconds since the start."""
        self._apply_faults()
        if to <= self.time:
            return
        self.time = to
        self._state = None
        last = floor(to / STEP)
        plant, ahead = self._plant, self._ahead
        while plant.step_number < last:
            plant.step()
            if ahead:
                ahead.popleft()

    @property
    def state(self) -> EngineState:
        """The state at the present time."""
        if self._state is None:
            self._state = state_of(self._plant, self.time, powered=self.powered)
        return self._state

    @property
    def powered(self) -> bool:
        """Whether the unit has supply now."""
        return self.scenario.ignition_on(self.time)

    def next_power_change(self, after: float) -> float:
        """Return when `powered` changes next; infinity if never."""
        return self.scenario.next_ignition_change(after)

    def next_cycle_time(self, stroke: int, after: float) -> float:
        """Return the next time later than `after` at which this stroke begins (D15).

        Strokes 0 and 1 begin with the engine cycle, 2 to 4 a quarter, a half and three quarters
        later. Exact as long as nobody changes `faults`. Infinity: no such moment within `HORIZON`
        seconds, because the engine stands or the unit has no power or no crank signal; ask again
        later. `after` may lie in the future; of the past only the present step is known.
        """
        self._apply_faults()
        phase = (stroke - 1) / 4 if stroke else 0.0
        first = self._plant.step_number
        after = max(after, first * STEP)
        index = floor(after / STEP)
        place, rpm = self._look(index - first)
        place += (after - index * STEP) * rpm / 120
        target = floor(place - phase + ROUNDING) + 1 + phase
        begin = after
        while begin <= after + HORIZON:
            end = (index + 1) * STEP
            time = begin + max(0.0, target - place) * 120 / rpm if rpm > 0 else inf
            if time < end:
                return time
            index, begin = index + 1, end
            place, rpm = self._look(index - first)
        return inf

    def _look(self, steps: int) -> tuple[float, float]:
        """Cycles and speed, as the unit sees it, `steps` from the present one on."""
        ahead = self._ahead
        if not ahead:
            self._scout = self._plant.fork()
            ahead.append((self._plant.cycles, self._plant.seen_rpm))
        scout = self._scout
        assert scout is not None  # made with the first entry of `ahead`
        while len(ahead) <= steps:
            scout.step()
            ahead.append((scout.cycles, scout.seen_rpm))
        return ahead[steps]

    def _apply_faults(self) -> None:
        if self._applied != self.faults:
            self._applied = frozenset(self.faults)
            self._plant.program.sensors.lost = Lost.by(self._applied)
            self._ahead.clear()
