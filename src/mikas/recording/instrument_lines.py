"""The messages of instruments beside the unit, one by one: `mikas decode` beside the unit's frames.

A message is text or bytes, with the values that its definition finds in it, or the reason why there
are none. `instrument_columns` makes columns of the same events.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Final

from mikas.catalog import Catalog, InstrumentChannel
from mikas.cleaning import clean_line
from mikas.errors import UsageError
from mikas.i18n import Language, Text
from mikas.instruments import InstrumentValues, decoder_of
from mikas.instruments.timing import TimedInstrumentDecoder
from mikas.json_values import json_of
from mikas.recording.capture.instruments import label_and_name, loss_of, recorded_definition
from mikas.recording.capture.reader import Packet, Source

SCHEMA: Final = 1
_MOST_BYTES: Final = 4096  # kept of a message; a line of gpsd has fewer
_SHOWN: Final = 100  # characters of a message on a terminal
_NO_VALUES: Final[Mapping[str, float]] = MappingProxyType({})
_UNREAD: Final = Text("without a definition", "описания нет")
_CONNECTED: Final = Text("connected", "подключён")
_LOST: Final = Text("lost: {why}", "связь потеряна: {why}")


@dataclass(frozen=True, slots=True)
class InstrumentMessage:
    """A message of the instrument `name`, with its label: `left:aem`.

    `values`: by the channel's name, in its unit; empty with a `reason`. `offset`: of the block in
    the file that ends it. Without `data` the connection began, or with a `reason` was lost.
    """

    source: Source
    name: str
    time: float
    offset: int
    data: bytes
    values: Mapping[str, float] = field(default_factory=dict)
    reason: Text | None = None
    channels: Mapping[str, InstrumentChannel] = field(default_factory=dict)

    @property
    def text(self) -> str | None:
        """The message as a line of text; None: it is none."""
        line = _last_line(self.data)
        return line.decode("ascii") if line and _is_text(line) else None


class InstrumentLines:
    """Decodes the packets of instruments in the order of a file; it never raises on input."""

    def __init__(self, catalog: Catalog) -> None:
        self._catalog = catalog
        self._ports: dict[Source, _Port] = {}

    def feed(self, packet: Packet) -> Iterator[InstrumentMessage]:
        """Yield the messages that a packet completes. To be exhausted."""
        if (port := self._ports.get(packet.source)) is None:
            port = self._ports[packet.source] = _Port(packet.source, self._catalog)
        yield from port.feed(packet)


class _Port:
    """One instrument. `_decoder` None: neither its definition nor another can be used."""

    def __init__(self, source: Source, catalog: Catalog) -> None:
        label, name = label_and_name(source)
        self._source, self._name = source, f"{label}:{name}" if label else name or "?"
        self._names: dict[str, str] = {}
        self._channels: dict[str, InstrumentChannel] = {}
        self._bytes = bytearray()  # since the end of the last message
        self._begin = 0  # of them, counted as the decoder counts
        self._reason: Text = _UNREAD
        self._decoder: TimedInstrumentDecoder | None = None
        try:
            definition = recorded_definition(source, catalog)
            self._decoder = TimedInstrumentDecoder(decoder_of(definition), source.byte_time)
        except UsageError as error:
            self._reason = error.reason
            return
        labelled = definition.labelled(label).channels
        for plain, channel in zip(definition.channels, labelled, strict=True):
            self._names[plain.name] = channel.name
            self._channels[channel.name] = channel

    def feed(self, packet: Packet) -> Iterator[InstrumentMessage]:
        if not packet.data:
            self._drop()
            yield self._message(packet, packet.time, b"", reason=loss_of(packet))
            return
        if self._decoder is None:
            yield self._message(packet, packet.time, packet.data, reason=self._reason)
            self._reason = _UNREAD
            return
        self._bytes += packet.data
        for event, time in self._decoder.feed(packet.data, packet.time):
            data = self._taken(event.end)
            if isinstance(event, InstrumentValues):
                values = {self._names[name]: value for name, value in event.values.items()}
                yield self._message(packet, time, _last_line(data), values)
            else:
                yield self._message(packet, time, event.data or data, reason=event.reason)
        if (more := len(self._bytes) - _MOST_BYTES) > 0:
            del self._bytes[:more]
            self._begin += more

    def _drop(self) -> None:
        self._begin += len(self._bytes)
        self._bytes.clear()
        if self._decoder is not None:
            self._decoder.drop()

    def _taken(self, end: int) -> bytes:
        """Return the bytes up to this place, and forget them."""
        count = max(0, end - self._begin)
        data = bytes(self._bytes[:count])
        del self._bytes[:count]
        self._begin += len(data)
        return data

    def _message(
        self,
        packet: Packet,
        time: float,
        data: bytes,
        values: Mapping[str, float] = _NO_VALUES,
        reason: Text | None = None,
    ) -> InstrumentMessage:
        known = (self._source, self._name, time, packet.offset)
        return InstrumentMessage(*known, data, values, reason, self._channels)


def message_json(it: InstrumentMessage) -> dict[str, object]:
    """Return a line of `mikas decode --json`: `type` is reading, or instrument without bytes."""
    line: dict[str, object] = {
        "schema": SCHEMA,
        "type": "reading" if it.data else "instrument",
        "recording": it.source.recording,
        "port": it.source.url,
        "instrument": it.name,
        "time": it.time,
        "offset": it.offset,
    }
    reason = json_of(it.reason)
    if not it.data:
        return line | {"state": "lost" if it.reason else "connected", "reason": reason}
    values = {name: round(value, 9) for name, value in it.values.items()}
    shown = {"data": it.data.hex().upper(), "text": it.text}
    return line | shown | {"values": values, "reason": reason}


def message_text(it: InstrumentMessage, language: Language = "en", *, zero: float = 0.0) -> str:
    """Return one line for a person: `    0.012500 = aem  “14.7”  LAMBDA=1.000λ AFR=14.70`."""
    parts = [f"{it.time - zero:12.6f} = {it.name}"]
    if not it.data:
        word = _LOST.filled(why=it.reason) if it.reason else _CONNECTED
        return "  ".join([*parts, word.to(language)])
    shown = it.data.hex(" ").upper() if it.text is None else it.text
    if len(shown) > _SHOWN:
        shown = f"{shown[:_SHOWN]}…"
    if it.text is not None:
        shown = Text(f"“{shown}”", f"«{shown}»").to(language)
    parts.append(shown if it.values else f"! {shown}")
    if it.reason is not None:
        parts.append(clean_line(it.reason.to(language)))
    if it.values:
        parts.append(" ".join(_value(it, name, language) for name in it.values))
    return "  ".join(parts)


def _value(it: InstrumentMessage, name: str, language: Language) -> str:
    channel = it.channels[name]
    number, unit = f"{it.values[name]:.{channel.decimals}f}", channel.unit_text.to(language)
    return f"{name}={number}{unit}"


def _last_line(data: bytes) -> bytes:
    """Return the last line of a text, which may begin in the middle of one; else all bytes."""
    lines = data.replace(b"\r", b"\n").strip(b"\n").split(b"\n")
    return lines[-1] if all(map(_is_text, lines)) else data


def _is_text(line: bytes) -> bool:
    return all(0x20 <= byte < 0x7F or byte == 0x09 for byte in line)
