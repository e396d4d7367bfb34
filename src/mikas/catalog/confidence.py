"""How well a statement of the catalog is known."""

from __future__ import annotations

from enum import StrEnum


class Confidence(StrEnum):
    """How well a statement is known."""

    CONFIRMED = "confirmed"  # two independent public sources
    REPORTED = "reported"  # one source
    UNCONFIRMED = "unconfirmed"  # commonly printed, no source seen
    UNKNOWN = "unknown"  # nothing is known; only the number is shown
