"""What the source leaves open, as switches of the virtual ECU (D3, D7, D10, D11, D12, D14).

A tester that works against every combination of these works against whatever a real unit does.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from difflib import get_close_matches
from enum import Enum

from mikas.commands import COMMANDS_BY_CODE
from mikas.errors import UsageError
from mikas.i18n import Text


class Unknown(Enum):
    """What a unit says to a command that it does not know (D10), or to a list too long for it."""

    SILENT = "silent"
    ERROR = "01"


class LongList(Enum):
    """What a unit does with more parameters than it takes (D11)."""

    SILENT = "silent"
    SHORT = "short"


class StreamEnd(Enum):
    """What makes a unit end its stream (D12): any byte heard, a whole request, or a line break."""

    BYTE = "byte"
    REQUEST = "request"
    BREAK = "break"


SWITCH = {"1": True, "on": True, "yes": True, "true": True,
          "0": False, "off": False, "no": False, "false": False}  # fmt: skip
"""What may stand for on and off."""

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
    """How this unit behaves where the source does not say. The defaults follow its letter."""

    turn_round: float = 0.002  # s from a request's last byte to the response's first, D14
    stream_gap: float = 0.0004  # s between two responses of a stream; §5 reckons with none
    max_list: int = 255  # most parameters in one 61, 64, 71, 7F–83; D11
    long_list: LongList = LongList.SILENT
    max_block: int = 255  # most bytes in one 21–26
    unknown: Unknown = Unknown.SILENT  # D10
    missing: frozenset[int] = field(default_factory=frozenset)  # command codes
    counted_blocks: bool = False  # 23, 25 repeat the count as 21 does, D7
    raw_checksum: bool = False  # D3
    stream_end: StreamEnd = StreamEnd.BYTE  # D12

    def with_options(self, options: Mapping[str, str]) -> EcuQuirks:
        """These, changed by `name=value` texts as they stand in a URL or on a command line."""
        changes = {name: _parse(name, value) for name, value in options.items()}
        return replace(self, **changes)  # type: ignore[arg-type]  # each parsed by its own name


ASSUMPTION_NAMES = tuple(f.name for f in fields(EcuQuirks))


def _parse(name: str, value: str) -> object:
    try:
        match name:
            case "turn_round" | "stream_gap":
                seconds = float(value)
                if not 0 <= seconds <= 10:
                    raise ValueError
                return seconds
            case "max_list" | "max_block":
                count = int(value)
                if not 1 <= count <= 255:
                    raise ValueError
                return count
            case "long_list":
                return LongList(value)
            case "unknown":
                return Unknown(value)
            case "stream_end":
                return StreamEnd(value)
            case "counted_blocks" | "raw_checksum":
                return SWITCH[value.lower()]
            case "missing":
                return _missing(value)
    except (ValueError, KeyError):
        allowed = _ALLOWED[name]
        raise UsageError(
            problem=Text(
                f"“{value}” is no value for {name}; allowed: {allowed}",
                f"«{value}» не подходит для {name}; можно: {allowed}",
            )
        ) from None
    nearest = ", ".join(get_close_matches(name, ASSUMPTION_NAMES) or ASSUMPTION_NAMES)
    raise UsageError(
        problem=Text(
            f"the virtual ECU has no switch “{name}”; there is {nearest}",
            f"у виртуального блока нет переключателя «{name}»; есть {nearest}",
        )
    )


_ALLOWED = {
    "turn_round": "0 … 10 (s)",
    "stream_gap": "0 … 10 (s)",
    "max_list": "1 … 255",
    "max_block": "1 … 255",
    "long_list": "silent, short",
    "unknown": "silent, 01",
    "stream_end": "byte, request, break",
    "counted_blocks": "0, 1",
    "raw_checksum": "0, 1",
    "missing": f"{', '.join(GROUPS)}, 61, 0x71 …",
}


def words(text: str) -> list[str]:
    """What a list on a command line or in a URL holds: `a,b`, `a+b`; in a URL `+` is a space."""
    return re.findall(r"[^,+\s]+", text)


def _missing(value: str) -> frozenset[int]:
    codes: set[int] = set()
    for word in words(value):
        if word in GROUPS:
            codes |= GROUPS[word]
        else:
            code = int(word, 16)
            if code not in COMMANDS_BY_CODE:
                raise ValueError
            codes.add(code)
    return frozenset(codes)
