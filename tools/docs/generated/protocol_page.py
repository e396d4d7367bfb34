"""The worked bytes of the protocol's page (§3.5, §4.1), from the vectors in `conformance/`, and §6.

The page itself is a document that people edit; only the tables between two comments are made here.
A command that no vector shows is encoded by the product's codec, and its line is marked.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from typing import NamedTuple

from mikas.catalog import Catalog, Conversion
from mikas.commands import Datum, StreamAtStroke, StreamCyclic
from mikas.dissectors.tables import tables_of
from mikas.framing import encode
from mikas.i18n import Language, Text
from tools.docs.generated import evidence_page
from tools.docs.generated.bodies import Meanings, number_of, with_unit
from tools.docs.generated.places import filled
from tools.docs.generated.tables import code, table
from tools.docs.pages import DOCS, ROOT, RUSSIAN

MADE = "⚙"
STROKES = range(5)

_FAMILIES: tuple[tuple[Text, bytes], ...] = (
    (Text("Availability, faults and their erasure", "Доступность, ошибки и их сброс"), b"\x01\x02"),
    (Text("RAM", "RAM"), b"\x11\x12\x21\x22"),
    (Text("XRAM", "XRAM"), b"\x13\x14\x23\x24"),
    (Text("CODE", "CODE"), b"\x15\x16\x25\x26\x41"),
    (Text("Special function registers", "Регистры специальных функций"), b"\x31\x32"),
    (Text("Passports", "Паспорта"), bytes(range(0x51, 0x59))),
    (Text("Parameters", "Параметры"), b"\x60\x61\x62\x63\x64"),
    (Text("Streams", "Потоки"), b"\x71\x7f\x80\x81\x82\x83"),
)
_ERASE = (b"\x62\x0e\x08", b"\x62\x0e\x00")
_REQUEST = Text("request", "запрос")
_RESPONSE = Text("response", "ответ")
_SILENCE = Text("no response", "ответа нет")
_UNKNOWN = Text("An unknown command", "Неизвестная команда")
_AGAIN = Text(
    "again, until the stream is ended ([D12](#d12))",
    "снова, пока поток не прервут ([D12](#d12))",
)
_YES, _NO = Text("yes", "да"), Text("no", "нет")


class Exchange(NamedTuple):
    """A request and its responses: bodies, each with its message; `made`: by no vector."""

    request: tuple[bytes, bytes]
    responses: tuple[tuple[bytes, bytes], ...]
    made: bool = False

    @property
    def code(self) -> int:
        """The command's code."""
        return self.request[0][0]


def protocol(catalog: Catalog, language: Language) -> str:
    """Return the page with its tables as the vectors and the catalog have them now."""
    file = ROOT / (RUSSIAN if language == "ru" else DOCS) / "protocol.md"
    made = {
        "commands": lambda: commands(catalog, language),
        "parameters": lambda: parameters(catalog, language),
        "evidence": lambda: evidence_page.bases(catalog, language),
    }
    return filled(file.read_text("utf-8"), made)


def commands(catalog: Catalog, language: Language) -> str:
    """Return a table for each family of commands."""
    meanings = Meanings(tables_of(catalog, language), catalog, language)
    headers = (
        "||body|on the line|meaning",
        "||тело|на линии|смысл",
    )
    shown: set[int] = set()
    parts = []
    for title, exchanges in _by_family(catalog):
        rows = [row for each in exchanges for row in _rows(each, meanings, language, shown)]
        parts.append(f"**{title.to(language)}**\n\n{table(language, headers, rows)}")
    return "\n".join(parts)


def _rows(
    exchange: Exchange, meanings: Meanings, language: Language, shown: set[int]
) -> Iterator[tuple[str, ...]]:
    first = exchange.code
    name = f"[{first:02X}](#cmd-{first:02x})" if first in meanings.known else f"{first:02X}"
    if first not in shown and first in meanings.known:
        name = f'<a id="bytes-{first:02x}"></a>{name}'
    shown.add(first)
    mark = f" {MADE}" if exchange.made else ""
    body, wire = exchange.request
    yield name + mark, _REQUEST.to(language), *_shown(body, wire), meanings.request(body)
    for count, (answer, message) in enumerate(exchange.responses):
        said = meanings.response(body, answer)
        if count and answer == exchange.responses[0][0]:
            said = _AGAIN.to(language)
        yield mark.strip(), _RESPONSE.to(language), *_shown(answer, message), said
    if not exchange.responses:
        yield mark.strip(), _SILENCE.to(language), "", "", ""


