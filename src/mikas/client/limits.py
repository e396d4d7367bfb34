"""The learnt limits of a unit: the longest list and block (D11), unknown parameters (D10), the
pause before a request (D14), and the speed of each sampling method with each kind of adapter.

`LimitsStore` keeps them in a folder under the unit's passports for the next session. `LimitsCache`
has those of the connected unit: loaded at first use, saved at each change.

A virtual unit has the limits that its settings give it, in each session others: a saved limit would
be wrong in the next one. In this process it is known by its link, on a pty or on TCP by its
passport. Passports given by a scenario or a recording (`sim --replay`) look like those of a car.
"""

from __future__ import annotations

import json
import os
import threading
from collections.abc import Callable, Mapping
from contextlib import suppress
from copy import deepcopy
from dataclasses import asdict, dataclass, field
from hashlib import sha256
from itertools import islice
from math import isfinite
from pathlib import Path
from typing import Any

from mikas import unkept
from mikas.commands import LARGEST_BLOCK
from mikas.errors import LineError, NoConnection
from mikas.files import read_json
from mikas.i18n import Text
from mikas.saving import save
from mikas.tester.pauses import LONGEST_PAUSE, Pauses
from mikas.virtual import VIRTUAL_PASSPORT

STARTING_LIST = 64  # far above the 21 codes of §4; a request of 66 bytes takes only 70 ms

_ADAPTERS = 8  # latest kinds of adapter whose timings are kept for a unit
_MOST_FILES = 1000  # looked into for `limits_any`
_MOST_BYTES = 1 << 18  # of a file; a unit with timings of eight adapters has 4 KB
_UNKEPT = Text(
    "What was learnt of this unit can't be saved in {place} ({why}): the next session takes the "
    "time to learn it anew.",
    "Выясненное об этом блоке (длины запросов, скорости) не сохраняется в {place} ({why}): в "
    "следующий раз на это снова уйдёт время.",
)
_NOT_FORGOTTEN = Text(
    "The limits of this unit can't be deleted in {place} ({why}): the next session takes them "
    "again.",
    "Пределы этого блока не удаляются из {place} ({why}): в следующий раз они снова будут "
    "действовать.",
)
# Errors of reading a file that holds no limits.
_NO_LIMITS = (ValueError, TypeError, LookupError, AttributeError, ArithmeticError, RecursionError)


@dataclass(frozen=True, slots=True)
class MethodTiming:
    """The speed of a sampling method with lists of `codes` parameters.

    `delay`: the seconds of each exchange beyond its bytes, spent by the unit, the adapter and the
    system. None: the unit does not support the method.
    """

    codes: int
    delay: float | None


@dataclass(slots=True)
class Limits:
    """The limits in force, found by halving.

    `max_block` is by memory space, 1 means byte by byte; `refused` has unknown parameter codes;
    `methods` is by kind of adapter, for an adapter that lumps bytes reverses their order.
    """

    max_list: int = STARTING_LIST
    """The most codes in one request (D11)."""
    max_block: dict[str, int] = field(default_factory=dict)
    """The most bytes of one block, by memory space; 1: byte by byte."""
    refused: list[int] = field(default_factory=list)
    """The codes that the unit does not know."""
    methods: dict[str, dict[str, MethodTiming]] = field(default_factory=dict)
    """The measured speed of each sampling method, by kind of adapter."""
    pause: float = 0.0
    """The least seconds from a response to the next request that the unit needs (D14), as found."""

    def block(self, space: str) -> int:
        """Return the largest block of `space` to request."""
        return self.max_block.get(space, LARGEST_BLOCK)

    def copy(self) -> Limits:
        """Return a deep copy."""
        return deepcopy(self)

    @property
    def learnt(self) -> bool:
        """Whether a limit differs from the starting values."""
        return self != Limits()


@dataclass(frozen=True, slots=True)
class LimitsStore:
    """The saved limits of every unit, a file each; of virtual ones only with `virtual_units`."""

    folder: Path
    virtual_units: bool = True

    @property
    def empty(self) -> bool:
        """Whether nothing was saved, so that no passport has to be read."""
        with suppress(OSError):
            return not any(self.folder.glob("*.json"))
        return True

    @property
    def limits_any(self) -> bool:
        """Whether lists or parameters of any unit are limited."""
        with suppress(OSError):
            files = list(islice(self.folder.glob("*.json"), _MOST_FILES + 1))
            return len(files) > _MOST_FILES or any(map(self._limits_lists, files))
        return False

    @property
    def longest_pause(self) -> float:
        """The longest pause that any saved unit needs: for one that is not identified yet."""
        with suppress(OSError):
            files = islice(self.folder.glob("*.json"), _MOST_FILES)
            return max(map(self._pause_of, files), default=0.0)
        return 0.0

    def _pause_of(self, file: Path) -> float:
        with suppress(OSError, *_NO_LIMITS):
            stored = read_json(file, _MOST_BYTES)
            if self._keeps(stored["passports"]):
                return _limits_of(stored).pause
        return 0.0

    def _limits_lists(self, file: Path) -> bool:
        with suppress(OSError, *_NO_LIMITS):
            stored = read_json(file, _MOST_BYTES)
            limits = _limits_of(stored)
            if limits.max_list < STARTING_LIST or limits.refused:
                return self._keeps(stored["passports"])
        return False

    def load(self, version_code: int, passports: tuple[str, ...]) -> Limits:
        """Load the limits of a unit; the starting values if its file is missing or invalid."""
        if self._keeps(passports):
            with suppress(OSError, *_NO_LIMITS):
                return _limits_of(
                    read_json(unit_file(self.folder, version_code, passports), _MOST_BYTES)
                )
        return Limits()

    def save(self, version_code: int, passports: tuple[str, ...], limits: Limits) -> None:
        """Save `limits`.

        Units with empty passports can't be distinguished: only timings are saved of them, which the
        first cycles of a session check.
        """
        if not self._keeps(passports):
            return
        if not any(passports):
            limits = Limits(methods=_working(limits.methods))
        with unkept.saying_once(_UNKEPT, self.folder):
            self.folder.mkdir(parents=True, exist_ok=True)
            file = unit_file(self.folder, version_code, passports)
            content = {"passports": passports, **asdict(limits)}
            save(file, json.dumps(content, ensure_ascii=False))

    def forget(self, version_code: int, passports: tuple[str, ...]) -> None:
        """Delete the limits of a unit; a file that can't be deleted stays in force."""
        file = unit_file(self.folder, version_code, passports)
        with unkept.saying_once(_NOT_FORGOTTEN, self.folder):
            if os.path.lexists(file):  # a disk that can't be written refuses an absent one, too
                file.unlink()

    def _keeps(self, passports: tuple[str, ...]) -> bool:
        return self.virtual_units or VIRTUAL_PASSPORT not in passports


