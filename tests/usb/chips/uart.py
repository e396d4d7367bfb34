"""The serial half of a chip: rate, form of a character, modem lines, break, receive buffer.

A receiver samples the line at its own rate. At another rate than the sender's it reads other
characters, with framing errors: `sampled` gives what a UART would read.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from enum import Flag, auto
from math import ceil, floor
from typing import NamedTuple, Protocol, TypeVar

T = TypeVar("T", bytes, "list[Character]")

_EXACT = 0.04
"""The tenth bit is then sampled within its middle four fifths, so nothing is misread."""


class Form(NamedTuple):
    """The form of a character: `8N1`."""

    bits: int = 8
    parity: str = "N"
    stop: float = 1

    def __str__(self) -> str:
        return f"{self.bits}{self.parity}{self.stop:g}"


class Settings(NamedTuple):
    """How one end of a line sends and samples."""

    rate: float = 9600.0
    form: Form = Form()

    def __str__(self) -> str:
        return f"{self.rate:.0f} {self.form}"

    def fits(self, other: Settings) -> bool:
        """Return whether every character of `other` is read as it was sent."""
        return self.form == other.form and abs(self.rate / other.rate - 1) < _EXACT

    @property
    def character_time(self) -> float:
        """Seconds of one character."""
        bits, parity, stop = self.form
        return (1 + bits + (parity != "N") + stop) / self.rate


class Damage(Flag):
    """What a UART reports of a character."""

    NONE = 0
    OVERRUN = auto()
    PARITY = auto()
    FRAMING = auto()
    BREAK = auto()


class Character(NamedTuple):
    value: int
    damage: Damage = Damage.NONE


BREAK = Character(0x00, Damage.BREAK)


class Line(Protocol):
    """What a UART's pins lead to. It calls `Uart.hear`."""

    def send(self, data: bytes, settings: Settings) -> None:
        """Take `data`, sent with `settings`."""

    def hold(self, low: bool) -> None:
        """Begin or end a break."""


class Uart:
    """One serial port of a chip.

    `buffer`: characters that wait for the host; more are lost, with an overrun. `log` has what the
    driver has set, in order.
    """

    def __init__(self, line: Line, buffer: int) -> None:
        self.line = line
        self.settings = Settings(rate=0.0)
        self.dtr = self.rts = self.is_low = False
        self.lost = 0
        self.log: list[str] = []
        self.heard: Callable[[Damage], None] = lambda damage: None
        """Called when something has come; set by the chip."""
        self.buffer = buffer
        """So many characters wait for the host; those behind them are lost."""
        self._to_lose = {"sent": 0, "received": 0}
        self._received: deque[Character] = deque()

    # -- the chip's side ---------------------------------------------------------------------------

    def set(self, rate: float | None = None, form: Form | None = None) -> None:
        """Change the rate, the form, or both."""
        before = self.settings
        now = Settings(before.rate if rate is None else rate, form or before.form)
        self.settings = now
        if str(now) != str(before):
            self.log.append(str(now))

    def set_modem(self, *, dtr: bool | None = None, rts: bool | None = None) -> None:
        before = self.dtr, self.rts
        self.dtr = self.dtr if dtr is None else dtr
        self.rts = self.rts if rts is None else rts
        if before != (self.dtr, self.rts):
            self.log.append(f"dtr={self.dtr:d} rts={self.rts:d}")

    def hold(self, low: bool) -> None:
        """Begin or end a break."""
        if low != self.is_low:
            self.is_low = low
            self.log.append(f"break {'on' if low else 'off'}")
            self.line.hold(low)

    def send(self, data: bytes) -> None:
        """Put `data` of the host on the line; during a break nothing goes out."""
        data = self._losing("sent", data)
        if data and not self.is_low and self.settings.rate:
            self.line.send(data, self.settings)

    def take(self, most: int) -> list[Character]:
        """Take up to `most` of the characters that wait for the host."""
        return [self._received.popleft() for _ in range(min(most, len(self._received)))]

    def purge(self) -> None:
        """Drop the characters that wait for the host."""
        self._received.clear()

    def __len__(self) -> int:
        """The number of characters that wait for the host."""
        return len(self._received)

    def __contains__(self, value: object) -> bool:
        """Whether a character of this value waits for the host."""
        return any(it.value == value for it in self._received)

    # -- the line's side ---------------------------------------------------------------------------

    def hear(self, data: bytes, settings: Settings) -> None:
        """Receive `data`, which the line carries with `settings`."""
        self.receive(sampled(data, settings, self.settings))

    def receive(self, characters: list[Character]) -> None:
        """Receive `characters` as they were sampled."""
        damage = Damage.NONE
        characters = self._losing("received", characters)
        for character in characters:
            damage |= character.damage
            if len(self._received) < self.buffer:
                self._received.append(character)
            else:
                self.lost += 1
                damage |= Damage.OVERRUN
                value, known = self._received[-1]
                self._received[-1] = Character(value, known | Damage.OVERRUN)
        if characters:
            self.heard(damage)

    # -- the test's side ---------------------------------------------------------------------------

    def lose(self, *, sent: int = 0, received: int = 0) -> None:
        """Lose the next bytes, as some chips do with the first ones after opening."""
        self._to_lose = {"sent": sent, "received": received}

    def _losing(self, way: str, data: T) -> T:
        lost = min(self._to_lose[way], len(data))
        self._to_lose[way] -= lost
        return data[lost:]


