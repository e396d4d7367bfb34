"""What was learnt of the unit at hand: recalled when it is first needed, kept as it grows."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from contextlib import suppress

from mikas.client.identity import Passport
from mikas.client.limits import Limits, LimitsStore, MethodTiming
from mikas.errors import LineError, NoConnection

_ADAPTERS = 8  # kinds of adapter whose paces are kept for a unit: the latest


class LimitsCache:
    """The limits in force. `store`: where those of every unit are kept, by version and passport.

    The unit is asked for its passport only if there is anything to recall or to keep.
    """

    def __init__(
        self,
        store: LimitsStore | None,
        version_code: Callable[[], int],
        passport: Callable[[], Passport],
    ) -> None:
        self._store = store
        self._version_code = version_code
        self._passport = passport
        self._learning = threading.RLock()
        self._limits: Limits | None = None

    def limits(self) -> Limits:
        """Those in force, to be changed by who learns. May ask the unit, and raise what it does."""
        with self._learning:
            if self._limits is None:
                if self._store is None or self._store.empty:
                    self._limits = Limits()
                else:
                    self._limits = self._store.load(self._version_code(), self._passport().pieces)
            return self._limits

    def keep(self) -> None:
        """For the next session."""
        if self._store is not None and self._limits is not None:
            # What was read stands, even if the unit can't be asked now whose limits these are.
            with self._learning, suppress(LineError, NoConnection):
                self._store.save(self._version_code(), self._passport().pieces, self._limits)

    def learn_paces(self, adapter: str, paces: Mapping[str, MethodTiming]) -> None:
        """How fast each method is with this kind of adapter, instead of what was known of it."""
        with self._learning:
            kinds = self.limits().methods
            kinds.pop(adapter, None)
            while len(kinds) >= _ADAPTERS:
                del kinds[next(iter(kinds))]
            kinds[adapter] = dict(paces)
            self.keep()

    def forget(self) -> None:
        """All of it, kept or not."""
        with self._learning:
            self._limits = Limits()
            if self._store is not None:
                self._store.forget(self._version_code(), self._passport().pieces)

    def another_unit(self) -> None:
        """What is in force is another's."""
        with self._learning:
            self._limits = None
