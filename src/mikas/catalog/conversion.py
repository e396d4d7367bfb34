"""Raw bytes to values and back, exactly (§4).

A conversion is data: `value = (raw - bias) * scale + offset` in rational numbers. Its normal form
has three integers, `value = (raw * numerator + constant) / denominator`, with all terms below
2**52. So a single value and an array of 64-bit floats agree exactly, and every raw number survives
the conversion to a value and back.

Two-byte numbers have the low byte first (§2). A flag is one or several bits of a shared byte.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from fractions import Fraction
from math import isfinite, lcm

from mikas.errors import UsageError, ValueDoesNotFit
from mikas.i18n import Text

EXACT = 2**52
"""Smaller integers are exact as 64-bit floats, and rounding a quotient shifts it by less than half
of 1 / denominator, so by less than half a raw step (up to 2**53 it could be a whole one)."""

NO_TEXT = Text("", "")

_SHARED_BYTE = Text(
    "a flag is one bit of a byte that it shares with others; write the whole byte raw",
    "признак — один бит байта, общего с другими; запишите байт целиком в исходном виде",
)
_NOT_A_NUMBER = Text("a finite number is needed", "нужно конечное число")


@dataclass(frozen=True, slots=True)
class Conversion:
    """One interpretation of raw bytes; `numerator`, `constant`, `denominator`: the normal form.

    `unit` is a stable key (`rpm`), `unit_text` is for display (`об/мин`). A `mask` other than 0
    makes a flag: any of its bits is set. ValueError: scale is 0, or the numbers are not exact.
    """

    size: int
    """The number of raw bytes."""
    signed: bool = False
    """Whether the raw number is in two's complement."""
    mask: int = 0
    """The bits of a flag; 0: a number."""
    scale: Fraction = Fraction(1)
    """value = (raw − bias) · scale + offset."""
    bias: int = 0
    """As in the formula of `scale`."""
    offset: Fraction = Fraction(0)
    """As in the formula of `scale`."""
    unit: str = ""
    """The stable key, `rpm`."""
    unit_text: Text = NO_TEXT
    """The unit for display."""
    numerator: int = field(init=False, repr=False, compare=False)
    constant: int = field(init=False, repr=False, compare=False)
    denominator: int = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        denominator = lcm(self.scale.denominator, self.offset.denominator)
        numerator = int(self.scale * denominator)
        constant = int(self.offset * denominator) - self.bias * numerator
        largest = max(abs(number * numerator) for number in self.raw_limits)
        if numerator == 0 or max(largest + abs(constant), denominator) >= EXACT:
            raise ValueError(f"scale {self.scale} with offset {self.offset} is 0 or too fine")
        object.__setattr__(self, "numerator", numerator)
        object.__setattr__(self, "constant", constant)
        object.__setattr__(self, "denominator", denominator)

    @property
    def kind(self) -> str:
        """How the raw bytes are read: `flag`, `signed`, `word` (two bytes), else `unsigned`."""
        if self.mask:
            return "flag"
        return "signed" if self.signed else "word" if self.size == 2 else "unsigned"

    @property
    def is_flag(self) -> bool:
        """Whether the value is True or False."""
        return self.mask != 0

    @property
    def is_whole(self) -> bool:
        """Whether every value is an int or a flag by construction."""
        return self.denominator == 1

    @property
    def raw_limits(self) -> tuple[int, int]:
        """The lowest and the highest raw number."""
        count = 1 << (8 * self.size)
        return (-count // 2, count // 2 - 1) if self.signed else (0, count - 1)

    @property
    def limits(self) -> tuple[float, float] | None:
        """The lowest and the highest value that the raw bytes can hold; None for a flag."""
        if self.is_flag:
            return None
        low, high = sorted(self.value(number) for number in self.raw_limits)
        return low, high

    def value(self, number: int) -> float | int | bool:
        """Return the value of a raw number, which is signed if the kind is."""
        if self.mask:
            return number & self.mask != 0
        exact = number * self.numerator + self.constant
        return exact if self.denominator == 1 else exact / self.denominator

    def decode(self, raw: bytes) -> float | int | bool:
        """Return the value of the raw bytes. UsageError: not `size` bytes."""
        if len(raw) != self.size:
            problem = Text(
                f"{self.size} raw byte(s) are needed, not {len(raw)}",
                f"нужно байтов: {self.size}, а дано: {len(raw)}",
            )
            raise UsageError(problem=problem, received=raw)
        return self.value(int.from_bytes(raw, "little", signed=self.signed))

    def encode(self, value: float | Fraction, name: str) -> bytes:
        """Return the raw bytes nearest to `value` (halfway: the higher raw number).

        ValueDoesNotFit, with `name`: a flag, not a finite number, or out of `limits`.
        """
        if self.is_flag:
            raise ValueDoesNotFit(value=value, name=name, allowed=_SHARED_BYTE)
        if isinstance(value, bool) or not isinstance(value, int | float | Fraction):
            raise ValueDoesNotFit(value=repr(value), name=name, allowed=_NOT_A_NUMBER)
        if isinstance(value, float) and not isfinite(value):
            raise ValueDoesNotFit(value=value, name=name, allowed=_NOT_A_NUMBER)
        over, under = value.as_integer_ratio()
        steps, one_step = over * self.denominator - self.constant * under, self.numerator * under
        number = (2 * steps + one_step) // (2 * one_step)
        low, high = self.raw_limits
        if not low <= number <= high:
            raise ValueDoesNotFit(value=value, name=name, allowed=self._allowed())
        return number.to_bytes(self.size, "little", signed=self.signed)

    def _allowed(self) -> Text:
        low, high = sorted(self.value(number) for number in self.raw_limits)
        step = decimal_text(abs(self.scale))
        return Text(
            f"{low:.10g} to {high:.10g} {self.unit_text.en}".rstrip() + f", in steps of {step}",
            f"от {low:.10g} до {high:.10g} {self.unit_text.ru}".rstrip() + f", шаг {step}",
        )

    @property
    def formula(self) -> str:
        """The conversion as §4 prints it: `b − 40`, `w / 125`, `(b − 128)/256 − 0.5`."""
        raw = {1: "b", 2: "w"}.get(self.size, "n")
        if self.mask:
            return f"{raw} & 0x{self.mask:0{2 * self.size}X}"
        if self.signed:
            raw = "s" if self.size == 1 else "s" + raw
        if self.bias and (self.offset or self.scale != 1):
            raw = f"({_sum(raw, Fraction(-self.bias))})"
        elif self.bias:
            raw = _sum(raw, Fraction(-self.bias))
        times, over = ("·", "/") if self.bias or self.offset else (" · ", " / ")
        if (factor := abs(self.scale.numerator)) != 1:
            raw += f"{times}{factor}"
        if self.scale.denominator != 1:
            raw += f"{over}{self.scale.denominator}"
        if self.scale < 0:
            return f"{decimal_text(self.offset)} − {raw}" if self.offset else f"−{raw}"
        if self.offset > 0 and self.scale != 1:
            return f"{decimal_text(self.offset)} + {raw}"
        return _sum(raw, self.offset) if self.offset else raw


def decimal_text(number: Fraction) -> str:
    """Return `−0.5`, `40`, or `1/3` if no short decimal is exact."""
    sign = "−" if number < 0 else ""
    size = abs(number)
    decimal = f"{float(size):.12g}"
    return sign + (decimal if Fraction(decimal) == size else str(size))


def _sum(left: str, right: Fraction) -> str:
    return f"{left} {'−' if right < 0 else '+'} {decimal_text(abs(right))}"
