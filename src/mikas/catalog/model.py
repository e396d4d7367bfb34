"""The catalog's entries as frozen values (§3, §4), usable without the catalog they come from."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import ClassVar, Literal, get_args

from mikas.catalog.conversion import NO_TEXT, Conversion
from mikas.catalog.formula_syntax import parse
from mikas.catalog.formulas import Calculation
from mikas.catalog.limits import AlarmLimits, Confidence, Level
from mikas.errors import usage_error
from mikas.i18n import Text
from mikas.json_values import picked

_LEAST_STEPS = 10  # on an axis, so that the noise of the last digit does not fill it
_LEAST_SHARE = 0.05  # of the range


def _least_span(step: float, scale: tuple[float, float] | None) -> float:
    """Return the least span of a value axis, for a channel without `span_least`."""
    low, high = scale or (0, 0)
    return max(_LEAST_STEPS * step, _LEAST_SHARE * (high - low))


@dataclass(frozen=True, slots=True)
class Derived:
    """A channel computed by a valid formula from parameters (corrected) or derived channels.

    `inputs`: the channels in the formula, in capitals. `accumulates`: the formula's value is added
    every second. `constants`: the formula's own, by name. `short`: the text of a small tile.
    `gauge`, `span_least`: as of a parameter.
    """

    name: str
    """The mnemonic, in capitals: `FUEL_FLOW`."""
    text: Text
    """Its name for a person."""
    formula: str
    """The formula, in the names of channels."""
    inputs: tuple[str, ...]
    short: Text = NO_TEXT
    constants: tuple[tuple[str, float], ...] = ()
    accumulates: bool = False
    unit: str = ""
    """The key of the unit."""
    unit_text: Text = NO_TEXT
    """The unit for display."""
    decimals: int = 2
    """Digits after the point."""
    gauge: tuple[float, float] | None = None
    span_least: float | None = None
    alarm_limits: AlarmLimits | None = None
    """The limits that alarm."""
    source: str = ""
    """Where the formula is from."""
    confidence: Confidence = Confidence.UNKNOWN
    """How well it is known."""
    # As of a parameter that is a number without bounds or a reference
    is_flag: ClassVar[bool] = False
    """False: its values are numbers."""
    range: ClassVar[None] = None
    """None: it has no bounds."""
    reference: ClassVar[None] = None
    """None: it has none."""
    lamp: ClassVar[None] = None
    """None: it is no flag."""
    meaning: ClassVar[None] = None
    """None: it has no reference."""
    errata: ClassVar[tuple[str, ...]] = ()
    """None concern it."""

    @property
    def gauge_scale(self) -> tuple[float, float] | None:
        """The scale of its gauge; None: unknown, to be fitted to the values."""
        return self.gauge

    @property
    def least_span(self) -> float:
        """The least span of an axis of its values."""
        return self.span_least or _least_span(10**-self.decimals, self.gauge)

    def calculation(self) -> Calculation:
        """Return the formula ready to compute, for one caller."""
        return Calculation(parse(self.formula, dict(self.constants)))


def in_order(derived: Mapping[str, Derived], wanted: Iterable[str]) -> tuple[Derived, ...]:
    """Return the channels of `wanted` and their derived inputs, each after its inputs.

    CycleError (graphlib): no such order exists.
    """
    from graphlib import TopologicalSorter

    graph: dict[str, list[str]] = {}
    pending = list(wanted)
    while pending:
        name = pending.pop()
        if name not in graph:
            graph[name] = [each for each in derived[name].inputs if each in derived]
            pending += graph[name]
    return tuple(derived[name] for name in TopologicalSorter(graph).static_order())


Interpretation = Literal["corrected", "literal", "alternative", "family"]
"""The name of a reading of the source's doubtful passages."""
INTERPRETATIONS: tuple[Interpretation, ...] = get_args(Interpretation)
"""corrected (default): the source's text, unless it is impossible; literal: the source's text;
alternative: another sense of a text that is odd, but possible (E3); family: that of siblings."""


def check_interpretation(name: str) -> None:
    """Raise `UsageError` for a name outside `INTERPRETATIONS`."""
    if name not in INTERPRETATIONS:
        known = ", ".join(INTERPRETATIONS)
        raise usage_error(
            f"There is no interpretation “{name}”; there are: {known}",
            f"Толкования «{name}» нет; есть: {known}",
        )


