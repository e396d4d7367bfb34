"""How long to wait, and when a response came (D14)."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Timing:
    """How long to wait, in seconds (D14).

    `first_byte`: from the end of a request to its response. `between_bytes`: silence inside a
    response after which the rest does not come. `quiet`: silence that counts as a quiet line where
    nothing can be under way any more. `babble`: how long to wait for that on a line that is not.
    """

    first_byte: float = 0.5
    between_bytes: float = 0.02
    quiet: float = 0.06
    babble: float = 1.0

    @property
    def late(self) -> float:
        """From the end of a request: when a response that has not come no longer comes (D13)."""
        return 2 * self.first_byte


@dataclass(frozen=True, slots=True)
class Reply:
    """A response: its body, the bytes on the wire, and the link's time of its begin and end."""

    body: bytes
    wire: bytes
    began: float
    ended: float