def unit_file(folder: Path, version_code: int, passports: tuple[str, ...]) -> Path:
    """Return the file of a unit in `folder`."""
    named = "\0".join((f"{version_code:02X}", *passports))
    return folder / f"{sha256(named.encode()).hexdigest()[:16]}.json"


def _limits_of(stored: dict[str, Any]) -> Limits:
    """Return the limits in the JSON of a file. Raises the errors of `_NO_LIMITS`."""
    return Limits(
        max_list=min(max(int(stored["max_list"]), 1), STARTING_LIST),
        max_block={
            str(space): min(max(int(count), 1), LARGEST_BLOCK)
            for space, count in stored["max_block"].items()
        },
        refused=[code for each in stored["refused"] if 0 <= (code := int(each)) <= 0xFF],
        methods={
            str(adapter): {str(method): _timing(timing) for method, timing in each.items()}
            for adapter, each in stored.get("methods", {}).items()
        },
        pause=min(_seconds(stored.get("pause", 0.0)), LONGEST_PAUSE),
    )


def _seconds(stored: float) -> float:
    """Return `stored`, a number from 0 up. Raises `ValueError` or `TypeError`."""
    if not (isfinite(stored) and stored >= 0):
        raise ValueError("a time is not negative")
    return float(stored)


@dataclass(slots=True, eq=False)
class LimitsCache:
    """The limits of the connected unit.

    `identify` returns version code and passports; it is called only to load or to save in `store`.
    """

    _store: LimitsStore | None
    _identify: Callable[[], tuple[int, tuple[str, ...]]]
    _pauses: Pauses
    _lock: threading.RLock = field(init=False, default_factory=threading.RLock)
    _limits: Limits | None = field(init=False, default=None)

    def __post_init__(self) -> None:
        if self._store is not None and self._pauses.setting is None:
            self._pauses.assume(self._store.longest_pause)

    def limits(self) -> Limits:
        """Return the limits, which the caller may change. Raises the errors of `identify`."""
        with self._lock:
            if (limits := self._limits) is None:
                if self._store is None or self._store.empty:
                    limits = Limits()
                else:
                    limits = self._store.load(*self._identify())
                self._limits = limits
                self._pauses.assume(limits.pause)
            if self._pauses.found not in (None, limits.pause):
                limits.pause = self._pauses.found or 0.0
                self.keep()
            return limits

    @property
    def any_saved(self) -> bool:
        """Whether lists or parameters of any unit are limited, as saved."""
        return self._store is not None and self._store.limits_any

    def keep(self) -> None:
        """Save the limits for the next session."""
        if self._store is not None and self._limits is not None:
            # The limits are valid even if the passport can't be read now.
            with self._lock, suppress(LineError, NoConnection):
                unit = self._identify()
                if self._limits is not None:  # else it is another unit
                    self._store.save(*unit, self._limits)

    def keep_timings(self, adapter: str, timings: Mapping[str, MethodTiming]) -> None:
        """Replace and save the timings of this kind of adapter."""
        with self._lock:
            kinds = self.limits().methods
            kinds.pop(adapter, None)
            while len(kinds) >= _ADAPTERS:
                del kinds[next(iter(kinds))]
            kinds[adapter] = dict(timings)
            self.keep()

    def forget(self) -> None:
        """Delete all limits of this unit, the saved ones too."""
        with self._lock:
            self._limits = Limits()
            self._pauses.restart()
            if self._store is not None:
                self._store.forget(*self._identify())

    def reset(self) -> None:
        """Drop the cached limits: another unit is connected."""
        with self._lock:
            self._limits = None
            self._pauses.on_other_unit()


def _working(methods: dict[str, dict[str, MethodTiming]]) -> dict[str, dict[str, MethodTiming]]:
    """Leave out the methods that a unit does not support: another unit may support them."""
    return {
        adapter: {method: timing for method, timing in each.items() if timing.delay is not None}
        for adapter, each in methods.items()
    }


def _timing(stored: dict[str, Any]) -> MethodTiming:
    codes, delay = int(stored["codes"]), stored["delay"]
    if delay is None:
        return MethodTiming(codes, None)
    return MethodTiming(codes, _seconds(delay))
