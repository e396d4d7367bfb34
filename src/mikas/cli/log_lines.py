"""The log on stderr, for `-vv`: frames (`mikas.tester`, DEBUG), states (`mikas.sampling`, INFO).

One plain line a record. On a terminal a line first clears the progress line that may stand there;
that is redrawn with the next value. `watch` prints lines instead of its table meanwhile.
"""

from __future__ import annotations

import logging
import sys
from collections.abc import Iterator
from contextlib import contextmanager

_CLEAR_LINE = "\r\x1b[K"


class StderrHandler(logging.Handler):
    """Writes to whatever stderr is at the time: rich and tests replace it."""

    def __init__(self) -> None:
        super().__init__()
        self.setFormatter(
            logging.Formatter("%(asctime)s.%(msecs)03d %(name)s: %(message)s", "%H:%M:%S")
        )

    def emit(self, record: logging.LogRecord) -> None:
        """Write one record; a broken stderr ends no command."""
        try:
            clear = _CLEAR_LINE if sys.stderr.isatty() else ""
            sys.stderr.write(f"{clear}{self.format(record)}\n")
            sys.stderr.flush()
        except (OSError, ValueError):
            self.handleError(record)


@contextmanager
def log_to_stderr() -> Iterator[None]:
    """Show the log of `mikas` while in the `with`."""
    logger, handler = logging.getLogger("mikas"), StderrHandler()
    level = logger.level
    logger.setLevel(logging.DEBUG)
    logger.addHandler(handler)
    try:
        yield
    finally:
        logger.removeHandler(handler)
        logger.setLevel(level)
