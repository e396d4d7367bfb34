"""The meaning of a capture's frames: requests and responses in words (§3, §4).

Follows the lists that 64 sets, because a response to 63 can't be read without. A response that its
request can't read gets no meaning: better nothing than something wrong. A lone `01` to a 61 with
one code of one byte may be D10's refusal, and so may the first response of a stream of one byte.
What comes later tells, but is not known here; it says so.
"""

from __future__ import annotations

from typing import Any

from mikas import commands as c
from mikas.catalog import Catalog
from mikas.commands.base import ERROR
from mikas.errors import MikasError
from mikas.i18n import Language, Text

_BOTH: tuple[Language, Language] = ("en", "ru")
_DOUBTFUL = Text("a value of 01, or a refusal", "значение 01 или отказ")
_ASKED = (c.ReadParameters, c.StreamCyclic, c.StreamAtStroke)
_DATA = (c.ReadParameters, c.ReadList, c.StreamCyclic, c.StreamAtStroke)


class Describer:
    """Describes the frames of one captured line."""

    def __init__(self, catalog: Catalog, interpretation: str = "corrected") -> None:
        self._catalog = catalog
        self._interpretation = interpretation
        self._list: tuple[c.Datum, ...] = ()
        self._started: bytes | None = None  # the stream that was asked for and has said nothing yet

    def __call__(self, request: bytes, response: bytes | None) -> Text | None:
        """Return the meaning of `request`, or of `response` to it."""
        command = self._command(request)
        if command is None:
            return None
        started, self._started = self._started, None
        if response is None:
            self._started = request
            if isinstance(command, c.WriteList):
                self._list = ()  # until its 00 comes, the list of the ECU is not known
            return self._asked(command)
        try:
            value = command.read(response)
        except MikasError as error:
            return error.reason
        if isinstance(command, c.WriteList):
            self._list = command.parameters
        first = isinstance(command, c.ReadParameters) or started == request
        if isinstance(command, _ASKED) and first and len(request) == 2 and response == ERROR:
            return _DOUBTFUL
        return self._said(command, value)

    def _asked(self, command: c.Command[Any]) -> Text:
        """Return the command's title, and the parameters that it names."""
        data = getattr(command, "parameters", ())
        if isinstance(command, c.ReadList) or not data:
            return command.TITLE
        names = " ".join(
            "/".join(p.name for p in self._catalog.by_code(datum.code)) or f"0x{datum.code:02X}"
            for datum in data
        )
        return Text(f"{command.TITLE.en}: {names}", f"{command.TITLE.ru}: {names}")

    def _command(self, request: bytes) -> c.Command[Any] | None:
        if request == b"\x63":
            return c.ReadList(self._list) if self._list else None
        try:
            return c.parse(request, self._catalog.size_of)
        except c.MalformedRequest:
            return None

    def _said(
        self,
        command: c.Command[Any],
        value: Any,  # noqa: ANN401  (as the command answers)
    ) -> Text | None:
        match command:
            case c.Availability():
                return self._catalog.model(value).text
            case c.ReadFaults():
                numbers = " ".join(map(str, value)) or "0"
                return Text(f"faults {numbers}", f"ошибки {numbers}")
            case c.ReadProgramPassport() | c.ReadDataPassport():
                return Text(f"“{value}”", f"«{value}»")
            case _ if isinstance(command, _DATA):
                data = list(zip(command.parameters, value, strict=True))
                return Text(
                    *(" ".join(self._datum(*it, language) for it in data) for language in _BOTH)
                )
        if value is None:
            return Text("done", "выполнено")
        shown = value.hex(" ").upper() if isinstance(value, bytes) else f"{value:02X}"
        return Text(shown, shown)

    def _datum(self, datum: c.Datum, raw: bytes, language: Language) -> str:
        named = []
        for parameter in self._catalog.by_code(datum.code):
            conversion = parameter.interpretation(self._interpretation)
            value = conversion.decode(raw)
            unit = conversion.unit_text.to(language)
            if isinstance(value, bool):
                named.append(f"{parameter.name}={int(value)}")
            else:
                named.append(f"{parameter.name}={value:.{parameter.decimals}f}{unit}")
        return " ".join(named)
