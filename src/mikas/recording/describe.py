"""What the frames of a capture mean: requests and responses in words (§3, §4).

Follows the lists that 64 sets, because a response to 63 can't be read without. A response that its
request can't read gets no meaning: better nothing than something wrong.
"""

from __future__ import annotations

from typing import Any

from mikas import commands as c
from mikas.catalog import Catalog
from mikas.errors import MikasError
from mikas.language import Text

_DATA = (c.ReadParameters, c.ReadList, c.StreamCyclic, c.StreamAtStroke)


class Describer:
    """Turns one capture's frames into texts; keep one for each line that was captured."""

    def __init__(self, catalog: Catalog, reading: str = "corrected") -> None:
        self._catalog = catalog
        self._reading = reading
        self._list: tuple[c.Datum, ...] = ()

    def __call__(self, request: bytes, response: bytes | None) -> Text | None:
        """What `request` asks, or what `response` answers to it."""
        command = self._command(request)
        if command is None:
            return None
        if response is None:
            return command.TITLE
        try:
            value = command.read(response)
        except MikasError as error:
            return error.reason
        if isinstance(command, c.WriteList):
            self._list = command.parameters
        return self._said(command, value)

    def _command(self, request: bytes) -> c.Command[Any] | None:
        if request == b"\x63":
            return c.ReadList(self._list) if self._list else None
        try:
            return c.parse(request, self._catalog.size_of)
        except c.MalformedRequest:
            return None

    def _said(self, command: c.Command[Any], value: Any) -> Text | None:  # noqa: ANN401  (as it answers)
        match command:
            case c.Availability():
                return self._catalog.model(value).text
            case c.ReadFaults():
                numbers = " ".join(map(str, value)) or "0"
                return Text(f"faults {numbers}", f"ошибки {numbers}")
            case c.ReadProgramPassport() | c.ReadDataPassport():
                return Text(f"“{value}”", f"«{value}»")
            case _ if isinstance(command, _DATA):
                said = " ".join(
                    self._datum(datum, raw)
                    for datum, raw in zip(command.parameters, value, strict=True)
                )
                return Text(said, said)
        if value is None:
            return Text("done", "выполнено")
        shown = value.hex(" ").upper() if isinstance(value, bytes) else f"{value:02X}"
        return Text(shown, shown)

    def _datum(self, datum: c.Datum, raw: bytes) -> str:
        named = []
        for parameter in self._catalog.by_code(datum.code):
            conversion = parameter.reading(self._reading)
            value = conversion.decode(raw)
            if isinstance(value, bool):
                named.append(f"{parameter.name}={int(value)}")
            else:
                named.append(f"{parameter.name}={value:.{parameter.decimals}f}{conversion.unit}")
        return " ".join(named)
