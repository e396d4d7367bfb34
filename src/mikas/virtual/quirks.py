"""Behaviour that the source does not define, as switches of the virtual ECU (D3, D7, D10–D12, D14,
D16, D17).

A tester must work with every combination of these switches.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from enum import Enum

from mikas.commands import COMMANDS_BY_CODE
from mikas.options import OptionParser, check_names, invalid_value


class Unknown(Enum):
    """The response to an unknown command (D10), or to too long a list."""

    SILENT = "silent"
    ERROR = "01"


class BadWrite(Enum):
    """The response to a write that the unit knows and can't do (D17)."""

    ERROR = "01"
    SILENT = "silent"


class LongList(Enum):
    """The response to a list longer than `max_list` (D11)."""

    SILENT = "silent"
    SHORT = "short"


class StreamEnd(Enum):
    """The end of a stream (D12): any byte received, a whole request, or a line break."""

    BYTE = "byte"
    REQUEST = "request"
    BREAK = "break"


class ChecksumForm(Enum):
    """The form of a checksum `0D` or `40` (D3): stuffed as the body is, as it is, or either."""

    STUFFED = "stuffed"
    RAW = "raw"
    BOTH = "both"


GROUPS: dict[str, frozenset[int]] = {
    "passports": frozenset(range(0x51, 0x59)),
    "bytes": frozenset({0x11, 0x12, 0x13, 0x14, 0x15, 0x16}),
    "blocks": frozenset(range(0x21, 0x27)),
    "sfr": frozenset({0x31, 0x32}),
    "goto": frozenset({0x41}),
    "count": frozenset({0x60}),
    "write": frozenset({0x62}),
    "list": frozenset({0x63, 0x64}),
    "stream": frozenset({0x71}),
    "stroke": frozenset({0x7F, 0x80, 0x81, 0x82, 0x83}),
}
"""Command groups that a unit may lack, by the name used in `missing=`."""


@dataclass(frozen=True, slots=True)
class EcuQuirks:
    """The unit's behaviour where the source does not specify it. The defaults follow its letter."""

    turn_round: float = 0.002  # s from a request's last byte to the response's first, D14
    turn_round_spread: float = 0.0  # s by which that differs at most, in either direction
    inter_byte: float = 0.0  # s between two bytes of a response beyond the wire's, D14
    least_pause: float = 0.0  # s; a request that begins sooner after a response is ignored, D14
    stream_gap: float = 0.0004  # s between two responses of a stream; §5 assumes 0
    stream_load: float = 0.1  # ms more for each 1,000 rpm, D16
    max_list: int = 255  # most parameters in one 61, 64, 71, 7F–83; D11
    max_list_61: int | None = None  # in one 61; None: as max_list, and so below
    max_list_64: int | None = None
    max_list_71: int | None = None  # also of 7F–83
    long_list: LongList = LongList.SILENT
    max_block: int = 255  # most bytes in one 21–26
    unknown: Unknown = Unknown.SILENT  # D10
    unknown_body: bytes = b"\x01"  # the response of a unit that is not silent
    bad_write: BadWrite = BadWrite.ERROR  # D17
    missing: frozenset[int] = field(default_factory=frozenset)  # command codes
    lacking: frozenset[int] = field(default_factory=frozenset)  # parameter codes
    extra: tuple[tuple[int, int], ...] = ()  # parameter codes beyond the car's, with their sizes
    counted_blocks: bool = False  # 23, 25 repeat the count as 21 does, D7
    raw_checksum: bool = False  # of what it sends, D3
    accepts: ChecksumForm = ChecksumForm.BOTH  # of what it receives, D3
    stream_end: StreamEnd = StreamEnd.BYTE  # D12

    def longest_list(self, code: int) -> int:
        """Return the most parameters in one request of this command (D11)."""
        own = {0x61: self.max_list_61, 0x64: self.max_list_64}.get(code, self.max_list_71)
        return self.max_list if own is None else own

    @property
    def extra_sizes(self) -> dict[int, int]:
        """The size of each extra code."""
        return dict(self.extra)

    def with_options(self, options: Mapping[str, str]) -> EcuQuirks:
        """Return these, changed by the texts of a URL or a command line."""
        check_names(options, QUIRK_NAMES)
        given = OptionParser(options)
        return EcuQuirks(
            turn_round=given.number("turn_round", self.turn_round, highest=10),
            turn_round_spread=given.number("turn_round_spread", self.turn_round_spread, highest=10),
            inter_byte=given.number("inter_byte", self.inter_byte, highest=1),
            least_pause=given.number("least_pause", self.least_pause, highest=10),
            stream_gap=given.number("stream_gap", self.stream_gap, highest=10),
            stream_load=given.number("stream_load", self.stream_load, highest=100),
            max_list=given.integer("max_list", self.max_list, lowest=1, highest=255),
            max_list_61=_longest(given, "max_list_61", self.max_list_61),
            max_list_64=_longest(given, "max_list_64", self.max_list_64),
            max_list_71=_longest(given, "max_list_71", self.max_list_71),
            long_list=given.member("long_list", self.long_list),
            max_block=given.integer("max_block", self.max_block, lowest=1, highest=255),
            unknown=given.member("unknown", self.unknown),
            unknown_body=_body(options["unknown_body"])
            if "unknown_body" in options
            else self.unknown_body,
            bad_write=given.member("bad_write", self.bad_write),
            missing=_missing(options["missing"]) if "missing" in options else self.missing,
            lacking=_lacking(options["lacking"]) if "lacking" in options else self.lacking,
            extra=_extra(options["extra"]) if "extra" in options else self.extra,
            counted_blocks=given.switch("counted_blocks", default=self.counted_blocks),
            raw_checksum=given.switch("raw_checksum", default=self.raw_checksum),
            accepts=given.member("accepts", self.accepts),
            stream_end=given.member("stream_end", self.stream_end),
        )