def sampled(data: bytes, sent: Settings, read: Settings) -> list[Character]:
    """Return the characters that a UART with settings `read` reads of `data`.

    The characters follow each other without a pause; before and after them the line is idle.
    """
    if not read.rate or not data:
        return []
    if read.fits(sent):
        return [Character(value) for value in data]
    levels = [level for value in data for level in levels_of(value, sent.form)]
    return list(Receiver(levels, sent.rate, read))


def levels_of(value: int, form: Form) -> list[bool]:
    """Return the levels of a character, bit by bit; one and a half stop bits count as two."""
    bits = [bool(value >> number & 1) for number in range(form.bits)]
    parity = [] if form.parity == "N" else [_parity(bits, form.parity)]
    return [False, *bits, *parity, *[True] * (2 if form.stop > 1 else 1)]


def _parity(bits: list[bool], kind: str) -> bool:
    odd = sum(bits) % 2 == 1
    return {"E": odd, "O": not odd, "M": True, "S": False}[kind]


class Receiver:
    """Samples `levels`, each of which lasts `1 / rate`, in the middle of its own bits."""

    def __init__(self, levels: list[bool], rate: float, read: Settings) -> None:
        self._levels, self._rate, self._read = levels, rate, read
        self._bit = 1 / read.rate

    def _level(self, time: float) -> bool:
        number = floor(time * self._rate + 1e-9)
        return self._levels[number] if 0 <= number < len(self._levels) else True

    def _next_start(self, after: float) -> float | None:
        """Return when the line next falls, at or after `after`."""
        for at in range(max(0, ceil(after * self._rate - 1e-9)), len(self._levels)):
            if not self._levels[at] and (at == 0 or self._levels[at - 1]):
                return at / self._rate
        return None

    def __iter__(self):
        form, bit = self._read.form, self._bit
        time = 0.0
        while (start := self._next_start(time)) is not None:
            if self._level(start + bit / 2):  # shorter than half a bit: noise
                time = start + bit / 2
                continue
            middles = [start + (number + 1.5) * bit for number in range(form.bits + 2)]
            bits = [self._level(at) for at in middles[: form.bits]]
            damage, stop_at = Damage.NONE, middles[form.bits]
            if form.parity != "N":
                if self._level(stop_at) != _parity(bits, form.parity):
                    damage |= Damage.PARITY
                stop_at = middles[form.bits + 1]
            if not self._level(stop_at):
                damage |= Damage.FRAMING if any(bits) else Damage.BREAK | Damage.FRAMING
            yield Character(sum(one << number for number, one in enumerate(bits)), damage)
            time = stop_at
