"""One MQTT message, and what becomes of it while the broker is away."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from typing import Any, Final

from mikas.cleaning import terminal_json

SCHEMA: Final = 1


class MessageKind(Enum):
    """What becomes of a message that the broker can't get at once."""

    RETAINED = "the latest of its topic is sent with each connection; the broker keeps it"
    LIVE = "dropped: later it would pass for a present value; while waiting, the latest counts"
    EVENT = "kept in order"
    SAMPLES = "kept in order as long as there is room"


@dataclass(frozen=True, slots=True)
class Message:
    """A `payload` for `topic`. `time`: of the link's clock.

    `rows`: samples in it, of which `since` is the first one's time and `time` the last one's.
    """

    topic: str
    payload: bytes
    kind: MessageKind
    qos: int = 1
    time: float | None = None
    rows: int = 0
    since: float | None = None

    @property
    def retain(self) -> bool:
        """Whether the broker gives it to later subscribers."""
        return self.kind is MessageKind.RETAINED


def json_payload(value: Mapping[str, Any]) -> bytes:
    """Return one JSON object with its schema. Raises `ValueError` for a number that is none."""
    return compact({"schema": SCHEMA, **value})


def compact(value: object) -> bytes:
    """Return `value` as JSON without blanks, with escapes for all that would steer a terminal."""
    text = json.dumps(value, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    return terminal_json(text).encode()


def rounded(time: float | None) -> float | None:
    """Return a time of the link's clock as in all JSON of mikas: to a microsecond."""
    return None if time is None else round(time, 6)
