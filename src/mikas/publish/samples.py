"""Every sample, several in a message: for a database, not for a display.

Each row is the time and a value for each name; a value that was not read in that cycle is None.
Rows are counted from 0: a reader sees by `first` what it has not got.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Final

from mikas.publish.message import Message, MessageKind, json_payload, rounded
from mikas.publish.values import Plain

_MOST_ROWS: Final = 1000  # in one message, however long the interval


class SampleBatch:
    """Collects rows for `topic`. `qos`: of the messages."""

    def __init__(self, topic: str, names: Sequence[str], qos: int) -> None:
        self._topic = topic
        self._names = tuple(names)
        self._qos = qos
        self._rows: list[list[Plain]] = []
        self._count = 0  # of all rows before these
        self._since = self._time = 0.0  # of the first row and of the last one
        self._session: float | None = None

    def add_row(self, time: float, values: Mapping[str, Plain]) -> None:
        """Add the row of the cycle of `time`, with its `plain_values`."""
        if self._session is None:
            self._session = rounded(time)
        if not self._rows:
            self._since = time
        self._rows.append([rounded(time), *map(values.get, self._names)])
        self._time = time

    @property
    def is_full(self) -> bool:
        """Whether the rows are to be sent before their interval is over."""
        return len(self._rows) >= _MOST_ROWS

    def messages(self) -> Iterator[Message]:
        """Yield the message of the rows so far, and begin the next one; none without rows."""
        if not self._rows:
            return
        rows, self._rows = self._rows, []
        first, self._count = self._count, self._count + len(rows)
        payload = json_payload(
            {"session": self._session, "first": first, "names": self._names, "samples": rows}
        )
        yield Message(
            *(self._topic, payload, MessageKind.SAMPLES, self._qos),
            time=self._time,
            rows=len(rows),
            since=self._since,
        )
