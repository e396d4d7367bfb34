"""What was learnt about one unit: how long a list and a block it takes (D11), what it lacks (D10),
and how fast each sampling method is with each kind of adapter.

Kept in the user's state folder under the unit's passports, so that the next session begins with it.
`LimitsCache` has the limits of the connected unit: loaded when first needed, saved as they change.
"""

from __future__ import annotations

import json
import threading
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import asdict, dataclass, field, replace
from hashlib import sha256
from math import isfinite
from pathlib import Path
from typing import Any

from mikas.commands import LARGEST_BLOCK
from mikas.errors import LineError, NoConnection

STARTING_LIST = 64  # far over the 21 codes of §4, and a request of 66 bytes is still only 70 ms

_ADAPTERS = 8  # kinds of adapter whose timings are kept for a unit: the latest
# What reading a file can raise that holds anything but limits.
_NO_LIMITS = (ValueError, TypeError, LookupError, AttributeError, ArithmeticError, RecursionError)


@dataclass(frozen=True, slots=True)
class MethodTiming:
    """How a method of sampling did, with lists of `codes` parameters.

    `delay`: the seconds that each response took beyond its bytes and its request's: the unit's
    turn-round, the adapter's lumps, the system. None: the unit does not take the method.
    """

    codes: int
    delay: float | None


@dataclass(slots=True)
class Limits:
    """The bounds in force, found by halving."""

    max_list: int = STARTING_LIST
    max_block: dict[str, int] = field(default_factory=dict)  # by memory space; 1: byte by byte
    refused: list[int] = field(default_factory=list)  # parameter codes that it does not know
    methods: dict[str, dict[str, MethodTiming]] = field(default_factory=dict)
    """By kind of adapter, then by method: one that lumps bytes turns their order round."""

    def block(self, space: str) -> int:
        """The largest block of `space` that is tried."""
        return self.max_block.get(space, LARGEST_BLOCK)

    def copy(self) -> Limits:
        """As they are now."""
        return replace(
            self,
            max_block=dict(self.max_block),
            refused=list(self.refused),
            methods={adapter: dict(paces) for adapter, paces in self.methods.items()},
        )

    @property
    def learnt(self) -> bool:
        """Whether anything differs from what every unit starts with."""
        return self != Limits()


class LimitsStore:
    """The limits of every unit met, a file each."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    @property
    def empty(self) -> bool:
        """Whether nothing was ever saved: then no unit has to be asked for its passport."""
        with suppress(OSError):
            return not any(self.folder.glob("*.json"))
        return True

    def load(self, version_code: int, passports: tuple[str, ...]) -> Limits:
        """Load what was learnt of this unit; a file that can't be read counts as nothing learnt."""
        with suppress(OSError, *_NO_LIMITS):
            stored = json.loads(self._file(version_code, passports).read_text("utf-8"))
            limits = Limits(
                max_list=min(max(int(stored["max_list"]), 1), STARTING_LIST),
                max_block={
                    str(space): min(max(int(count), 1), LARGEST_BLOCK)
                    for space, count in stored["max_block"].items()
                },
                refused=[int(code) for code in stored["refused"]],
                methods={
                    str(adapter): {str(method): _pace(pace) for method, pace in paces.items()}
                    for adapter, paces in stored.get("methods", {}).items()
                },
            )
            # An earlier version kept all of it.
            return limits if any(passports) else Limits(methods=_working(limits.methods))
        return Limits()

    def save(self, version_code: int, passports: tuple[str, ...], limits: Limits) -> None:
        """Save `limits`. A failure costs only time in the next session, so it is not reported.

        Units with empty passports can't be distinguished. Of them only timings are saved, which
        the first cycles of a session check.
        """
        if not any(passports):
            limits = Limits(methods=_working(limits.methods))
        with suppress(OSError):
            self.folder.mkdir(parents=True, exist_ok=True)
            kept = self._file(version_code, passports)
            fresh = kept.with_suffix(".new")
            fresh.write_text(
                json.dumps({"passports": passports, **asdict(limits)}, ensure_ascii=False), "utf-8"
            )
            fresh.replace(kept)

    def forget(self, version_code: int, passports: tuple[str, ...]) -> None:
        """Delete what was learnt of this unit; a file that can't be deleted stays in force."""
        with suppress(OSError):
            self._file(version_code, passports).unlink(missing_ok=True)

    def _file(self, version_code: int, passports: tuple[str, ...]) -> Path:
        named = "\0".join((f"{version_code:02X}", *passports))
        return self.folder / f"{sha256(named.encode()).hexdigest()[:16]}.json"


class LimitsCache:
    """The limits in force. `store`: where those of every unit are kept, by version and passport.

    `passport`: reads the unit's passport; called only if there is anything to load or to save.
    """

    def __init__(
        self,
        store: LimitsStore | None,
        version_code: Callable[[], int],
        passport: Callable[[], tuple[str, ...]],
    ) -> None:
        self._store = store
        self._version_code = version_code
        self._passport = passport
        self._lock = threading.RLock()
        self._limits: Limits | None = None

    def limits(self) -> Limits:
        """Return the limits, which the caller may change. May ask the unit for its passport, and
        raises what that raises.
        """
        with self._lock:
            if self._limits is None:
                if self._store is None or self._store.empty:
                    self._limits = Limits()
                else:
                    self._limits = self._store.load(self._version_code(), self._passport())
            return self._limits

    def keep(self) -> None:
        """Save the limits for the next session."""
        if self._store is not None and self._limits is not None:
            # What was read is valid, even if the unit's passport can't be read now.
            with self._lock, suppress(LineError, NoConnection):
                self._store.save(self._version_code(), self._passport(), self._limits)

    def keep_timings(self, adapter: str, timings: Mapping[str, MethodTiming]) -> None:
        """Replace what is known of this kind of adapter, and save it."""
        with self._lock:
            kinds = self.limits().methods
            kinds.pop(adapter, None)
            while len(kinds) >= _ADAPTERS:
                del kinds[next(iter(kinds))]
            kinds[adapter] = dict(timings)
            self.keep()

    def forget(self) -> None:
        """Forget all limits of this unit, the saved ones too."""
        with self._lock:
            self._limits = Limits()
            if self._store is not None:
                self._store.forget(self._version_code(), self._passport())

    def reset(self) -> None:
        """Forget which limits are in force: another unit is connected."""
        with self._lock:
            self._limits = None


def _working(methods: dict[str, dict[str, MethodTiming]]) -> dict[str, dict[str, MethodTiming]]:
    """Leave out the methods that a unit does not take: another unit may take them."""
    return {
        adapter: {method: pace for method, pace in paces.items() if pace.delay is not None}
        for adapter, paces in methods.items()
    }


def _pace(stored: dict[str, Any]) -> MethodTiming:
    codes, delay = int(stored["codes"]), stored["delay"]
    if delay is None:
        return MethodTiming(codes, None)
    if not (isfinite(delay) and delay >= 0):
        raise ValueError("a delay is not negative")
    return MethodTiming(codes, float(delay))


def default_folder() -> Path:
    """In the user's state folder."""
    from platformdirs import user_state_path

    return user_state_path("mikas", appauthor=False) / "units"
