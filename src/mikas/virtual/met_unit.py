"""A virtual unit that behaves as one that was met: its quirks, identity and codes, by the profile.

The engine is the model's, so the data of §4's codes agree with each other and with a scenario. The
data of other codes, and of those with another size than §4's, are the profile's samples.
"""

from __future__ import annotations

from dataclasses import replace
from math import inf
from typing import Any, Final

from mikas import commands as c
from mikas.virtual.profiles.form import SILENT
from mikas.virtual.quirks import ChecksumForm, EcuQuirks, Unknown
from mikas.virtual.responder import Car, Identity
from mikas.virtual.unit_profile import CodeProfile, Moves, UnitProfile

_RAISED: Final = 3000.0  # rpm of the last sample of a code that follows the engine's speed
_APART: Final = 0.001  # s; a cycle lasts 20 ms at 6,000 rpm
# Responses a cycle: up to there it is taken for one, for two; more are four, one each stroke.
_ONCE: Final = 1.5
_TWICE: Final = 3.0
_RAREST: Final = 0.01  # responses a cycle; a survey of some seconds sees none of rarer ones


def quirks_of(profile: UnitProfile) -> EcuQuirks:
    """Return the behaviour of the unit; the source's letter where it was not found out."""
    found: dict[str, Any] = {
        name: getattr(profile, name)
        for name in (
            "turn_round", "turn_round_spread", "inter_byte", "least_pause", "max_list_61",
            "max_list_64", "max_list_71", "long_list", "max_block", "bad_write", "counted_blocks",
            "accepts", "stream_end", "stream_gap", "stream_load",
        )
    }  # fmt: skip
    if profile.unknown is not None and profile.unknown != SILENT:
        found |= {"unknown": Unknown.ERROR, "unknown_body": bytes.fromhex(profile.unknown)}
    if profile.sends is not None:
        found["raw_checksum"] = profile.sends is ChecksumForm.RAW
    known = {name: value for name, value in found.items() if value is not None}
    return replace(EcuQuirks(missing=profile.missing), **known)


def identity_of(profile: UnitProfile, usual: Identity) -> Identity:
    """Return what the unit says of itself; `usual` where that was not found out or not agreed."""
    read = profile.passports or (None,) * len(usual.passports)
    passports = tuple(
        own if text is None else text for text, own in zip(read, usual.passports, strict=True)
    )
    version = usual.version_code if profile.version_code is None else profile.version_code
    return Identity(version, passports, profile.parameter_count)


class MetCar:
    """`car` with the codes of a unit that was met; implements `mikas.virtual.responder.Car`."""

    def __init__(self, car: Car, profile: UnitProfile) -> None:
        self.car = car
        codes, strokes = profile.codes, profile.strokes
        self._sampled = {
            code: each for code, each in (codes or {}).items() if car.size_of(code) != each.size
        }
        self._strokes = strokes or {}
        self._written: dict[int, bytes] = {}
        self.codes: tuple[int, ...] = car.codes if codes is None else tuple(codes)
        self._known = frozenset(self.codes)

    @property
    def faults(self) -> list[int]:
        """The stored faults, in the unit's order."""
        return self.car.faults

    @faults.setter
    def faults(self, codes: list[int]) -> None:
        self.car.faults = codes

    def size_of(self, code: int) -> int | None:
        """Return the size of the datum as the unit gave it; None: it did not know the code."""
        if code in self._sampled:
            return self._sampled[code].size
        return self.car.size_of(code) if code in self._known else None

    def raw(self, code: int, now: float) -> bytes:
        """Return the engine's datum, or the sample that fits the engine's state."""
        if code not in self._sampled:
            return self.car.raw(code, now)
        return self._written.get(code) or self._sample(self._sampled[code], now)

    def _sample(self, profile: CodeProfile, now: float) -> bytes:
        samples = profile.samples or (bytes(profile.size),)
        match profile.moves:
            case Moves.CONSTANT:
                return samples[0]
            case Moves.KEY:
                return samples[-1 if self.car.engine_speed(now) > 0 else 0]
            case Moves.RPM:
                share = min(1.0, self.car.engine_speed(now) / _RAISED)
                return samples[round(share * (len(samples) - 1))]
            case Moves.OTHER:
                return samples[int(now) % len(samples)]

    def write(self, code: int, data: bytes) -> bool:
        """Keep `data` until the next power cycle."""
        if code not in self._sampled:
            return self.car.write(code, data)
        self._written[code] = data
        return True

    def powered(self, now: float) -> bool:
        """Return whether the ignition is on."""
        return self.car.powered(now)

    def next_change(self, after: float) -> float:
        """Return when the key is turned next."""
        return self.car.next_change(after)

    def engine_speed(self, now: float) -> float:
        """Return the rpm of the engine."""
        return self.car.engine_speed(now)

    def next_stroke(self, stroke: int, after: float) -> float:
        """Return when the unit next responds at this stroke: as often a turn as it did (D15)."""
        rate = self._strokes.get(c.StreamAtStroke.CODES[stroke])
        if rate is None:
            return self.car.next_stroke(stroke, after)
        return self._at_rate(max(1, stroke), 2 * rate, after)  # stroke 0 begins as 1 does

    def _at_rate(self, stroke: int, in_cycle: float, after: float) -> float:
        """Return the next of `in_cycle` responses a cycle, or of one in several cycles."""
        if in_cycle < _RAREST:
            return inf
        if in_cycle > _ONCE:
            apart = 2 if in_cycle < _TWICE else 1
            strokes = {(stroke - 1 + more) % 4 + 1 for more in range(0, 4, apart)}
            return min(self.car.next_stroke(each, after) for each in strokes)
        time = after
        for _ in range(max(1, round(1 / in_cycle))):
            time = self.car.next_stroke(stroke, time) + _APART
        return time - _APART

    def power_cycle(self) -> None:
        """Forget written data."""
        self._written.clear()
        self.car.power_cycle()
