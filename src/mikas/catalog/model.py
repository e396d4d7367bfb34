"""The catalog's entries as frozen values (§3, §4), usable without the catalog they come from."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from enum import StrEnum
from fractions import Fraction
from itertools import pairwise
from math import isfinite

from mikas.catalog.conversion import NO_TEXT, Conversion
from mikas.catalog.formula_syntax import parse
from mikas.catalog.formulas import Calculation
from mikas.errors import UsageError
from mikas.i18n import Text


class Confidence(StrEnum):
    """How well a statement is known."""

    CONFIRMED = "confirmed"  # two independent public sources
    REPORTED = "reported"  # one source
    UNCONFIRMED = "unconfirmed"  # commonly printed, no source seen
    UNKNOWN = "unknown"  # nothing is known; only the number is shown


class Level(StrEnum):
    """How bad it is."""

    NONE = "none"
    WARNING = "warning"
    DANGER = "danger"


LIMITS = ("danger_low", "warning_low", "warning_high", "danger_high")
"""The limits from the lowest to the highest."""


@dataclass(frozen=True, slots=True)
class AlarmLimits:
    """Beyond a limit is an alarm; back inside by `hysteresis`, it is over. None: no such limit.

    In the unit of the corrected reading. `when_true` is for a flag, which has no other limits.
    UsageError: the limits are not in order, or leave nothing between them.
    """

    danger_low: float | None = None
    warning_low: float | None = None
    warning_high: float | None = None
    danger_high: float | None = None
    hysteresis: float = 0
    when_true: Level = Level.NONE
    source: str = ""
    confidence: Confidence = Confidence.UNCONFIRMED

    def __post_init__(self) -> None:
        given = [(name, limit) for name in LIMITS if (limit := getattr(self, name)) is not None]
        for name, number in (*given, ("hysteresis", self.hysteresis)):
            if not isfinite(number):
                raise _wrong(f"{name} is no finite number", f"{name} — не конечное число")
        if self.hysteresis < 0:
            raise _wrong("hysteresis is below 0", "hysteresis меньше 0")
        for (lower, low), (upper, high) in pairwise(given):
            across = lower.endswith("low") and upper.endswith("high")
            if low > high or (across and low + self.hysteresis >= high):
                more = " and the hysteresis" if across else ""
                raise _wrong(
                    f"{upper} {high:g} must be above {lower} {low:g}{more}",
                    f"{upper} {high:g} должен быть выше {lower} {low:g}"
                    + (" с учётом hysteresis" if across else ""),
                )

    @property
    def lows(self) -> tuple[tuple[Level, float], ...]:
        """The low limits that there are, the mildest first."""
        return _present((Level.WARNING, self.warning_low), (Level.DANGER, self.danger_low))

    @property
    def highs(self) -> tuple[tuple[Level, float], ...]:
        """The high limits that there are, the mildest first."""
        return _present((Level.WARNING, self.warning_high), (Level.DANGER, self.danger_high))

    @property
    def for_number(self) -> bool:
        """Whether there is a limit that only a number can cross."""
        return bool(self.lows or self.highs)

    @property
    def for_flag(self) -> bool:
        """Whether `when_true` alarms."""
        return self.when_true is not Level.NONE


def _present(*limits: tuple[Level, float | None]) -> tuple[tuple[Level, float], ...]:
    return tuple((level, limit) for level, limit in limits if limit is not None)


def _wrong(en: str, ru: str) -> UsageError:
    return UsageError(problem=Text(en, ru))


@dataclass(frozen=True, slots=True)
class Derived:
    """One derived channel. Its formula is sound, and takes parameters in the corrected reading.

    `inputs` are the channels that the formula names, in capitals. If it `accumulates`, the formula
    is what is added a second. `constants` are the formula's own, by name.
    """

    name: str
    text: Text
    formula: str
    inputs: tuple[str, ...]
    constants: tuple[tuple[str, float], ...] = ()
    accumulates: bool = False
    unit: str = ""
    unit_text: Text = NO_TEXT
    decimals: int = 2
    alarm_limits: AlarmLimits | None = None
    source: str = ""
    confidence: Confidence = Confidence.UNKNOWN

    @property
    def is_flag(self) -> bool:
        """Never: a derived value is a number."""
        return False

    def calculation(self) -> Calculation:
        """The formula, ready to compute; each caller has its own."""
        return Calculation(parse(self.formula, dict(self.constants)))


def in_order(derived: Mapping[str, Derived], wanted: Iterable[str]) -> tuple[Derived, ...]:
    """The derived channels that `wanted` need, themselves included, each after its inputs.

    CycleError (graphlib): there is no such order.
    """
    from graphlib import TopologicalSorter

    graph: dict[str, list[str]] = {}
    to_see = list(wanted)
    while to_see:
        name = to_see.pop()
        if name not in graph:
            graph[name] = [each for each in derived[name].inputs if each in derived]
            to_see += graph[name]
    return tuple(derived[name] for name in TopologicalSorter(graph).static_order())


INTERPRETATIONS = ("corrected", "literal", "alternative")


def check_interpretation(name: str) -> None:
    """Raise `UsageError` for a name outside `INTERPRETATIONS`."""
    if name not in INTERPRETATIONS:
        known = ", ".join(INTERPRETATIONS)
        raise UsageError(
            problem=Text(
                f"There is no interpretation “{name}”; there are: {known}",
                f"Толкования «{name}» нет; есть: {known}",
            )
        )


"""corrected: the letter, save where it is impossible (the default). literal: the letter of the
source. alternative: another sense of a letter that is odd, but possible (E3)."""


@dataclass(frozen=True, slots=True)
class Lamp:
    """What stands on a flag's lamp while it is set, and while it is not."""

    on: Text
    off: Text


