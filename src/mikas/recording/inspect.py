"""A capture frame by frame, with the meaning of each frame in words (§3, §4): `mikas decode`.

`mikas.recording.exchanges.scalar` finds the frames, the echoes, and which request a response
answers. `Describer` follows the lists that 64 sets, because a response to 63 can't be read without
them; a response that does not fit its request gets no meaning. A lone `01` to a 61 with one code of
one byte may be D10's refusal, and so may the first response of a stream of one byte: only later
responses decide, so the meaning names both.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from typing import Any, Final

from mikas import commands as c
from mikas.catalog import Catalog, shipped
from mikas.commands.base import ERROR, SizeOf
from mikas.errors import MikasError, NotSupported, WrongLength
from mikas.i18n import Language, Text
from mikas.json_values import json_of
from mikas.link.base import Direction
from mikas.recording.capture.reader import Packet, Problem, Source
from mikas.recording.exchanges.fitting import Fitting
from mikas.recording.exchanges.layouts import DATA, READ_LIST, WRITE_LIST
from mikas.recording.exchanges.scalar import UNFINISHED, DecodedDamage, DecodedFrame, PortDecoder

Describe = Callable[[bytes, bytes | None], Text | None]
"""Takes a request's body, and its response's (None: the request itself is described)."""

SCHEMA: Final = 1

_REASONS: Final = {
    "checksum": Text("wrong checksum", "неверная контрольная сумма"),
    "too long": Text("no end in sight", "слишком длинно"),
    "irregular escape": Text("irregular escape", "необычная замена байта"),
    UNFINISHED: Text("unfinished", "не закончено"),
}
_ECHO = Text("echo", "эхо")
NOT_TRUSTED: Final = Text("not trusted: {why}", "не в счёт: {why}")
_RAW_CHECKSUM = Text("raw checksum", "контрольная сумма без замены")
_IRREGULAR = _REASONS["irregular escape"]

Item = DecodedFrame | DecodedDamage | Problem | Packet
"""A packet: bytes of another protocol, at another baud rate, or of an instrument."""


def decode(
    items: Iterable[Packet | Problem],
    describer: Callable[[], Describe] | None = None,
    size_of: SizeOf | None = None,
) -> Iterator[Item]:
    """Yield the frames of `items` as soon as each is whole; pass problems through. Never raise.

    So pass packets of another protocol, and of instruments.

    `describer` makes the `Describe` of one line: a list that 64 sets belongs to it alone.
    `size_of`: bytes of a parameter's datum by its code (None: not known); by default those of the
    shipped catalog. A response has to fit its request (D13).
    """
    fitting = Fitting(size_of or shipped().size_of)
    lines: dict[Source, tuple[PortDecoder, Describe | None]] = {}
    recording = 0
    stream: bytes | None = None  # of the next packets
    for item in items:
        if isinstance(item, Problem):
            for port, _ in lines.values():
                port.matching.interrupt()
            stream = item.stream
            yield item
            continue
        if item.source.recording != recording:
            recording = item.source.recording
            for port, _ in lines.values():
                yield from port.finish()
            lines.clear()
        if item.source.foreign or item.source.instrument:
            yield item
            continue
        if item.source not in lines:
            lines[item.source] = PortDecoder(item.source, fitting), describer and describer()
        port, describe = lines[item.source]
        if stream is not None:
            port.matching.interrupt(stream)
            stream = None
        for part in port.feed(item):
            yield part if describe is None else _described(part, describe)
    for port, _ in lines.values():
        yield from port.finish()


def _described(
    item: DecodedFrame | DecodedDamage, describe: Describe
) -> DecodedFrame | DecodedDamage:
    if isinstance(item, DecodedDamage) or item.echo:
        return item
    is_sent = item.direction is Direction.SENT
    request, response = item.frame.body if is_sent else item.request, item.frame.body
    if request == READ_LIST and not item.knows_list:
        return item
    if is_sent:
        return replace(item, meaning=describe(response, None))
    return item if request is None else replace(item, meaning=describe(request, response))


def to_json(item: Item) -> dict[str, object]:
    """Return a line of `mikas decode --json`: `type` is frame, damage, problem or bytes."""
    if isinstance(item, Problem):
        text = json_of(item.text)
        return {"schema": SCHEMA, "type": "problem", "offset": item.offset, "text": text}
    if isinstance(item, Packet):
        return {
            "schema": SCHEMA,
            "type": "bytes",
            "recording": item.source.recording,
            "port": item.source.url,
            "baud": item.source.baud,
            "time": item.time,
            "direction": item.direction.value,
            "offset": item.offset,
            "data": _hex(item.data),
        }
    line: dict[str, object] = {
        "schema": SCHEMA,
        "type": "frame" if isinstance(item, DecodedFrame) else "damage",
        "recording": item.source.recording,
        "port": item.source.url,
        "time": item.begin,
        "end": item.end,
        "direction": item.direction.value,
        "echo": item.echo,
        "offset": item.offset,
    }
    if isinstance(item, DecodedDamage):
        return line | {"reason": item.reason, "data": _hex(item.data)}
    return line | {
        "body": _hex(item.frame.body),
        "wire": _hex(item.frame.wire),
        "raw_checksum": item.frame.raw_checksum,
        "irregular": item.frame.irregular,
        "name": item.name,
        "request": None if item.request is None else _hex(item.request),
        "meaning": json_of(item.meaning),
        "doubt": json_of(item.doubt.value if item.doubt else None),
    }


def to_text(item: Item, language: Language = "en", *, zero: float = 0.0) -> str:
    """Return one line for a person, times counted from `zero`: `    0.012500 < 0A  Mikas 7.1`.

    `>` is sent, `<` received; a body without checksum and stuffing, damage unchanged after `!`.
    """
    if isinstance(item, Problem):
        return f"{'!':>14} {item.text.to(language)}"
    arrow = ">" if item.direction is Direction.SENT else "<"
    if isinstance(item, Packet):
        of = Text(f"({item.source.baud} baud)", f"({item.source.baud} бод)").to(language)
        return f"{item.time - zero:12.6f} {arrow} {item.data.hex(' ').upper()}  {of}"
    start = f"{item.begin - zero:12.6f} {arrow} "
    if isinstance(item, DecodedDamage):
        data, notes = f"! {item.data.hex(' ').upper()}", [_REASONS[item.reason]]
    else:
        data, notes = item.frame.body.hex(" ").upper() or "—", _notes(item)
    if item.echo:
        notes.insert(0, _ECHO)
    return start + "  ".join([data, "; ".join(note.to(language) for note in notes)]).rstrip()


def _notes(item: DecodedFrame) -> list[Text]:
    notes = []
    # The name of 01 is not from the source; a meaning may begin with it.
    has_name = item.meaning is not None and item.meaning.en.startswith(item.name or "\0")
    if item.name is not None and not item.echo and not has_name:
        notes.append(Text(item.name, item.name))
    if item.meaning is not None:
        notes.append(item.meaning)
    if item.doubt is not None:
        notes.append(NOT_TRUSTED.filled(why=item.doubt.value))
    if item.frame.raw_checksum:
        notes.append(_RAW_CHECKSUM)
    if item.frame.irregular:
        notes.append(_IRREGULAR)
    return notes


def _hex(data: bytes) -> str:
    return data.hex().upper()


# The meaning

_BOTH: Final[tuple[Language, Language]] = ("en", "ru")
_VALUE_OR_REFUSAL = Text("a value of 01, or a refusal", "значение 01 или отказ")


class Describer:
    """Describes the frames of one captured line; it is a `Describe`."""

    def __init__(self, catalog: Catalog, interpretation: str = "corrected") -> None:
        self._catalog = catalog
        self._interpretation = interpretation
        self._list: tuple[c.Datum, ...] = ()
        self._started: bytes | None = None  # the stream requested last, without a response
        self._latest: tuple[bytes, c.Command[Any] | None] = b"", None
        self._unfit: dict[int, Text] = {}  # by the length of a response to the latest request

    def __call__(self, request: bytes, response: bytes | None) -> Text | None:
        """Return the meaning of `request`, or of `response` to it."""
        if response is None and request[:1] == WRITE_LIST:
            self._set_list(())  # until its 00 comes, the list of the ECU is not known
        command = self._command(request)
        if command is None:
            return None
        started, self._started = self._started, None
        if response is None:
            self._started = request
            return self._described_request(command)
        length = len(response) if response != ERROR else -1
        if length in self._unfit:
            return self._unfit[length]
        try:
            value = command.read(response)
        except MikasError as error:
            if isinstance(error, (WrongLength, NotSupported)):
                self._unfit[length] = error.reason
            return error.reason
        if isinstance(command, c.WriteList):
            self._set_list(command.parameters)
        first = isinstance(command, c.ReadParameters) or started == request
        if isinstance(command, DATA) and first and len(request) == 2 and response == ERROR:
            return _VALUE_OR_REFUSAL
        return self._described_value(command, value)

    def _described_request(self, command: c.Command[Any]) -> Text:
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
        """Return the command; once for all responses to one request, which may be a long list."""
        if request != self._latest[0]:
            self._latest = request, self._parsed(request)
            self._unfit = {}
        return self._latest[1]

    def _set_list(self, data: tuple[c.Datum, ...]) -> None:
        self._list = data
        self._latest = b"", None

    def _parsed(self, request: bytes) -> c.Command[Any] | None:
        if request == READ_LIST:
            return c.ReadList(self._list) if self._list else None
        try:
            return c.parse(request, self._catalog.size_of)
        except c.MalformedRequest:
            return None

    def _described_value(
        self,
        command: c.Command[Any],
        value: Any,  # noqa: ANN401  (by the command)
    ) -> Text | None:
        match command:
            case c.Availability():
                return self._catalog.model(value).text
            case c.ReadFaults():
                numbers = " ".join(map(str, value)) or "0"
                return Text(f"faults {numbers}", f"ошибки {numbers}")
            case c.ReadProgramPassport() | c.ReadDataPassport():
                return Text(f"“{value}”", f"«{value}»")
            case _ if isinstance(command, (*DATA, c.ReadList)):
                data = list(zip(command.parameters, value, strict=True))
                en, ru = (" ".join(self._datum(*it, to) for it in data) for to in _BOTH)
                return Text(en, ru)
        if value is None:
            return Text("done", "выполнено")
        digits = value.hex(" ").upper() if isinstance(value, bytes) else f"{value:02X}"
        return Text(digits, digits)

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
