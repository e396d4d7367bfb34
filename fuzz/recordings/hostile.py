"""Values that a stranger writes into a file: numbers, texts, JSON, and the notes made of them."""

from __future__ import annotations

import json
from collections.abc import Callable
from random import Random
from typing import Any, Final

from mikas.recording.capture.notes import Kind

TICKS: Final = (
    *(0, 1, 999_999, 1 << 31, (1 << 32) - 1, 1 << 32, 10**15, 1_700_000_000 * 10**6),
    *(253_402_300_800 * 10**6, 1 << 52, 1 << 53, (1 << 63) - 1, 1 << 63, (1 << 64) - 1),
)
LENGTHS: Final = (0, 1, 3, 4, 8, 11, 12, 13, 16, 20, 28, 32, 0xFFFF, 1 << 16, 1 << 24, 1 << 28)
WORDS: Final = (0, 1, 2, 3, 0x7F, 0x80, 0xFF, 0x100, 0x7FFF, 0xFFFF, 1 << 31, (1 << 32) - 1)

LONGEST: Final = 30_000  # bytes of a note

_TEXTS: Final = (
    *("", "hill", "гора", "\ud800", "a\udfffb", "\x00", "\x1b[2J\x1b]52;c;bWlrYXM=\x07", "\r\n"),
    *("\x9b31m", "\u202eabc\u2066", "\u2028", "\ufffe\uffff", "<script>alert(1)</script>"),
    *("=cmd|' /C calc'!A0", "../../etc/passwd", "x" * 5000, "e\u0301" * 300, "🔧" * 200, "nan"),
    *(
        '"',
        "'",
        "\\",
        ";",
        ",",
        "%s{0}{name}",
        "\t",
        "1e999",
        "</style>",
        "&amp;",
        "0A",
        "FF",
        "-1",
    ),
)
_NUMBERS: Final = (
    *("0", "-0.0", "1", "-1", "0.5", "13", "255", "256", "1e15", "253402300799", "253402300800"),
    *("1e18", "-1e18", "1e308", "-1e308", "5e-324", "1e999", "-1e999", "NaN", "Infinity"),
    *("9" * 30, "9" * 400, "-" + "9" * 5000, "18446744073709551616", "1700000000.25", "3e9"),
)
_FIELDS: Final = {
    Kind.UNIT: ("version_code", "passports", "adapter", "baud", "echo"),
    Kind.CATALOG: ("version",),
    Kind.PLAN: ("method", "names", "every", "max_list", "reading"),
    Kind.NOTE: ("text",),
    Kind.MARKER: ("label",),
    Kind.GAP: ("began", "ended", "reason"),
    Kind.STATE: ("state", "text", "reason"),
    Kind.ADAPTER: ("port", "before"),
    Kind.ALARM: ("channel", "level", "before", "better", "side", "value", "limit", "text"),
    Kind.LEARNT: (
        *("max_list", "max_block", "refused", "methods", "method", "rates", "dropped", "returned"),
    ),
    Kind.FAULTS: ("readings", "time", "codes", "erased"),
    "about": ("text",),
    "\x1b[31mlater": ("text",),
}
_STATES: Final = ("no-port", "no-echo", "echo-only", "ecu-alive", "sampling", "\x1b", "")


def note(random: Random) -> bytes:
    """Return a note's JSON of at most `LONGEST` bytes, each of its fields good or hostile."""
    while len(made := _note(random)) > LONGEST:
        pass
    return made


def _note(random: Random) -> bytes:
    if random.random() < 0.05:
        return _deep(random).encode()
    kind = random.choice(list(_FIELDS))
    fields = [name for name in _FIELDS[kind] if random.random() < 0.85]
    fields += random.choices(["x", "", "time", "kind", "\ud800"], k=random.choice((0, 0, 0, 1)))
    data = ",".join(f"{_quoted(name)}:{_field(random, name)}" for name in fields)
    whole = [
        f'"kind":{_quoted(kind) if random.random() < 0.95 else value(random)}',
        f'"time":{number(random)}',
        f'"data":{{{data}}}' if random.random() < 0.97 else f'"data":{value(random)}',
    ]
    if random.random() < 0.05:
        del whole[random.randrange(3)]
    text = "{" + ",".join(whole) + "}"
    return text.encode("utf-8", random.choice(("surrogatepass", "replace")))


