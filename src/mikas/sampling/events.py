"""Events: of sampling, of a recording's notes, of live data and exports.

    SamplingSession ──► events ──► SessionAnnotator ──► notes in the file ──► the same events
                           └──► the dashboard's ConnectionMonitor, MQTT, the lines of `watch`

One JSON form (`Event.as_json`): `kind`, `time` and the class's fields by name; texts in both
languages. A field that a file lacks is None.

A value is fresh (of this cycle), stale (of an earlier cycle, with its own time) or missing. A stale
value is never among the fresh ones: a wrong value is worse than a gap.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from enum import StrEnum
from typing import Any, ClassVar, Final, Self

from mikas.client import Limits, Passport, Reading
from mikas.client.identity import UnitIdentity
from mikas.client.parameters.derived import DerivedValue
from mikas.commands.unit import version_text
from mikas.errors import MikasError, PortKind
from mikas.i18n import Text, joined
from mikas.instruments.reading import InstrumentReading
from mikas.sampling.plan import Plan
from mikas.sampling.states import STATE_TEXTS as STATE_TEXTS  # noqa: PLC0414  (its public place)
from mikas.sampling.states import LineState as LineState  # noqa: PLC0414  (so too)

_NO_TEXT: Final = Text("", "")
_NOT_IN_JSON: Final = {"json": False}


@dataclass(frozen=True, slots=True)
class Event:
    """An event at a `time` of the link's clock. `recording`: its number in the file, if read."""

    kind: ClassVar[str]
    """Its name in JSON and in a recording."""
    time: float
    """When, on the link's clock."""
    recording: int = field(default=0, kw_only=True, metadata=_NOT_IN_JSON)

    def as_json(self) -> dict[str, Any]:
        """Return `kind` and the fields by name; texts in both languages, an empty one is None."""
        shown = (each.name for each in fields(self) if each.metadata.get("json", True))
        return {"kind": self.kind} | {name: _plain(getattr(self, name)) for name in shown}

    def moved(self, seconds: float) -> Self:
        """Return the event that is `seconds` later, with a gap's begin and end."""
        return replace(self, time=self.time + seconds)


def _plain(value: object) -> object:
    match value:
        case Text():
            return {"en": value.en, "ru": value.ru} if value.en else None
        case Passport():
            return [*value.program, *value.data]
        case Mapping():
            return dict(value)
        case StrEnum():
            return value.value
    return value


# The values


@dataclass(frozen=True, slots=True)
class Sampled(Event):
    """One cycle. `fresh` was read in it; `stale`: the last values of the other parameters.

    `time`: the beginning of its first response. `derived`: from fresh values alone; a channel with
    a stale input has no value here. `instruments`: beside the unit, in a session that has some.
    """

    kind = "sample"
    fresh: Mapping[str, Reading]
    """The readings of this cycle, by name."""
    stale: Mapping[str, Reading]
    derived: Mapping[str, DerivedValue] = field(default_factory=dict)
    instruments: Mapping[str, InstrumentReading] = field(
        default_factory=dict, metadata=_NOT_IN_JSON
    )
    """The values of instruments that are not too old, by channel."""

    @property
    def values(self) -> dict[str, float | bool]:
        """The fresh values, the derived ones and the instruments', by name."""
        both = (self.fresh, self.derived, self.instruments)
        return {name: it.value for group in both for name, it in group.items()}


@dataclass(frozen=True, slots=True)
class CycleFailed(Event):
    """A cycle without values, by `error`. Several in a row are one gap."""

    kind = "error"
    error: MikasError
    """The error of the exchange, with its bytes."""


@dataclass(frozen=True, slots=True)
class Gap(Event):
    """No values from `began` to `ended`; None: the gap continues, or the recording ended in it.

    `error`: the one that `reason` is of; a recording does not keep it.
    """

    kind = "gap"
    began: float
    """The time of the last values before it."""
    ended: float | None
    """The time of the first values after it."""
    reason: Text | None = None
    """Why, in words."""
    error: MikasError | None = field(default=None, compare=False, metadata=_NOT_IN_JSON)

    def moved(self, seconds: float) -> Self:
        """As `Event.moved`."""
        ended = None if self.ended is None else self.ended + seconds
        return replace(self, time=self.time + seconds, began=self.began + seconds, ended=ended)


