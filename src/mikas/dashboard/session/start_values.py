"""The value of each parameter before it was first written: a person can go back to it (§3, 62).

Kept by unit in a file of the state folder, so that a start value survives a reload of the page
without installation, whose program ends with it. It is of one session: after `SESSION` without a
write the next one begins another. Of a unit without passports, and of a virtual one without
`virtual_units`, it stays until another unit answers or the program ends.
"""

from __future__ import annotations

import threading
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from mikas import unkept
from mikas.client.identity import UnitIdentity
from mikas.client.limits import unit_file
from mikas.i18n import Text
from mikas.sampling.events import UnitFound
from mikas.saving import KeptFile
from mikas.virtual import VIRTUAL_PASSPORT

SESSION: Final = 12 * 3600.0
"""Seconds after the last write, at the end of which a start value is dropped."""

_MOST_BYTES: Final = 1 << 20
_MOST_UNITS: Final = 100
_MOST_NAMES: Final = 300
_MOST_RAW: Final = 256  # bytes
_UNKEPT: Final = Text(
    "The values before a write can't be saved in {place} ({why}): going back to them is possible "
    "only until this program ends.",
    "Значения до записи не сохраняются в {place} ({why}): вернуться к ним можно только до "
    "завершения программы.",
)


@dataclass(frozen=True, slots=True)
class StartValue:
    """The bytes before the first write, when they were read, and when the last write was made."""

    raw: bytes
    read: float
    """The date of that reading."""
    written: float
    """The date of the last write."""


@dataclass(eq=False)
class StartValues:
    """The start values of the unit of the latest `begin_unit`, by parameter. Any thread may call.

    `_virtual_units`: whether those of virtual units are kept in the file as well.
    """

    _path: Path
    _virtual_units: bool = True

    def __post_init__(self) -> None:
        self._file: KeptFile[dict[str, dict[str, StartValue]]] = KeptFile(
            self._path, _MOST_BYTES, _units
        )
        self._lock = threading.Lock()
        self._key: str | None = None
        self._values: dict[str, StartValue] = {}

    def begin_unit(self, unit: UnitFound) -> None:
        """Hold the start values of `unit` from here on; also those so far, if it is the same."""
        key = self._key_of(UnitIdentity(unit.version_code, unit.passport))
        with self._lock:
            if unit.another:
                self._values, self._key = {}, None
            if key is None or key == self._key:
                return
            self._key = key
            self._values = (self._file.load() or {}).get(key, {}) | self._values

    def value(self, name: str, now: float) -> StartValue | None:
        """Return the start value of a parameter; None: it was not written in this session."""
        with self._lock:
            value = self._values.get(name)
        return value if value is not None and _is_current(value, now) else None

    def note(self, name: str, raw: bytes, now: float) -> None:
        """Note that a parameter with the bytes `raw` is about to be written."""
        with self._lock:
            values = {key: it for key, it in self._values.items() if _is_current(it, now)}
            first = values.pop(name, None) or StartValue(raw, now, now)
            values[name] = StartValue(first.raw, first.read, now)
            self._values = dict(list(values.items())[-_MOST_NAMES:])
            if self._key is not None:
                self._save(self._key)

    def _save(self, key: str) -> None:
        units = self._file.load() or {}
        units.pop(key, None)
        units[key] = self._values
        stored = {
            unit: {
                name: {"raw": it.raw.hex(), "read": it.read, "written": it.written}
                for name, it in values.items()
            }
            for unit, values in list(units.items())[-_MOST_UNITS:]
        }
        with unkept.saying_once(_UNKEPT, self._path):
            self._path.parent.mkdir(parents=True, exist_ok=True)
            self._file.save({"units": stored})

    def _key_of(self, unit: UnitIdentity) -> str | None:
        if unit.version_code is None or unit.passport is None:
            return None
        pieces = unit.passport.pieces
        if not any(pieces) or (VIRTUAL_PASSPORT in pieces and not self._virtual_units):
            return None
        return unit_file(Path(), unit.version_code, pieces).stem


def _is_current(value: StartValue, now: float) -> bool:
    return abs(now - value.written) < SESSION  # the computer's date may have been set back


def _units(stored: object) -> dict[str, dict[str, StartValue]]:
    """Return the content of the file. Raises `TypeError`, `ValueError`."""
    if not isinstance(stored, dict) or not isinstance(stored.get("units"), dict):
        raise TypeError("no units")
    return {str(key): _values(values) for key, values in stored["units"].items()}


def _values(stored: object) -> dict[str, StartValue]:
    if not isinstance(stored, dict):
        raise TypeError("no values")
    return {str(name): _value(value) for name, value in stored.items()}


def _value(stored: object) -> StartValue:
    if not isinstance(stored, dict):
        raise TypeError("no value")
    raw = stored.get("raw")
    if not isinstance(raw, str) or not 0 < len(raw) <= 2 * _MOST_RAW:
        raise TypeError("no bytes")
    return StartValue(bytes.fromhex(raw), _time(stored.get("read")), _time(stored.get("written")))


def _time(stored: object) -> float:
    if not isinstance(stored, int | float) or isinstance(stored, bool):
        raise TypeError("no time")
    return float(stored)