@dataclass(frozen=True, slots=True)
class Lamp:
    """The texts of a flag's lamp while the flag is set, and while it is not.

    `trouble`: its colour and shape while the flag is set; that raises no alarm.
    """

    on: Text
    """While the flag is set."""
    off: Text
    """While it is not."""
    trouble: Level = Level.NONE


@dataclass(frozen=True, slots=True)
class Meaning:
    """Causes of a value below or above its reference, and what to check; empty: unknown."""

    low: Text = NO_TEXT
    """Causes of a value below."""
    high: Text = NO_TEXT
    """Causes of a value above."""
    source: str = ""
    """Where this is from."""
    confidence: Confidence = Confidence.UNCONFIRMED
    """How well it is known."""


@dataclass(frozen=True, slots=True)
class Parameter:
    """One parameter of §4 or of a user's file, or a bare code (`0x1A`).

    `conversion` is the corrected interpretation; `literal`, `alternative` and `family` are None if
    equal to it. `plausible`, `reference` (warm idle), `gauge`, `span_least` and `alarm_limits` are
    in its unit. `lamp` is a flag's; `meaning` explains values off the reference; `short` is the
    text of a small tile.
    """

    name: str
    """The mnemonic, in capitals: `TWAT`."""
    code: int
    """The code that is sent after 61."""
    text: Text
    """Its name for a person."""
    conversion: Conversion
    """The corrected interpretation."""
    short: Text = NO_TEXT
    """The text of a small tile."""
    literal: Conversion | None = None
    """The source's letter; None: equal to the corrected one."""
    alternative: Conversion | None = None
    """The other sense (E3); None: there is none."""
    family: Conversion | None = None
    """That of sibling units; None: there is none."""
    decimals: int = 0
    """Digits after the point."""
    plausible: tuple[float, float] | None = None
    """The plausible range."""
    reference: tuple[float, float] | None = None
    """The range of a sound engine at warm idle."""
    reference_confidence: Confidence = Confidence.UNKNOWN
    """How well that is known."""
    gauge: tuple[float, float] | None = None
    """The scale of a gauge."""
    span_least: float | None = None
    """The least span of an axis."""
    source: str = ""
    """Where the definition is from."""
    confidence: Confidence = Confidence.UNKNOWN
    """How well it is known."""
    errata: tuple[str, ...] = ()
    """The errata that concern it."""
    alarm_limits: AlarmLimits | None = None
    """The limits that alarm."""
    lamp: Lamp | None = None
    """The texts of a flag's lamp."""
    meaning: Meaning | None = None
    """Causes of a value off its reference."""
    accumulates: ClassVar[bool] = False  # as a derived channel may
    """False; a derived channel may."""

    @property
    def size(self) -> int:
        """The number of raw bytes in every interpretation."""
        return self.conversion.size

    @property
    def unit(self) -> str:
        """The corrected interpretation's unit."""
        return self.conversion.unit

    @property
    def unit_text(self) -> Text:
        """The corrected interpretation's unit for display."""
        return self.conversion.unit_text

    @property
    def is_flag(self) -> bool:
        """Whether its values are True and False."""
        return self.conversion.is_flag

    @property
    def interpretations(self) -> dict[str, Conversion]:
        """By name: `corrected` and `literal`, and `alternative` and `family` if they exist."""
        named = {"corrected": self.conversion, "literal": self.literal or self.conversion}
        others = {"alternative": self.alternative, "family": self.family}
        return named | {name: each for name, each in others.items() if each is not None}

    def interpretation(self, name: str) -> Conversion:
        """Return the interpretation `name`; the corrected one if this parameter lacks it.

        UsageError: a name outside `INTERPRETATIONS`.
        """
        check_interpretation(name)
        if name == "corrected":
            return self.conversion
        own: Conversion | None = getattr(self, name)
        return own or self.conversion

    def decode(self, raw: bytes, interpretation: str = "corrected") -> float | int | bool:
        """Return the value: int if whole by construction, bool for a flag, else float.

        UsageError: not `size` bytes, or no such interpretation.
        """
        return self.interpretation(interpretation).decode(raw)

    def encode(self, value: float | Fraction, interpretation: str = "corrected") -> bytes:
        """Return the raw bytes nearest to `value`.

        ValueDoesNotFit: a flag, no number, out of range.
        """
        return self.interpretation(interpretation).encode(value, self.name)

    def formula(self, interpretation: str = "corrected") -> str:
        """Return the conversion of the raw number as §4 prints it."""
        return self.interpretation(interpretation).formula

    def limits(self, interpretation: str = "corrected") -> tuple[float, float] | None:
        """Return the range of the raw bytes; None for a flag."""
        return self.interpretation(interpretation).limits

    @property
    def range(self) -> tuple[float, float] | None:
        """The plausible range if the catalog has one, else the limits; None for a flag."""
        return self.plausible or self.limits()

    @property
    def range_kind(self) -> str:
        """The kind of `range`: `plausible` or `representable`; empty for a flag."""
        if self.plausible:
            return "plausible"
        return "" if self.is_flag else "representable"

    @property
    def gauge_scale(self) -> tuple[float, float] | None:
        """The scale of its gauge: as the catalog says, else `range`; None for a flag."""
        low, high = self.range or (0, 0)
        return self.gauge or ((low, high) if low < high else self.limits())

    @property
    def least_span(self) -> float | None:
        """The least span of an axis of its values; None for a flag."""
        if self.is_flag:
            return None
        step = max(abs(float(self.conversion.scale)), 10**-self.decimals)
        return self.span_least or _least_span(step, self.plausible or self.gauge)