# The line and the unit


@dataclass(frozen=True, slots=True)
class StateChanged(Event):
    """The line's state changed, by `error`. A file of a later version may have other states.

    `text` and `reason` are those of `state` and `error`, or those in the file. `port`: its kind.
    """

    kind = "state"
    state: LineState | str
    """The new state."""
    error: MikasError | None = field(default=None, metadata=_NOT_IN_JSON)
    """The error that it follows from; None: it got better."""
    text: Text = _NO_TEXT
    """The state in words."""
    reason: Text | None = None
    """The error in words."""
    port: PortKind = field(default=PortKind.CABLE, metadata=_NOT_IN_JSON)

    def __post_init__(self) -> None:
        if isinstance(self.state, LineState) and self.text == _NO_TEXT:
            object.__setattr__(self, "text", self.state.text_on(self.port))
        if self.error is not None:
            object.__setattr__(self, "reason", self.error.reason)

    @property
    def is_broken(self) -> bool:
        """Whether no ECU answers."""
        return self.state in (LineState.NO_PORT, LineState.NO_ECHO, LineState.ECHO_ONLY)


@dataclass(frozen=True, slots=True)
class AdapterMoved(Event):
    """The adapter was plugged in again and has the name `port` now; `before`: its name until then.

    It is the same adapter, as far as its identity shows (`mikas.link.identity`).
    """

    kind = "adapter"
    port: str
    """The name now."""
    before: str

    @property
    def text(self) -> Text:
        """The move in words."""
        return Text(f"the adapter is now at {self.port}", f"адаптер теперь на {self.port}")


@dataclass(frozen=True, slots=True)
class ClockChanged(Event):
    """The computer's date moved by `seconds` against its clock, from `before` to `after`.

    `slept`: the computer slept, and `time` has this sleep in it; the values before and after have
    their true dates. Else the date was set: all times of the session are to be read by `seconds`
    later.
    """

    kind = "clock"
    seconds: float
    """By how much; negative: set back."""
    slept: bool
    before: float
    """The date before."""
    after: float
    """The date after."""

    @property
    def later(self) -> float:
        """The seconds that are added to the session's times."""
        return 0.0 if self.slept else self.seconds

    @property
    def text(self) -> Text:
        """The change in words."""
        length = _span(abs(self.seconds))
        if self.slept:
            return _SLEPT.filled(length=length)
        return (_SET_BACK if self.seconds < 0 else _SET_AHEAD).filled(length=length)

    def as_json(self) -> dict[str, Any]:
        """As `Event.as_json`, with the text."""
        return {**Event.as_json(self), "text": _plain(self.text)}


def _span(seconds: float) -> Text:
    """Return a length of time, by its two largest units."""
    left, parts = round(seconds), list[Text]()
    for size, unit in ((86400, Text("d", "дн.")), (3600, Text("h", "ч")), (60, Text("min", "мин"))):
        count, left = divmod(left, size)
        parts += [Text(f"{count} {unit.en}", f"{count} {unit.ru}")] if count or parts else []
    parts.append(Text(f"{left} s", f"{left} с"))
    return joined(" ", parts[:2])


_SLEPT: Final = Text(
    "The computer slept for {length}; nothing was measured in that time",
    "Компьютер спал {length}, за это время ничего не измерено",
)
_SET_AHEAD: Final = Text(
    "The computer's date was set ahead by {length}; no time passed, and all values have the new "
    "date",
    "Дата компьютера переведена вперёд на {length}; время при этом не прошло, все данные "
    "датированы по-новому",
)
_SET_BACK: Final = Text(
    "The computer's date was set back by {length}; no time passed, and all values have the new "
    "date",
    "Дата компьютера переведена назад на {length}; время при этом не прошло, все данные "
    "датированы по-новому",
)
SLEPT: Final = Text("The computer slept.", "Компьютер спал.")
"""The reason of a gap."""


