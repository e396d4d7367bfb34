"""What sampling tells: samples, gaps, and the state of the line in words.

A value is fresh (it came in this cycle), stale (from an earlier one, with its own time) or missing.
A stale one never stands among the fresh: a wrong reading is worse than a hole.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum

from mikas.client import Passport, Reading
from mikas.errors import MikasError
from mikas.i18n import Text
from mikas.sampling.alarms import AlarmChanged
from mikas.sampling.derived import DerivedValue
from mikas.sampling.plan import Plan


class LineState(Enum):
    """How far the way to the ECU is open, from worst to best."""

    NO_PORT = "no-port"
    NO_ECHO = "no-echo"
    ECHO_ONLY = "echo-only"
    ECU_ALIVE = "ecu-alive"
    SAMPLING = "sampling"

    @property
    def text(self) -> Text:
        """The state in words."""
        return _WORDS[self]


_WORDS = {
    LineState.NO_PORT: Text("no adapter", "нет адаптера"),
    LineState.NO_ECHO: Text(
        "no echo: no 12 V at the adapter, or the wrong port",
        "нет эха: на адаптере нет 12 В или не тот порт",
    ),
    LineState.ECHO_ONLY: Text(
        "echo, but the ECU is silent: ignition off?",
        "эхо есть, блок молчит: выключено зажигание?",
    ),
    LineState.ECU_ALIVE: Text("the ECU answers", "блок отвечает"),
    LineState.SAMPLING: Text("sampling", "идёт опрос"),
}


@dataclass(frozen=True, slots=True)
class StateChanged:
    """The line's state is another one since `time`; `error` is what showed it, if anything did."""

    time: float
    state: LineState
    error: MikasError | None = None


@dataclass(frozen=True, slots=True)
class Sampled:
    """One cycle. `fresh` came in it; `stale` are the last known of those that were not asked.

    `time` is when the first of its responses began. `derived`: what was made of the fresh alone; a
    channel of which an input is stale has no value here.
    """

    time: float
    fresh: Mapping[str, Reading]
    stale: Mapping[str, Reading]
    derived: Mapping[str, DerivedValue] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class CycleFailed:
    """A cycle that brought nothing, and why. Several in a row are one hole in the recording."""

    time: float
    error: MikasError


@dataclass(frozen=True, slots=True)
class MethodChosen:
    """The method in use from here on. `rates`: sets a second of each, as measured now or before
    with this kind of adapter; 0: it does not work.
    """

    time: float
    method: str
    rates: Mapping[str, float]


@dataclass(frozen=True, slots=True)
class ParameterDropped:
    """A parameter that the unit refuses; the others go on."""

    time: float
    name: str


@dataclass(frozen=True, slots=True)
class UnitFound:
    """A unit answers. `another`: its passport is not that of the one before, so it is another
    car.
    """

    time: float
    version_code: int
    passport: Passport
    another: bool


@dataclass(frozen=True, slots=True)
class PlanChanged:
    """What is asked from here on."""

    time: float
    plan: Plan


Event = (
    StateChanged
    | Sampled
    | CycleFailed
    | MethodChosen
    | ParameterDropped
    | UnitFound
    | PlanChanged
    | AlarmChanged
)
