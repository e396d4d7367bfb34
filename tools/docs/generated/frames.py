"""Frames on the line (§2), drawn as SVG from what the encoder really gives.

A drawing is a card with a ground of its own, so that it is legible on any page, in any theme.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from html import escape
from itertools import groupby

from mikas.catalog import Catalog
from mikas.commands import (
    Availability,
    Datum,
    ReadParameters,
    StreamCyclic,
)
from mikas.framing import TERMINATOR, encode, stuff
from mikas.i18n import Language, Text

_BYTE, _HEIGHT, _LEFT, _LANE = 60, 34, 150, 76
_COLOURS = {
    "body": ("#d6e8f7", "#0b4f80"),
    "stuffed": ("#fbe3b5", "#7a4b00"),
    "checksum": ("#d5efe3", "#0d5a3c"),
    "end": ("#e3e5e8", "#3a4149"),
    "echo": ("#ffffff", "#5b6570"),
}
_WORDS = {
    "body": Text("body", "тело"),
    "stuffed": Text("stuffed", "замена"),
    "checksum": Text("checksum", "сумма"),
    "end": Text("end", "конец"),
    "echo": Text("echo", "эхо"),
}
_REQUEST = Text("request", "запрос")
_RESPONSE = Text("response", "ответ")


@dataclass(frozen=True, slots=True)
class _Byte:
    """A byte of a lane; `note`: a word under it, once for all neighbours that have the same."""

    value: int
    role: str
    note: str = ""


def drawings(catalog: Catalog, language: Language) -> Iterator[tuple[str, str]]:
    """Yield each drawing with its name."""
    for name, draw in (
        ("frame-exchange", _exchange),
        ("frame-stuffing", _stuffing),
        ("frame-echo", _echo),
        ("frame-stream", _stream),
    ):
        yield name, draw(catalog, language)


def _read(catalog: Catalog, *names: str) -> tuple[Datum, ...]:
    parameters = map(catalog.parameter, names)
    return tuple(Datum(each.code, each.size) for each in parameters)


def _raw(catalog: Catalog, **values: float) -> tuple[bytes, ...]:
    return tuple(catalog.parameter(name).encode(value) for name, value in values.items())


def _exchange(catalog: Catalog, language: Language) -> str:
    request = ReadParameters(_read(catalog, "TWAT"))
    data = _raw(catalog, TWAT=86)
    twat = catalog.parameter("TWAT")
    first, second = _wire(request.body(), language), _wire(request.respond(data), language)
    first[0] = _Byte(first[0].value, "body", _say("command", "команда", language))
    first[1] = _Byte(first[1].value, "body", "TWAT")
    raw = data[0][0]
    second[0] = _Byte(second[0].value, "body", _say("datum", "данные", language))
    total = " + ".join(f"{each.value:02X}" for each in first[:-1])
    summed = sum(each.value for each in first[:-1])
    return _svg(
        [
            _lane(0, _REQUEST.to(language), first),
            _aside(0, len(first), f"{total} = {summed:X}, mod 100 = {summed % 256:02X}"),
            _lane(1, _RESPONSE.to(language), second),
            _aside(
                1,
                len(second),
                f"{raw:02X} = {raw}; {twat.formula().replace('b', str(raw))} = 86 °C",
            ),
        ],
        lanes=2,
        title=_say("Read one parameter: 61", "Чтение одного параметра: 61", language),
    )


def _stuffing(catalog: Catalog, language: Language) -> str:
    request = ReadParameters(_read(catalog, "JQT"))
    body, answer = request.body(), request.respond(_raw(catalog, JQT=1.3))
    plain = _say("body", "тело", language)
    wire = _say("on the line", "на линии", language)
    parts = []
    for number, (name, each) in enumerate(((_REQUEST, body), (_RESPONSE, answer))):
        parts += [
            _lane(2 * number, f"{name.to(language)}: {plain}", [_Byte(it, "body") for it in each]),
            _lane(2 * number + 1, wire, _wire(each, language)),
        ]
    parts.append(_aside(0, len(body), f"40 → {stuff(b'@').hex(' ').upper()}"))
    parts.append(_aside(2, len(answer), f"0D → {stuff(bytes([TERMINATOR])).hex(' ').upper()}"))
    return _svg(
        parts,
        lanes=4,
        title=_say(
            "Byte stuffing: only the end of a frame is a bare 0D",
            "Замена байтов: голый 0D — только конец кадра",
            language,
        ),
    )


def _echo(catalog: Catalog, language: Language) -> str:
    request = ReadParameters(_read(catalog, "TWAT"))
    sent = _wire(request.body(), language)
    answer = _wire(request.respond(_raw(catalog, TWAT=86)), language)
    heard = [_Byte(each.value, "echo", _WORDS["echo"].to(language)) for each in sent]
    return _svg(
        [
            _lane(0, _say("tester sends", "тестер шлёт", language), sent),
            _lane(1, _say("tester hears", "тестер слышит", language), heard),
            _lane(1, "", answer, start=len(sent) + 1, note=_RESPONSE.to(language)),
            _pause(1, len(sent), "2 " + _say("ms", "мс", language)),
        ],
        lanes=2,
        title=_say(
            "One wire: the tester hears itself first (D1). A byte takes 1.04 ms",
            "Один провод: сначала тестер слышит сам себя (D1). Байт — 1,04 мс",
            language,
        ),
    )  # fmt: skip


def _stream(catalog: Catalog, language: Language) -> str:
    stream = StreamCyclic(_read(catalog, "TWAT", "FREQ"))
    asked = _wire(stream.body(), language)
    ended = _wire(Availability().body(), language)
    answered = _wire(Availability().respond(0x0A), language)
    again = [
        _wire(stream.respond(data), language)
        for data in (_raw(catalog, TWAT=86, FREQ=840), _raw(catalog, TWAT=86, FREQ=880))
    ]
    return _svg(
        [
            _lane(0, _say("tester", "тестер", language), asked),
            _lane(1, _say("unit", "блок", language), again[0]),
            _lane(1, "", again[1], start=len(again[0]) + 0.5,
                  note=_say("again and again", "снова и снова", language)),
            _lane(2, _say("tester", "тестер", language), ended,
                  note=_say("in a gap: the end (D12)", "в паузе: конец (D12)", language)),
            _lane(3, _say("unit", "блок", language), answered,
                  note=_say("Mikas 7.1", "Микас 7.1", language)),
        ],
        lanes=4,
        title=_say("A stream: 71", "Поток: 71", language),
    )  # fmt: skip


def _say(en: str, ru: str, language: Language) -> str:
    return Text(en, ru).to(language)


def _wire(body: bytes, language: Language) -> list[_Byte]:
    """Return the frame of a body, byte by byte, with what each byte is."""
    wire = encode(body)
    inside = len(stuff(body))
    found: list[_Byte] = []
    pair = False
    for place, value in enumerate(wire):
        role = "end" if place == len(wire) - 1 else "body" if place < inside else "checksum"
        if role == "body" and (pair or value == 0x40):
            pair = not pair
            role = "stuffed"
        found.append(_Byte(value, role, _WORDS[role].to(language)))
    return found


def _lane(
    row: float, label: str, data: Sequence[_Byte], *, start: float = 0, note: str = ""
) -> str:
    top = 52 + row * _LANE
    left = _LEFT + start * _BYTE
    parts = [_text(_LEFT - 14, top + 22, label, "end")] if label else []
    for place, each in enumerate(data):
        fill, ink = _COLOURS[each.role]
        x = left + place * _BYTE
        dashes = ' stroke-dasharray="4 3"' if each.role == "echo" else ""
        parts.append(
            f'<rect x="{x:g}" y="{top:g}" width="{_BYTE - 4}" height="{_HEIGHT}" rx="5" '
            f'fill="{fill}" stroke="{ink}"{dashes}/>'
            f'<text x="{x + (_BYTE - 4) / 2:g}" y="{top + 22:g}" class="b" fill="{ink}" '
            f'text-anchor="middle">{each.value:02X}</text>'
        )
    notes = [note] * len(data) if note else [each.note for each in data]
    place = 0
    for words, same in groupby(notes):
        count = len(list(same))
        middle = left + (place + count / 2) * _BYTE - 2
        parts += [_text(middle, top + 50, words, "middle", "n")] if words else []
        place += count
    return "".join(parts)


def _aside(row: float, after: int, words: str) -> str:
    return _text(_LEFT + after * _BYTE + 24, 52 + row * _LANE + 22, words, "start")


def _pause(row: float, after: int, words: str) -> str:
    return _text(_LEFT + (after + 0.46) * _BYTE, 52 + row * _LANE + 22, words, "middle", "n")


def _text(x: float, y: float, words: str, anchor: str, kind: str = "t") -> str:
    return f'<text x="{x:g}" y="{y:g}" class="{kind}" text-anchor="{anchor}">{escape(words)}</text>'


def _svg(parts: Sequence[str], *, lanes: int, title: str) -> str:
    width, height = 760, 52 + lanes * _LANE
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" '
        f'width="{width}" height="{height}" role="img">\n'
        f"<title>{escape(title)}</title>\n"
        "<style>.t,.h{font:14px system-ui,sans-serif;fill:#15191d}.h{font-weight:600}"
        ".n{font:12px system-ui,sans-serif;fill:#3a4149}"
        '.b{font:600 15px ui-monospace,"DejaVu Sans Mono",Consolas,monospace}</style>\n'
        f'<rect x="0.5" y="0.5" width="{width - 1}" height="{height - 1}" rx="8" fill="#fff" '
        'stroke="#c9ced4"/>\n'
        f"{_text(20, 30, title, 'start', 'h')}\n" + "\n".join(parts) + "\n</svg>\n"
    )