@dataclass(frozen=True, slots=True)
class UnitFound(Event):
    """A unit answers. `another`: not the unit before, so another car, or perhaps so.

    To read a recording again: `adapter`, `baud` and `echo` of the link, the `catalog`'s version.
    """

    kind = "unit"
    version_code: int | None
    """The answer to 01; None: unknown."""
    passport: Passport | None
    """The passports, as far as they were read."""
    another: bool = False
    model: Text | None = None
    """The model in words."""
    adapter: str = field(default="", metadata=_NOT_IN_JSON)
    """The name of the adapter."""
    baud: int = field(default=9600, metadata=_NOT_IN_JSON)
    """Bits a second on the line."""
    echo: bool | None = field(default=None, metadata=_NOT_IN_JSON)
    """Whether the adapter returns the sent bytes."""
    catalog: str = field(default="", metadata=_NOT_IN_JSON)
    """The version of the catalog that decodes."""

    def as_json(self) -> dict[str, Any]:
        """As `Event.as_json`; the version code as hex text."""
        return {**Event.as_json(self), "version_code": version_text(self.version_code)}

    @property
    def identity(self) -> UnitIdentity:
        """The unit, to be compared with another."""
        return UnitIdentity(self.version_code, self.passport)


@dataclass(frozen=True, slots=True)
class PlanChanged(Event):
    """The requests change to `plan`; from here on the catalog of this version decodes.

    `catalog` empty: the version of the unit's event.
    """

    kind = "plan"
    plan: Plan
    """The plan from here on."""
    catalog: str = ""
    """The version that decodes; empty: that of the unit's event."""


@dataclass(frozen=True, slots=True)
class MethodChosen(Event):
    """The method changes. `rates`: cycles a second of each measured method; 0: it failed.

    `limits`: those of the unit known at the time (D10, D11).
    """

    kind = "method"
    method: str
    """The method from here on."""
    rates: Mapping[str, float] = field(default_factory=dict)
    limits: Limits | None = field(default=None, metadata=_NOT_IN_JSON)


@dataclass(frozen=True, slots=True)
class ParameterDropped(Event):
    """The unit refuses the parameter `name`, or is silent; sampling of the others continues."""

    kind = "dropped"
    name: str
    """The parameter."""
    limits: Limits | None = field(default=None, metadata=_NOT_IN_JSON)
    """Those of the unit known at the time."""


@dataclass(frozen=True, slots=True)
class ParameterReturned(Event):
    """The unit answers the dropped parameter `name` again; it is sampled from now on."""

    kind = "returned"
    name: str
    """The parameter."""
    limits: Limits | None = field(default=None, metadata=_NOT_IN_JSON)
    """Those of the unit known at the time."""


@dataclass(frozen=True, slots=True)
class AlarmChanged(Event):
    """The alarm of the channel `name` changed from the level `before` to `level`.

    `side` and `limit`: of the crossed limit, that of the new level, or of the level before if the
    value got `better`. The limit of a flag is 1.
    """

    kind = "alarm"
    name: str
    """The channel."""
    level: str
    """The new level: none, warning, danger."""
    before: str | None
    """The level before."""
    side: str | None
    """low or high; None: of a flag."""
    value: float | None
    """The value that crossed the limit."""
    limit: float | None
    """The limit that was crossed."""
    text: Text
    """The alarm in words."""
    better: bool = field(default=False, metadata=_NOT_IN_JSON)
    """Whether the new level is a milder one."""


@dataclass(frozen=True, slots=True)
class FaultReading(Event):
    """The `codes` of the stored faults, in the unit's order. `erased`: shortly before.

    `added`: those that the reading before did not have; None: unknown.
    `routine`: read by the program from time to time, of interest only where the codes differ.
    """

    kind = "faults"
    codes: tuple[int, ...]
    """The numbers of the stored faults."""
    erased: bool = False
    added: tuple[int, ...] | None = field(default=None, compare=False)
    routine: bool = field(default=False, metadata=_NOT_IN_JSON, compare=False)


# The user's


@dataclass(frozen=True, slots=True)
class Marker(Event):
    """A moment marked by the user.

    `renamed`: another name of the marker at that time, which comes back if it was removed.
    `removed`: the marker at that time is none any more.
    """

    kind = "marker"
    label: str = ""
    """Its name; may be empty."""
    renamed: bool = field(default=False, metadata=_NOT_IN_JSON)
    removed: bool = field(default=False, metadata=_NOT_IN_JSON)


@dataclass(frozen=True, slots=True)
class TextNote(Event):
    """The user's text at a moment."""

    kind = "note"
    text: str
    """The text as it was typed."""