def _shown(body: bytes, wire: bytes) -> tuple[str, str]:
    return code(body.hex(" ").upper()), code(wire.hex(" ").upper())


def _by_family(catalog: Catalog) -> Iterator[tuple[Text, list[Exchange]]]:
    """Yield the exchanges of each family, in the order of the vectors."""
    every = [each for each in vectors() if not _is_one_of_many(each)]
    every += streams(catalog)
    known = b"".join(codes for _, codes in _FAMILIES)
    for title, codes in _FAMILIES:
        yield (
            title,
            [
                each
                for each in every
                if (each.code in codes and each.request[0] not in _ERASE)
                or (codes[:1] == b"\x01" and each.request[0] in _ERASE)
            ],
        )
    yield _UNKNOWN, [each for each in every if each.code not in known]


def _is_one_of_many(exchange: Exchange) -> bool:
    """Whether it is a 61 of one code, but for the first: §4.1 has them."""
    body = exchange.request[0]
    return len(body) == 2 and body[0] == 0x61 and body != b"\x61\x1a"


def vectors() -> Iterator[Exchange]:
    """Yield the exchanges of `conformance/exchanges.json`, in their order."""
    for each in json.loads((ROOT / "conformance/exchanges.json").read_text("utf-8")):
        pair = (each["answer"], each["answer_wire"])
        yield Exchange(
            (bytes.fromhex(each["request"]), bytes.fromhex(each["request_wire"])),
            () if pair[0] is None else ((bytes.fromhex(pair[0]), bytes.fromhex(pair[1])),),
        )


def streams(catalog: Catalog) -> Iterator[Exchange]:
    """Yield a stream of each kind, which no vector shows, and the end of the first (D12)."""
    wanted = [catalog.parameter(name) for name in ("TWAT", "FREQ")]
    asked = tuple(Datum(each.code, each.size) for each in wanted)
    data = tuple(each.encode(value) for each, value in zip(wanted, (86, 840), strict=True))

    def made(body: bytes, *responses: bytes) -> Exchange:
        every = (body, *responses)
        request, *answers = ((each, encode(each)) for each in every)
        return Exchange(request, tuple(answers), made=True)

    cyclic = StreamCyclic(asked)
    answer = cyclic.respond(data)
    yield made(cyclic.body(), answer, answer)
    for stroke in STROKES:
        by_stroke = StreamAtStroke(asked, stroke)
        yield made(by_stroke.body(), answer)


def parameters(catalog: Catalog, language: Language) -> str:
    """Return each parameter's exchange, computed to its value."""
    headers = (
        "parameter|request on the line|response on the line|raw|computed|value",
        "параметр|запрос на линии|ответ на линии|исходное|вычисление|значение",
    )
    singles = {
        each.request[0][1]: each
        for each in vectors()
        if len(each.request[0]) == 2 and each.code == 0x61
    }
    rows = []
    for parameter in catalog.parameters:
        exchange = singles.get(parameter.code)
        if parameter.source != "§4" or exchange is None:
            continue
        ((body, wire),) = exchange.responses
        conversion = parameter.conversion
        value = conversion.decode(body)
        shown = (_YES if value else _NO).to(language) if isinstance(value, bool) else None
        rows.append(
            (
                f"[{parameter.name}](#p-{parameter.name.lower()})",
                code(exchange.request[1].hex(" ").upper()),
                code(wire.hex(" ").upper()),
                f"{code(body.hex(' ').upper())}: {number_of(conversion, body)}",
                _computed(conversion, body, language),
                shown or with_unit(value, parameter.unit_text, language),
            )
        )
    return table(language, headers, rows)


def _computed(conversion: Conversion, body: bytes, language: Language) -> str:
    """Return the formula with the raw number in it: `125 − 40`."""
    raw = f"0x{body[0]:02X}" if conversion.mask else number_of(conversion, body)
    formula = re.sub(r"\b[bsw]\b", raw, conversion.formula)
    if language == "ru":
        formula = re.sub(r"(?<=\d)\.(?=\d)", ",", formula)
    return formula
