"""The values: the latest of each channel, for as long as it may pass for the present one, or all.

A channel's value holds for a second after its reading, or for three of the channel's usual
intervals if these are longer (`NAME/10`, a slow method). After that, and at once when the line
breaks, the channel has no value: None, never the last number. A value of an instrument beside the
unit holds as long as its definition says: a sample without it has none.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from math import isfinite
from types import MappingProxyType
from typing import Final, NamedTuple, TypeAlias

from mikas.catalog import Derived, InstrumentChannel, Parameter
from mikas.client import Reading
from mikas.client.parameters.derived import DerivedValue
from mikas.i18n import Text
from mikas.instruments.reading import InstrumentReading
from mikas.publish.outbox import Message, MessageKind, json_payload, rounded
from mikas.sampling.events import Sampled
from mikas.sampling.gaps import Arrivals

Plain: TypeAlias = float | int | bool | None

_MOST_ROWS: Final = 1000  # in one message, however long the interval
_NEW: Final = 1.0  # s; a value that is older has its age in the message
_NONE: Final[Mapping[str, float]] = MappingProxyType({})


def unit_of(
    channel: Parameter | Derived | InstrumentChannel, interpretation: str
) -> tuple[str, Text]:
    """Return the unit of the channel's values, as the catalog names it and as a person reads it."""
    if isinstance(channel, Parameter):
        conversion = channel.interpretation(interpretation)
        return conversion.unit, conversion.unit_text
    return channel.unit, channel.unit_text


class Latest(NamedTuple):
    """Values by name, None where there is none, and the ages of those older than a second."""

    values: dict[str, Plain]
    ages: dict[str, float]

    @property
    def is_gap(self) -> bool:
        """Whether no channel has a value."""
        return all(value is None for value in self.values.values())


class LatestValues:
    """Follows the samples of the channels `names`; `beside`: those of instruments among them."""

    def __init__(self, names: Iterable[str], beside: Iterable[str] = ()) -> None:
        self._names = tuple(names)
        self._beside = frozenset(beside)
        self._read: dict[str, tuple[float, Plain]] = {}
        self._arrivals = {name: Arrivals() for name in self._names}
        self._ages: Mapping[str, float] = _NONE

    def add_sample(
        self, time: float, values: Mapping[str, Plain], ages: Mapping[str, float] = _NONE
    ) -> None:
        """Take the `plain_values` that were read in the cycle of `time`.

        `ages`: seconds by which the instruments' values are older.
        """
        for name in self._beside.difference(values):
            self._read.pop(name, None)
        for name, value in values.items():
            if (arrivals := self._arrivals.get(name)) is not None:
                self._read[name] = time, value
                arrivals.add(time)
        self._ages = ages

    def clear(self) -> None:
        """Forget all values: no unit answers, or another one does."""
        self._read.clear()
        for arrivals in self._arrivals.values():
            arrivals.interrupt()

    def at(self, now: float) -> Latest:
        """Return the values that hold at `now`."""
        values: dict[str, Plain] = {}
        ages: dict[str, float] = {}
        for name in self._names:
            time, value = self._read.get(name, (now, None))
            age = max(0.0, now - time)
            values[name] = value if age <= self._arrivals[name].longest_usual else None
            age += self._ages.get(name, 0.0)
            if age > _NEW and values[name] is not None:
                ages[name] = round(age, 1)
        return Latest(values, ages)


def plain_values(sample: Sampled) -> dict[str, Plain]:
    """Return the values of this cycle as JSON has them; a number that is none is None."""
    fresh: dict[str, Reading | DerivedValue | InstrumentReading] = {
        **sample.fresh, **sample.derived, **sample.instruments
    }  # fmt: skip
    return {name: each.value if isfinite(each.value) else None for name, each in fresh.items()}


class SampleBatch:
    """Collects every sample as rows for `topic`, several in a message; `qos`: of the messages.

    For a database, not for a display. Each row is the time and a value for each name; a value that
    was not read in that cycle is None. Rows are counted from 0: a reader sees by `first` what it
    has not got.
    """

    def __init__(self, topic: str, names: Sequence[str], qos: int) -> None:
        self._topic = topic
        self._names = tuple(names)
        self._qos = qos
        self._rows: list[tuple[float, list[Plain]]] = []
        self._count = 0  # of all rows before these
        self._since = self._time = 0.0  # of the first row and of the last one
        self._session: float | None = None

    def add_row(self, time: float, values: Mapping[str, Plain]) -> None:
        """Add the row of the cycle of `time`, with its `plain_values`."""
        if self._session is None:
            self._session = rounded(time)
        if not self._rows:
            self._since = time
        self._rows.append((time, [*map(values.get, self._names)]))
        self._time = time

    @property
    def is_full(self) -> bool:
        """Whether the rows are to be sent before their interval is over."""
        return len(self._rows) >= _MOST_ROWS

    def messages(self, later: float) -> Iterator[Message]:
        """Yield the message of the rows so far, and begin the next one; none without rows.

        `later`: seconds that are added to all times.
        """
        if not self._rows:
            return
        rows = [[rounded(time + later), *values] for time, values in self._rows]
        self._rows = []
        first, self._count = self._count, self._count + len(rows)
        payload = json_payload(
            {"session": self._session, "first": first, "names": self._names, "samples": rows}
        )
        yield Message(
            *(self._topic, payload, MessageKind.SAMPLES, self._qos),
            time=self._time + later,
            rows=len(rows),
            since=self._since + later,
        )
