"""An instrument's definition and its bytes: a `CatalogError`, or a decoder that never fails.

Input: the chunks' seed, the definition's text, a zero byte, the instrument's bytes. In place of a
text, the number of a shipped definition. The events must be the same however the bytes are cut, and
each value one that its channel can have.
"""

from __future__ import annotations

from random import Random
from typing import Final

from mikas.errors import CatalogError
from mikas.instruments import (
    InstrumentDefinition,
    InstrumentValues,
    decoder_of,
    definition_named,
    definition_of_text,
)

WORDS: Final = (
    *('text = "x"\n', 'decoder = "line"\n', 'patterns = ["{AFR}"]\n', 'decimal = ","\n', "*", "{}"),
    *('[instrument.X]\ntext = "x"\n', "{X}", "range = [0, 1]\n", 'decoder = "nmea"\n', "\\", "{"),
    *("14.7\r\n", "0.98\n", "$GPRMC,1,A,5617.79,N,04356.1,E,20.0,84.4,230394,,,A*", "\xb2\x82"),
    *('{"class":"TPV","mode":3,"lat":1,"lon":2}\n', "1e999", "\x43\x13\x03\x6b"),
)
_SHIPPED: Final = ("aem", "14point7", "innovate", "nmea", "gpsd")


def check(data: bytes) -> None:
    if len(data) < 2:
        return
    text, _, wire = data[1:].partition(b"\0")
    if len(text) == 1:
        definition = definition_named(_SHIPPED[text[0] % len(_SHIPPED)])
    else:
        try:
            definition = definition_of_text("mine", text.decode("utf-8", "replace"))
        except CatalogError as error:
            _check_error(error)
            return
        assert definition_of_text("mine", definition.toml) == definition
    _decode(definition, wire, Random(data[0]))


def _check_error(error: CatalogError) -> None:
    assert error.line >= 0
    assert error.problem.ru


def _decode(definition: InstrumentDefinition, wire: bytes, random: Random) -> None:
    whole = decoder_of(definition).feed(wire)
    decoder, found, at = decoder_of(definition), [], 0
    while at < len(wire):
        length = random.randint(1, 40)
        found += decoder.feed(wire[at : at + length])
        at += length
    assert found == whole
    channels = {channel.name: channel for channel in definition.channels}
    for event in whole:
        assert 0 < event.end <= len(wire)
        if isinstance(event, InstrumentValues):
            assert all(channels[name].takes(value) for name, value in event.values.items())
