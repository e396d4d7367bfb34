"""From a definition to its decoder."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import suppress
from typing import Final, cast

from mikas.distributions import entries_of, loaded, unfit
from mikas.errors import UsageError, usage_error
from mikas.i18n import Text
from mikas.instruments.decoders import gpsd, isp2, nmea
from mikas.instruments.decoders.patterns import LinePattern
from mikas.instruments.decoders.text_lines import TextLineDecoder
from mikas.instruments.definition import InstrumentDefinition
from mikas.instruments.events import (
    Fits,
    InstrumentDecoder,
    InstrumentEvent,
    InstrumentValues,
    NoValues,
)

GROUP: Final = "mikas.instruments"
"""Entry points: another distribution's definitions and decoders."""
LINE: Final = "line"

_SHIPPED: Final[Mapping[str, Callable[[Fits], InstrumentDecoder]]] = {
    "nmea": nmea.NmeaDecoder,
    "isp2": isp2.Isp2Decoder,
    "gpsd": gpsd.GpsdDecoder,
}
CHANNELS: Final[Mapping[str, tuple[str, ...]]] = {
    "nmea": nmea.CHANNELS,
    "isp2": isp2.CHANNELS,
    "gpsd": nmea.CHANNELS,
}
"""What each decoder gives whose definition does not say it."""


def decoder_of(definition: InstrumentDefinition) -> InstrumentDecoder:
    """Return a decoder for one connection after another of this instrument.

    Its values are those of the definition's channels, before a label. Raises `UsageError` for
    another distribution's decoder that is not here or can't be loaded.
    """
    ranges = {channel.name: channel for channel in definition.channels}

    def fits(values: Mapping[str, float]) -> bool:
        return all(
            ranges[name].takes(value)
            for name, value in definition.completed(values).items()
            if name in ranges
        )

    if definition.decoder == LINE:
        patterns = tuple(LinePattern(each, definition.decimal) for each in definition.patterns)
        return _Completed(TextLineDecoder(patterns, fits), definition)
    if (make := _SHIPPED.get(definition.decoder)) is not None:
        return _Completed(make(fits), definition)
    return _Completed(_Guarded(_own(definition), definition.decoder), definition)


def _own(definition: InstrumentDefinition) -> InstrumentDecoder:
    """Return the decoder of another distribution."""
    entries = entries_of(GROUP).get(definition.decoder, [])
    if not entries:
        raise unknown_decoder(definition.decoder)
    found = loaded(definition.decoder, entries)
    try:
        decoder = cast("Callable[[], object]", found)()  # called to see
    except Exception as error:  # another distribution's code may raise anything
        why = f"{type(error).__name__}: {error}"
        problem = Text(f"makes no decoder ({why})", f"не создаёт декодер ({why})")
        raise unfit(definition.decoder, entries, problem) from error
    if not (hasattr(decoder, "feed") and hasattr(decoder, "drop")):
        problem = Text("makes no decoder: feed and drop are missing", "не декодер: нет feed и drop")
        raise unfit(definition.decoder, entries, problem)
    return cast("InstrumentDecoder", decoder)  # as far as can be seen: `_Guarded` has the rest


class _Completed:
    """A decoder whose values have λ and the ratio, and only the definition's channels."""

    def __init__(self, decoder: InstrumentDecoder, definition: InstrumentDefinition) -> None:
        self._decoder, self._definition = decoder, definition
        self._names = frozenset(channel.name for channel in definition.channels)

    def drop(self) -> None:
        """As `InstrumentDecoder.drop`."""
        self._decoder.drop()

    def feed(self, data: bytes) -> list[InstrumentEvent]:
        """As `InstrumentDecoder.feed`."""
        return [self._completed(event) for event in self._decoder.feed(data)]

    def _completed(self, event: InstrumentEvent) -> InstrumentEvent:
        if not isinstance(event, InstrumentValues):
            return event
        values = self._definition.completed(event.values)
        return InstrumentValues(
            event.end, {name: value for name, value in values.items() if name in self._names}
        )


class _Guarded:
    """Another distribution's decoder: what it raises is an event, and it begins again."""

    def __init__(self, decoder: InstrumentDecoder, name: str) -> None:
        self._decoder, self._name, self._count = decoder, name, 0

    def drop(self) -> None:
        """As `InstrumentDecoder.drop`."""
        with suppress(Exception):  # another distribution's code may raise anything
            self._decoder.drop()

    def feed(self, data: bytes) -> list[InstrumentEvent]:
        """As `InstrumentDecoder.feed`."""
        self._count += len(data)
        try:
            return list(self._decoder.feed(data))
        except Exception as error:  # another distribution's code may raise anything
            self.drop()
            why = f"{self._name}: {type(error).__name__}: {error}"
            return [NoValues(self._count, Text(why, why), data[:256])]


def unknown_decoder(name: str) -> UsageError:
    """Return the error of a decoder that is not here."""
    return usage_error(
        f"there is no decoder “{name}”; there are: {LINE}, {', '.join(_SHIPPED)}",
        f"декодера «{name}» нет; есть: {LINE}, {', '.join(_SHIPPED)}",
    )