@dataclass(frozen=True, slots=True)
class Meaning:
    """What a value below or above its reference may mean, and what to check; empty: not said."""

    low: Text = NO_TEXT
    high: Text = NO_TEXT
    source: str = ""
    confidence: Confidence = Confidence.UNCONFIRMED


@dataclass(frozen=True, slots=True)
class Parameter:
    """One parameter of §4, or of a user's file, or a bare code (`0x1A`) with no meaning.

    `conversion` is the corrected reading. `literal` and `alternative` are None where they would
    be the same. `plausible`, `reference` (warm idle) and `alarm_limits` are in the unit of the
    corrected reading. `lamp` is a flag's, `meaning` says what it means to be off the reference;
    None: nothing is said.
    """

    name: str
    code: int
    text: Text
    conversion: Conversion
    literal: Conversion | None = None
    alternative: Conversion | None = None
    decimals: int = 0
    plausible: tuple[float, float] | None = None
    reference: tuple[float, float] | None = None
    reference_confidence: Confidence = Confidence.UNKNOWN
    source: str = ""
    confidence: Confidence = Confidence.UNKNOWN
    errata: tuple[str, ...] = ()
    alarm_limits: AlarmLimits | None = None
    lamp: Lamp | None = None
    meaning: Meaning | None = None

    @property
    def size(self) -> int:
        """Raw bytes; the same in every reading."""
        return self.conversion.size

    @property
    def unit(self) -> str:
        """The corrected interpretation's unit."""
        return self.conversion.unit

    @property
    def unit_text(self) -> Text:
        """The corrected interpretation's unit, for a person."""
        return self.conversion.unit_text

    @property
    def is_flag(self) -> bool:
        """Whether its values are True and False."""
        return self.conversion.is_flag

    @property
    def interpretations(self) -> dict[str, Conversion]:
        """By name: always `corrected` and `literal`; `alternative` where there is one."""
        named = {"corrected": self.conversion, "literal": self.literal or self.conversion}
        if self.alternative is not None:
            named["alternative"] = self.alternative
        return named

    def interpretation(self, name: str) -> Conversion:
        """Return the interpretation `name`; the corrected one where this parameter lacks it.

        So one name can be set for a whole session. UsageError: a name outside `INTERPRETATIONS`.
        """
        check_interpretation(name)
        return self.interpretations.get(name, self.conversion)

    def decode(self, raw: bytes, interpretation: str = "corrected") -> float | int | bool:
        """The value: int where it is whole by construction, bool for a flag, else float.

        UsageError: not `size` bytes, or no such interpretation.
        """
        return self.interpretation(interpretation).decode(raw)

    def encode(self, value: float | Fraction, interpretation: str = "corrected") -> bytes:
        """The raw bytes nearest to `value`. ValueDoesNotFit: a flag, no number, out of range."""
        return self.interpretation(interpretation).encode(value, self.name)

    def formula(self, interpretation: str = "corrected") -> str:
        """How the value is made of the raw number, as §4 prints it."""
        return self.interpretation(interpretation).formula

    def limits(self, interpretation: str = "corrected") -> tuple[float, float] | None:
        """What the raw bytes can hold; None for a flag."""
        return self.interpretation(interpretation).limits

    @property
    def range(self) -> tuple[float, float] | None:
        """The plausible range where the catalog has one, else the limits; None for a flag."""
        return self.plausible or self.limits()

    @property
    def range_kind(self) -> str:
        """What `range` is: `plausible` or `representable`; empty for a flag."""
        if self.plausible:
            return "plausible"
        return "" if self.is_flag else "representable"


@dataclass(frozen=True, slots=True)
class Fault:
    """A fault number of command 02. `check`: what to look at first. `parameters` bear on it.

    `informational`: the number is a message, not a fault (12). An unknown number has no text.
    """

    code: int
    text: Text = NO_TEXT
    check: Text = NO_TEXT
    check_confidence: Confidence = Confidence.UNKNOWN
    parameters: tuple[str, ...] = ()
    confidence: Confidence = Confidence.UNKNOWN
    sources: tuple[str, ...] = ()
    informational: bool = False

    @property
    def known(self) -> bool:
        """Whether the number has a text."""
        return self.confidence is not Confidence.UNKNOWN


@dataclass(frozen=True, slots=True)
class Model:
    """What a unit answers to command 01. An unknown one is still usable (§3)."""

    code: int
    text: Text
    source: str = ""
    confidence: Confidence = Confidence.UNKNOWN

    @property
    def known(self) -> bool:
        """Whether this is a model that the catalog names."""
        return self.confidence is not Confidence.UNKNOWN

    @classmethod
    def unknown(cls, code: int) -> Model:
        """A unit that answers with another code than the known ones."""
        return cls(code, Text(f"unknown model 0x{code:02X}", f"неизвестная модель 0x{code:02X}"))


@dataclass(frozen=True, slots=True)
class Erratum:
    """A doubtful place of the source: what is taken, what else it could mean, and why.

    `selected_by`: the reading that switches to `alternative`; empty if none does.
    """

    name: str
    title: Text
    reason: Text
    default: Text
    alternative: Text
    selected_by: str = ""
    source: str = ""
