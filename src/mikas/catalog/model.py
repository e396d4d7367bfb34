"""What a catalog entry is, once it is known to be sound (§3, §4).

All are frozen values. Nothing here is looked up or loaded: a parameter can be used without the
catalog that it came from.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from mikas.catalog.confidence import Confidence
from mikas.catalog.conversion import NO_TEXT, Conversion
from mikas.catalog.limits import AlarmLimits
from mikas.errors import UsageError
from mikas.i18n import Text

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
