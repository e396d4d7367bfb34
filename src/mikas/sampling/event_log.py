"""The logger `mikas.sampling`, at INFO: states, units, methods, refused parameters, gaps.

Values and single failed cycles are not logged; the frames are, by `mikas.tester` at DEBUG.
"""

from __future__ import annotations

import logging

from mikas.sampling.events import (
    Event,
    MethodChosen,
    ParameterDropped,
    Sampled,
    StateChanged,
    UnitFound,
)
from mikas.sampling.gaps import GapTracker

_logger = logging.getLogger("mikas.sampling")
_logger.addHandler(logging.NullHandler())


class EventLogger:
    """Logs one run of a sampler. With the logger off, an event costs one comparison."""

    def __init__(self) -> None:
        self._gaps = GapTracker()

    def take(self, event: Event) -> None:
        """Log `event`, and the gap that begins or ends with it."""
        if not _logger.isEnabledFor(logging.INFO):
            return
        for gap in self._gaps.take(event):
            reason = gap.reason.en if gap.reason else "unknown"
            if gap.ended is None:
                _logger.info("gap began: %s", reason)
            else:
                _logger.info("gap ended after %.1f s: %s", gap.ended - gap.began, reason)
        if not isinstance(event, Sampled):
            self._log(event)

    def _log(self, event: Event) -> None:
        match event:
            case StateChanged(text=text, reason=reason):
                _logger.info("state: %s%s", text.en, f" ({reason.en})" if reason else "")
            case UnitFound(version_code=code, passport=passport, another=another):
                pieces = ", ".join(filter(None, passport.pieces)) if passport else ""
                new = "another unit" if another else "unit"
                _logger.info("%s: version %02X, passport: %s", new, code or 0, pieces or "none")
            case MethodChosen(method=method, rates=rates):
                measured = ", ".join(f"{name} {rate:.1f}/s" for name, rate in rates.items())
                _logger.info("method: %s%s", method, f" (measured: {measured})" if measured else "")
            case ParameterDropped(name=name):
                _logger.info("the unit refuses %s", name)
            case _:
                pass