@dataclass(frozen=True, slots=True)
class Fault:
    """A fault number of command 02. `check`: the first thing to check. `parameters`: related ones.

    `sensor`: those that come from the sensor whose circuit is faulty; the unit may use a substitute
    value for them. `informational`: the number is a message, not a fault (12). An unknown number
    has no text.
    """

    code: int
    """The number."""
    text: Text = NO_TEXT
    """What it means, for a person; empty: unknown."""
    check: Text = NO_TEXT
    check_confidence: Confidence = Confidence.UNKNOWN
    """How well the check is known."""
    parameters: tuple[str, ...] = ()
    sensor: tuple[str, ...] = ()
    confidence: Confidence = Confidence.UNKNOWN
    """How well the text is known."""
    sources: tuple[str, ...] = ()
    """Where the text is from."""
    informational: bool = False

    def __repr__(self) -> str:
        """Return it on one line: a notebook shows a whole list of them."""
        return f"<Fault {self.code}: {self.text.en or 'no text'} ({self.confidence})>"

    @property
    def known(self) -> bool:
        """Whether the number has a text."""
        return self.confidence is not Confidence.UNKNOWN

    def as_json(self) -> dict[str, object]:
        """Return number and texts; the texts of an unknown number are empty."""
        names = ("code", "text", "confidence", "check", "parameters", "sensor", "informational")
        return picked(self, *names)


@dataclass(frozen=True, slots=True)
class Model:
    """A unit's answer to command 01. An unknown model is usable too (§3)."""

    code: int
    """The answer to 01."""
    text: Text
    """Its name."""
    source: str = ""
    """Where that is from."""
    confidence: Confidence = Confidence.UNKNOWN
    """How well it is known; unknown: of a model that the catalog lacks."""

    @property
    def known(self) -> bool:
        """Whether the catalog has this model."""
        return self.confidence is not Confidence.UNKNOWN

    @classmethod
    def unknown(cls, code: int) -> Model:
        """Return the model of an unknown code."""
        return cls(code, Text(f"unknown model 0x{code:02X}", f"неизвестная модель 0x{code:02X}"))


@dataclass(frozen=True, slots=True)
class Erratum:
    """A doubtful passage of the source: the default and alternative sense, and the reason.

    `selected_by`: the interpretation that selects `alternative`; empty if none does. `family`: the
    sense that the interpretation `family` selects, if there is one.
    """

    name: str
    """Its name, E1."""
    title: Text
    """The doubtful place in a few words."""
    reason: Text
    """Why."""
    default: Text
    """The sense that is used."""
    alternative: Text
    """The other sense."""
    family: Text = NO_TEXT
    selected_by: str = ""
    source: str = ""
    """Where the passage is."""
