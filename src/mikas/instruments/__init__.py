"""Instruments beside the unit: λ meters, GPS receivers, whatever sends lines of text.

    *.toml ──► loading ──► InstrumentDefinition ──► decoder_of ──► InstrumentDecoder
                                                       bytes ──► values, or why there are none

A definition is data; the four decoders (`decoders/`) are pure: bytes in, events out, in bounded
memory, and no bytes make them raise. The same decoder reads live bytes and those of a recording,
so a definition that is corrected next year corrects last year's drive.
"""

from mikas.instruments.decoding import decoder_of
from mikas.instruments.definition import InstrumentDefinition
from mikas.instruments.events import InstrumentDecoder, InstrumentValues, NoValues
from mikas.instruments.loading import definition_named, definition_names, definition_of_text

__all__ = [
    "InstrumentDecoder",
    "InstrumentDefinition",
    "InstrumentValues",
    "NoValues",
    "decoder_of",
    "definition_named",
    "definition_names",
    "definition_of_text",
]
