"""Time-outs, and a response with its times (D14)."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Timing:
    """Time-outs in seconds (D14).

    `response_timeout`: from the end of a request to its response. `inter_byte_timeout`: silence
    inside a response after which the rest is given up. `idle_time`: silence that counts as a quiet
    line when no response is pending. `max_busy_time`: the longest wait for a busy line to go quiet.
    """

    response_timeout: float = 0.5
    inter_byte_timeout: float = 0.02
    idle_time: float = 0.06
    max_busy_time: float = 1.0

    @property
    def late(self) -> float:
        """From the end of a request: when a response that has not come no longer comes (D13)."""
        return 2 * self.response_timeout


@dataclass(frozen=True, slots=True)
class Reply:
    """A response: its body, the bytes on the wire, and the link's time of its begin and end."""

    body: bytes
    wire: bytes
    began: float
    ended: float
