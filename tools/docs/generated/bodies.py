"""A body in words, by the layouts that decoders have: `address 40, byte 45`."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, get_args

from mikas.catalog import Catalog, Conversion
from mikas.commands.unit import passport_text
from mikas.i18n import Language, Text, unit_after
from tools.docs.generated.tables import number

_COUNT_PARAMETERS, _READ_LIST, _WRITE_LIST = 0x60, 0x63, 0x64
_LABELS = {
    "address": Text("address", "адрес"),
    "count": Text("count", "число"),
    "bytes": Text("bytes", "байты"),
    "code": Text("code", "код"),
    "datum": Text("datum", "данные"),
}
_BYTE = Text("byte", "байт")
_FAULTS = Text("faults:", "ошибки:")
_NO_FAULTS = Text("no faults", "ошибок нет")
_EMPTY = Text("empty", "пусто")
_DONE, _ERROR = Text("done", "выполнено"), Text("error ([D17](#d17))", "ошибка ([D17](#d17))")
_NO_COMMAND = Text("none of [§3](#s3)", "такой в [§3](#s3) нет")


def number_of(conversion: Conversion, raw: bytes) -> str:
    """Return the raw number, with a true minus."""
    signed = int.from_bytes(raw, "little", signed=conversion.signed)
    return str(signed).replace("-", "−")


def with_unit(value: float, unit: Text, language: Language) -> str:
    """Return a value as it is read: `840 rpm`; a flag as 1 or 0."""
    shown = Text(*(number(value, each) for each in get_args(Language)))
    return f"{shown.to(language)} {unit_after(shown, unit).to(language)}".rstrip()


class Meanings:
    """The meaning of requests and responses of one unit, in one language.

    `tables`: those of `tables_of`. A 63 is read by the list of the latest 64, as in the unit.
    """

    def __init__(self, tables: dict[str, Any], catalog: Catalog, language: Language) -> None:
        self.known: dict[int, dict[str, Any]] = tables["commands"]
        self._catalog = catalog
        self._language = language
        self._list = b""

    def request(self, body: bytes) -> str:
        """Return the command's title, and what it is about."""
        command = self.known.get(body[0])
        if command is None:
            return self._say(_NO_COMMAND)
        if body[0] == _WRITE_LIST:
            self._list = body[1:]
        said = ", ".join(self._parts(command, command["request"], body[1:], body))
        return f"{command['title']}: {said}" if said else str(command["title"])

    def response(self, request: bytes, body: bytes) -> str:
        """Return the contents of a response that fits its request."""
        command = self.known[request[0]]
        return ", ".join(self._parts(command, command["responses"][0], body, request))

    def _parts(
        self, command: dict[str, Any], layout: list[str], body: bytes, request: bytes
    ) -> Iterator[str]:
        rest, count = body, 0
        for part in layout:
            size = {"address": command["address_bytes"], "bytes": count}.get(part, 1)
            if part in ("codes", "values", "datum", "faults", "text"):
                size = len(rest)
            data, rest = rest[:size], rest[size:]
            if part == "count":
                count = data[0]
            elif part == "bytes" and not count:
                data, rest = data + rest, b""
            yield self._part(part, data, request)

    def _part(self, part: str, data: bytes, request: bytes) -> str:
        if part in _LABELS:
            return f"{self._say(_LABELS[part])} {self._shown(part, data)}"
        match part:
            case "value":
                return str(data[0]) if request[0] == _COUNT_PARAMETERS else self._byte(data)
            case "codes":
                return self._names(data)
            case "values":
                codes = self._list if request[0] == _READ_LIST else request[1:]
                return ", ".join(self._values(codes, data))
            case "model":
                return self._catalog.model(data[0]).text.to(self._language)
            case "faults":
                numbers = " ".join(map(str, data[1::2]))
                return f"{self._say(_FAULTS)} {numbers}" if numbers else self._say(_NO_FAULTS)
            case "text":
                text = passport_text(data.rstrip(b"\x00"))
                return f"“{text}”" if text else self._say(_EMPTY)
            case "result":
                return self._say(_ERROR if data[0] else _DONE)
        raise ValueError(part)

    def _shown(self, part: str, data: bytes) -> str:
        match part:
            case "address":
                return data[::-1].hex().upper()
            case "count":
                return str(data[0])
            case "code":
                return self._names(data)
        return data.hex(" ").upper()

    def _byte(self, data: bytes) -> str:
        return f"{self._say(_BYTE)} {data.hex().upper()}"

    def _names(self, codes: bytes) -> str:
        return ", ".join(
            "/".join(each.name for each in self._catalog.by_code(code)) or f"{code:02X}"
            for code in codes
        )

    def _values(self, codes: bytes, data: bytes) -> Iterator[str]:
        for code in codes:
            size = self._catalog.size_of(code) or 1
            raw, data = data[:size], data[size:]
            for parameter in self._catalog.by_code(code):
                value = parameter.conversion.decode(raw)
                yield f"{parameter.name} {with_unit(value, parameter.unit_text, self._language)}"

    def _say(self, text: Text) -> str:
        return text.to(self._language)
