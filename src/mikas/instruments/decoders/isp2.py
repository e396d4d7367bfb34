"""Innovate Serial Protocol 2: LC-1, LC-2, LM-2, MTX-L; a chain's first λ.

    B2 84  header: 1x11xx1L 1LLLLLLL, L words follow, of two bytes each
    43 13  010FFF1A 0AAAAAAA: F what the next word is, A ten times the stoichiometric ratio
    03 6B  00LLLLLL 0LLLLLLL: λ = 0.5 + L/1000 where F is 0

Only a header has the top bit in two bytes in a row, so a lost byte is found by the next one.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from mikas.i18n import Text
from mikas.instruments.events import (
    NOT_UNDERSTOOD,
    OUT_OF_RANGE,
    Fits,
    InstrumentEvent,
    InstrumentValues,
    NoValues,
)

CHANNELS: Final = ("LAMBDA", "AFR")
_HEADER: Final = 0xA2  # of its first byte
_IS_DATA: Final = 0x10  # else an answer to a command
_TOP: Final = 0x80
_MOST_SKIPPED: Final = 256  # bytes between two headers, shown as one event
_LM1_WORDS: Final = 8
_LEAN: Final = 1
_STATES: Final = {
    _LEAN: Text("leaner than can be measured", "беднее, чем измеряется"),
    2: Text("the sensor is calibrated in free air", "калибровка датчика на воздухе"),
    3: Text("the sensor needs a calibration in free air", "датчику нужна калибровка на воздухе"),
    4: Text("the sensor warms up", "датчик прогревается"),
    5: Text("the heater is calibrated", "калибровка подогрева"),
    6: Text("the controller reports an error", "контроллер сообщает об ошибке"),
    7: Text("a state that is not known here", "неизвестное состояние"),
}


class Isp2Decoder:
    """Decodes packets. `fits`: whether the channels can have these values."""

    def __init__(self, fits: Fits) -> None:
        self._fits = fits
        self._buffer = bytearray()
        self._begin = 0  # of the buffer, in bytes since the first
        self._skipped = bytearray()  # since the last packet

    def drop(self) -> None:
        """As `InstrumentDecoder.drop`."""
        self._begin += len(self._buffer)
        self._buffer.clear()
        self._skipped.clear()

    def feed(self, data: bytes) -> list[InstrumentEvent]:
        """As `InstrumentDecoder.feed`."""
        found: list[InstrumentEvent] = []
        for byte in data:
            self._buffer.append(byte)
            found += self._look()
        return found

    def _look(self) -> Iterator[InstrumentEvent]:
        """Yield what the last byte decides."""
        buffer = self._buffer
        while len(buffer) >= 2:
            if not _is_header(buffer):
                yield from self._skip()
                continue
            length = 2 + 2 * ((buffer[0] & 1) << 7 | buffer[1] & 0x7F)
            broken = len(buffer) > 2 and len(buffer) % 2 == 0 and buffer[-1] & _TOP
            if broken or length == 2:
                yield from self._skip()
                yield from self._skip()
                continue
            if len(buffer) < length:
                return
            packet = bytes(buffer[:length])
            yield from self._end_of_skipped()
            self._take(length)
            if packet[0] & _IS_DATA:
                yield self._packet(packet)

    def _packet(self, packet: bytes) -> InstrumentEvent:
        at = 2
        while at + 2 <= len(packet):
            first, second = packet[at], packet[at + 1]
            if first & _HEADER == _TOP:
                at += 2 * _LM1_WORDS
            elif first & 0xE2 == 0x42 and at + 4 <= len(packet):
                function = first >> 2 & 7
                if function:
                    return NoValues(self._begin, _STATES[function], packet)
                ratio = ((first & 1) << 7 | second) / 10
                value = 0.5 + ((packet[at + 2] & 0x3F) << 7 | packet[at + 3]) / 1000
                values = {"LAMBDA": value, "AFR": value * ratio}
                if self._fits(values):
                    return InstrumentValues(self._begin, values)
                return NoValues(self._begin, OUT_OF_RANGE, packet)
            else:
                at += 2
        return NoValues(self._begin, NOT_UNDERSTOOD, packet)

    def _skip(self) -> Iterator[InstrumentEvent]:
        """Pass the first byte over."""
        self._skipped.append(self._buffer[0])
        self._take(1)
        if len(self._skipped) == _MOST_SKIPPED:
            yield from self._end_of_skipped()

    def _end_of_skipped(self) -> Iterator[InstrumentEvent]:
        if self._skipped:
            yield NoValues(self._begin, NOT_UNDERSTOOD, bytes(self._skipped))
            self._skipped.clear()

    def _take(self, count: int) -> None:
        del self._buffer[:count]
        self._begin += count


def _is_header(data: bytearray) -> bool:
    return data[0] & _HEADER == _HEADER and bool(data[1] & _TOP)