QUIRK_NAMES = tuple(f.name for f in fields(EcuQuirks))


def words(text: str) -> list[str]:
    """Return the items of a list in a URL or on a command line: `a,b`, `a+b`, `a b`."""
    return re.findall(r"[^,+\s]+", text)


def _longest(given: OptionParser, name: str, default: int | None) -> int | None:
    """Return the longest list that is given; 0: none is, and `max_list` is in force."""
    return given.integer(name, default or 0, lowest=0, highest=255) or None


def _body(value: str) -> bytes:
    if not re.fullmatch("([0-9a-fA-F]{2}){1,255}", value):
        raise invalid_value("unknown_body", value, "01, 7F10 …")
    return bytes.fromhex(value)


def _code(word: str) -> int | None:
    return int(word, 16) if re.fullmatch("(0x)?[0-9a-fA-F]{1,2}", word) else None


def _lacking(value: str) -> frozenset[int]:
    codes = [_code(word) for word in words(value)]
    if None in codes:
        raise invalid_value("lacking", value, "1A, 0x29 …")
    return frozenset(code for code in codes if code is not None)


def _extra(value: str) -> tuple[tuple[int, int], ...]:
    sizes: dict[int, int] = {}
    for word in words(value):
        name, colon, size = word.partition(":")
        code = _code(name)
        fits = re.fullmatch("[1-9][0-9]{0,2}", size) if colon else True
        if code is None or not fits or int(size or 1) > 255:
            raise invalid_value("extra", value, "33, 0x34:2 …")
        sizes[code] = int(size or 1)
    return tuple(sizes.items())


def _missing(value: str) -> frozenset[int]:
    codes: set[int] = set()
    for word in words(value):
        code = _code(word)
        if word in GROUPS:
            codes |= GROUPS[word]
        elif code in COMMANDS_BY_CODE:
            codes.add(code)
        else:
            raise invalid_value("missing", value, f"{', '.join(GROUPS)}, 61, 0x71 …")
    return frozenset(codes)
