"""Values of instruments beside the rows of the unit: decoded again from the recorded bytes.

A row has the last value that is not older than the definition says (`stale`), and that no loss of
the connection separates from the row; else none. The definition is the present one of that name, so
that a correction holds for old recordings, or that in the file where none is known here.
"""

from __future__ import annotations

from array import array
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from math import nan
from pathlib import Path

import numpy as np

from mikas.cancellation import check_cancelled
from mikas.catalog import Catalog, InstrumentChannel
from mikas.errors import UsageError
from mikas.instruments import (
    InstrumentDefinition,
    InstrumentValues,
    decoder_of,
    definition_named,
)
from mikas.instruments.timing import TimedInstrumentDecoder
from mikas.recording.capture.instruments import (
    instrument_packets,
    label_and_name,
    recorded_definition,
)
from mikas.recording.capture.reader import Packet, Source
from mikas.recording.exchanges.arrays import Floats
from mikas.recording.table.channels import Channel


@dataclass(slots=True)
class RawInstrument:
    """One instrument's chunks in a file, in their order, in as few bytes as they take there.

    A chunk without bytes: the connection began or was lost.
    """

    source: Source
    _times: array[float] = field(default_factory=lambda: array("d"))
    _ends: array[int] = field(default_factory=lambda: array("q"))
    _data: bytearray = field(default_factory=bytearray)

    def add(self, packet: Packet) -> None:
        """Take the next packet."""
        self._data += packet.data
        self._times.append(packet.time)
        self._ends.append(len(self._data))

    def chunks(self) -> Iterator[tuple[bytes, float]]:
        """Yield each chunk with its time."""
        begin = 0
        for time, end in zip(self._times, self._ends, strict=True):
            yield bytes(self._data[begin:end]), time
            begin = end

    @property
    def held(self) -> int:
        """About as many bytes of memory as it takes."""
        return len(self._data) + 16 * len(self._times)


def raw_instruments(path: Path) -> list[RawInstrument]:
    """Return the instruments of a file."""
    found: dict[Source, RawInstrument] = {}
    for packet in instrument_packets(path):
        if (raw := found.get(packet.source)) is None:
            raw = found[packet.source] = RawInstrument(packet.source)
        raw.add(packet)
    return list(found.values())


@dataclass(frozen=True, slots=True)
class InstrumentSamples:
    """The values of a channel in one session, in the order of time.

    `values`: NaN where the connection began or was lost. `stale`: seconds that a value holds.
    """

    times: Floats
    values: Floats
    stale: float

    def at(self, times: Floats) -> Floats:
        """Return the value at each of the times."""
        if not len(self.times):
            return np.full(len(times), nan)
        place = self.times.searchsorted(times, "right") - 1
        known = place >= 0
        at = np.maximum(place, 0)
        fresh = known & (times - self.times[at] <= self.stale)
        return np.where(fresh, self.values[at], np.nan)


class InstrumentColumns:
    """The channels of a file's instruments. `definitions`: those that replace the ones named so.

    `channels`: in the order of the file. `unread`: the instruments whose definition can't be used,
    with the reason. `described`: as `channels`, as the definitions describe them.
    """

    def __init__(
        self,
        found: Iterable[RawInstrument],
        catalog: Catalog,
        definitions: Sequence[InstrumentDefinition] = (),
    ) -> None:
        self._given = {each.name: each for each in definitions}
        self._catalog = catalog
        self.channels: dict[str, Channel] = {}
        self.described: list[InstrumentChannel] = []
        self.unread: list[tuple[Source, UsageError]] = []
        self._columns: dict[tuple[int, str], InstrumentSamples] = {}
        for raw in found:
            try:
                self._add(raw)
            except UsageError as error:
                self.unread.append((raw.source, error))

    def samples(self, session: int, name: str) -> InstrumentSamples | None:
        """Return the values of a channel in a session, with their own times; None without any."""
        return self._columns.get((session, name))

    def values(self, session: int, times: Floats, names: Iterable[str]) -> dict[str, Floats]:
        """Return a column for each of the `names` that are channels here."""
        missing = np.full(len(times), nan)
        return {
            name: missing if (found := self._columns.get((session, name))) is None
            else found.at(times)
            for name in names if name in self.channels
        }  # fmt: skip

    def _add(self, raw: RawInstrument) -> None:
        label, name = label_and_name(raw.source)
        definition = self._definition(name, raw.source)
        decoder = TimedInstrumentDecoder(decoder_of(definition), raw.source.byte_time)
        labelled = definition.labelled(label).channels
        names = dict(zip((each.name for each in definition.channels), labelled, strict=True))
        times: dict[str, list[float]] = {name: [] for name in names}
        values: dict[str, list[float]] = {name: [] for name in names}
        for data, arrived in raw.chunks():
            check_cancelled()
            if not data:
                decoder.drop()
                for name in names:
                    times[name].append(arrived)
                    values[name].append(nan)
            for event, time in decoder.feed(data, arrived):
                if isinstance(event, InstrumentValues):
                    for name, value in event.values.items():
                        times[name].append(time)
                        values[name].append(value)
        for name, channel in names.items():
            if channel.name not in self.channels:
                self.channels[channel.name] = instrument_column(channel)
                self.described.append(channel)
            column = _rising(times[name], values[name], definition.stale)
            self._columns.setdefault((raw.source.recording, channel.name), column)

    def _definition(self, name: str, source: Source) -> InstrumentDefinition:
        if name in self._given:
            return self._given[name]
        return recorded_definition(source, self._catalog)


def instrument_column(each: InstrumentChannel) -> Channel:
    """Return the column of a channel."""
    return Channel(each.name, each.unit, each.text, False, each.decimals, each.unit_text)


def _rising(times: Sequence[float], values: Sequence[float], stale: float) -> InstrumentSamples:
    """Return the column in the order of time, which a clock that was set may have changed."""
    at, found = np.array(times, np.float64), np.array(values, np.float64)
    order = at.argsort(kind="stable")
    return InstrumentSamples(at[order], found[order], stale)


def given_definitions(
    names: Iterable[str | InstrumentDefinition], catalog: Catalog
) -> Mapping[str, InstrumentDefinition]:
    """Return definitions by name, from names, files or themselves."""
    found = (
        each if isinstance(each, InstrumentDefinition) else definition_named(each, catalog)
        for each in names
    )
    return {each.name: each for each in found}