def number(random: Random) -> str:
    """Return a number as JSON has it, or nearly."""
    if random.random() < 0.5:
        return repr(round(random.uniform(0, 20), 6))
    return random.choice(_NUMBERS)


def value(random: Random, depth: int = 0) -> str:
    """Return any JSON."""
    kind = random.randrange(12)
    if kind < 4:
        return number(random)
    if kind < 8:
        return _quoted(random.choice(_TEXTS))
    if kind < 9 or depth > 3:
        return random.choice(("null", "true", "false"))
    if kind < 10:
        return _deep(random) if random.random() < 0.1 else "{}"
    items = [value(random, depth + 1) for _ in range(random.choice((0, 1, 2, 8, 100)[: 5 - depth]))]
    if kind < 11:
        return f"[{','.join(items)}]"
    return "{" + ",".join(f"{_quoted(random.choice(_TEXTS))}:{it}" for it in items) + "}"


def text(random: Random) -> str:
    """Return a text with what no screen or file can take."""
    return random.choice(_TEXTS)


def _field(random: Random, name: str) -> str:
    if random.random() < 0.4:
        return value(random)
    make = _PLAUSIBLE.get(name)
    return make(random) if make else _quoted(random.choice(_TEXTS))


def _deep(random: Random) -> str:
    many = random.choice((10, 200, 900, 1200, 4000))
    opening, closing = random.choice((("[", "]"), ('{"a":', "}")))
    return opening * many + random.choice(("", "1")) + closing * random.choice((many, many, 0))


def _quoted(text: str) -> str:
    return json.dumps(text, ensure_ascii=len(text) % 2 == 0)


def _list(make: Callable[[Random], str], most: int = 8) -> Callable[[Random], str]:
    def made(random: Random) -> str:
        count = random.choice((0, 1, 2, most, most, 50 * most)[: random.choice((5, 5, 5, 6))])
        return f"[{','.join(make(random) for _ in range(count))}]"

    return made


def _both(random: Random) -> str:
    en, ru = _quoted(random.choice(_TEXTS)), _quoted(random.choice(_TEXTS))
    return f'{{"en":{en},"ru":{ru}}}'


def _any_text(random: Random) -> str:
    return _quoted(random.choice(_TEXTS))


def _one_of(*texts: Any) -> Callable[[Random], str]:
    return lambda random: json.dumps(random.choice(texts))


def _reading(random: Random) -> str:
    codes = _list(number, 12)(random)
    return f'{{"time":{number(random)},"codes":{codes},"erased":{value(random)}}}'


_PLAUSIBLE: Final[dict[str, Callable[[Random], str]]] = {
    "version_code": _one_of("0A", "05", "FF", "100", "", None, 10),
    "passports": _list(_any_text),
    "baud": number,
    "echo": _one_of(True, False, None, 1),
    "names": _list(_one_of("TWAT", "FREQ", "\ud800", "\x1b", 1)),
    "every": _list(number),
    "max_list": number,
    "began": number,
    "ended": number,
    "reason": _both,
    "text": lambda random: _both(random) if random.random() < 0.5 else _any_text(random),
    "state": _one_of(*_STATES),
    "channel": _one_of("TWAT", "FREQ", "UACC", "nothing", "\x1b[2J"),
    "level": _one_of("warn", "alarm", "", "normal", 1),
    "side": _one_of("low", "high", None),
    "value": number,
    "limit": number,
    "method": _one_of("list", "stream", "batch", "single", "\x1b"),
    "rates": lambda random: f'{{"list":{number(random)},"\\ud800":{number(random)}}}',
    "dropped": _one_of("TWAT", "\ud800"),
    "returned": _one_of("TWAT", "\ud800"),
    "refused": _list(number),
    "readings": _list(_reading, 5),
    "codes": _list(number, 12),
    "time": number,
}
