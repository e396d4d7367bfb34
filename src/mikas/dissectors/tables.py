"""Commands (§3), parameters, faults and models (§4) as plain data, for decoders outside Python.

A generator prints `Tables` in the language of its decoder (`plain` gives the lists and mappings
for that), where a small interpreter walks the layouts. A layout names the parts of a body in their
order, as §3's table does; the command's code at the beginning of a request is not among them:

    address   `address_bytes` bytes, low byte first; a response must repeat the request's
    count     one byte, 1 and more; a response must repeat the request's
    bytes     as many bytes as the request's `count`
    value     one byte
    code      one byte, a parameter's code
    datum     the rest, at least one byte
    codes     the rest, at least one byte: the codes of known parameters
    values    the data of the request's `codes`; for 63, of the list of the last 64 that was
              answered 00
    model     one byte, in `models`
    faults    a count, then as often a fault's number and E0; `01` alone is a refusal (D10)
    text      16 bytes of code page 866, zero-padded
    result    one byte, 00 done, 01 refused (D17)
    any       the rest

`address` and `count` of a block must lie in the memory space: `address + count <= 256 **
address_bytes`. A request that does not fit its layout has no meaning, and neither has its response.
A response fits the first of its layouts that has its length. One that fits none is a refusal if it
is `01` (D10), else of a wrong length: `messages` words both.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, is_dataclass
from typing import Any, Final

from mikas import commands as c
from mikas.catalog import INTERPRETATIONS, Catalog, Conversion, Erratum, Fault, Parameter
from mikas.commands.base import NO_COMPLETION_CODE
from mikas.commands.memory import OTHER_COUNT
from mikas.commands.unit import NO_SEPARATOR, OTHER_NUMBER_OF_FAULTS
from mikas.errors import NotSupported, WriteRefused, WrongAddress, WrongContent, WrongLength
from mikas.i18n import Language, Text

_LAYOUTS: Final[dict[type[c.Command[Any]], tuple[str, ...]]] = {
    c.Availability: ("", "model"),
    c.ReadFaults: ("", "faults"),
    c.ReadRamByte: ("address", "address value"),
    c.WriteRamByte: ("address value", "address value"),
    c.ReadXramByte: ("address", "address value"),
    c.WriteXramByte: ("address value", "address value"),
    c.ReadCodeByte: ("address", "address value"),
    c.WriteCodeByte: ("address value", "address value"),
    c.ReadRamBlock: ("address count", "address count bytes"),
    c.WriteRamBlock: ("address count bytes", "result"),
    c.ReadXramBlock: ("address count", "address bytes", "address count bytes"),
    c.WriteXramBlock: ("address count bytes", "result"),
    c.ReadCodeBlock: ("address count", "address bytes", "address count bytes"),
    c.WriteCodeBlock: ("address count bytes", "result"),
    c.ReadSfr: ("address", "address value"),
    c.WriteSfr: ("address value", "address value"),
    c.GoTo: ("address", "any"),
    c.ReadProgramPassport: ("", "text"),
    c.ReadDataPassport: ("", "text"),
    c.CountParameters: ("", "value"),
    c.ReadParameters: ("codes", "values"),
    c.WriteParameter: ("code datum", "result"),
    c.ReadList: ("", "values"),
    c.WriteList: ("codes", "result"),
    c.StreamCyclic: ("codes", "values"),
    c.StreamAtStroke: ("codes", "values"),
}
"""The request's layout, then those of the responses, the usual one first (D7)."""

MESSAGES: Final[dict[str, Text]] = {
    "done": Text("done", "выполнено"),
    "faults": Text("faults {numbers}", "ошибки {numbers}"),
    "text": Text("“{text}”", "«{text}»"),
    "value_or_refusal": Text("a value of 01, or a refusal", "значение 01 или отказ"),
    "unknown_model": Text("unknown model 0x{code}", "неизвестная модель 0x{code}"),
    "refused": WriteRefused.what,
    "not_supported": NotSupported.what,
    "wrong_length": WrongLength.what,
    "wrong_address": WrongAddress.what,
    "other_count": WrongContent.what.filled(problem=OTHER_COUNT),
    "other_number_of_faults": WrongContent.what.filled(problem=OTHER_NUMBER_OF_FAULTS),
    "no_separator": WrongContent.what.filled(problem=NO_SEPARATOR),
    "no_completion_code": WrongContent.what.filled(problem=NO_COMPLETION_CODE),
}
"""What a response says as a whole, or why it says nothing; fields in braces are to be filled."""


@dataclass(frozen=True, slots=True)
class CommandRow:
    """One code of §3. `shown`: its name in messages; `stream`: answered again and again (D12)."""

    code: int
    name: str
    title: Text
    shown: Text
    stream: bool
    address_bytes: int
    request: tuple[str, ...]
    responses: tuple[tuple[str, ...], ...]


@dataclass(frozen=True, slots=True)
class ConversionRow:
    """`(raw * numerator + constant) / denominator`, exact below 2**52; with a `mask`, a flag."""

    signed: bool
    mask: int
    numerator: int
    constant: int
    denominator: int
    unit: Text


@dataclass(frozen=True, slots=True)
class ParameterRow:
    """One parameter of §4. `interpretations`: by the name of the interpretation, all of them."""

    code: int
    name: str
    text: Text
    size: int
    decimals: int
    interpretations: dict[str, ConversionRow]
    errata: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class FaultRow:
    """One fault number of 02; others have no text."""

    text: Text
    confidence: str


@dataclass(frozen=True, slots=True)
class Tables:
    """All of it. `errata`: the sense by name and interpretation; `messages`: `MESSAGES`."""

    version: str
    commands: dict[int, CommandRow]
    parameters: tuple[ParameterRow, ...]
    faults: dict[int, FaultRow]
    models: dict[int, Text]
    errata: dict[str, dict[str, Text]]
    messages: dict[str, Text]


def tables_of(catalog: Catalog) -> Tables:
    """Return the tables of all commands and of this catalog, own entries of the user included."""
    return Tables(
        version=catalog.version,
        commands={
            code: _command(command, code) for command in c.ALL_COMMANDS for code in command.CODES
        },
        parameters=tuple(map(_parameter, catalog.parameters)),
        faults={number: _fault(fault) for number, fault in sorted(catalog.faults.items())},
        models={code: model.text for code, model in sorted(catalog.models.items())},
        errata={name: _senses(erratum) for name, erratum in catalog.errata.items()},
        messages=MESSAGES,
    )


def plain(value: object, language: Language | None) -> Any:  # noqa: ANN401  (any of JSON's)
    """Return `value` as dicts, lists, texts and numbers, a `Text` in `language`.

    None: in both, as a list of the English and the Russian one.
    """
    match value:
        case Text():
            return [value.en, value.ru] if language is None else value.to(language)
        case dict():
            return {key: plain(each, language) for key, each in value.items()}
        case tuple():
            return [plain(each, language) for each in value]
    if is_dataclass(value):
        return {each.name: plain(getattr(value, each.name), language) for each in fields(value)}
    return value


def _command(command: type[c.Command[Any]], code: int) -> CommandRow:
    space: c.Space | None = getattr(command, "SPACE", None)
    request, *responses = (tuple(layout.split()) for layout in _LAYOUTS[command])
    return CommandRow(
        code=code,
        name=command.SOURCE_NAME,
        title=command.TITLE,
        shown=command.name_by(code),
        stream=command.STREAM,
        address_bytes=space.address_bytes if space else 0,
        request=request,
        responses=tuple(responses),
    )


def _parameter(parameter: Parameter) -> ParameterRow:
    return ParameterRow(
        code=parameter.code,
        name=parameter.name,
        text=parameter.text,
        size=parameter.size,
        decimals=parameter.decimals,
        interpretations={
            name: _conversion(parameter.interpretation(name)) for name in INTERPRETATIONS
        },
        errata=parameter.errata,
    )


def _conversion(conversion: Conversion) -> ConversionRow:
    return ConversionRow(
        signed=conversion.signed,
        mask=conversion.mask,
        numerator=conversion.numerator,
        constant=conversion.constant,
        denominator=conversion.denominator,
        unit=conversion.unit_text,
    )


def _senses(erratum: Erratum) -> dict[str, Text]:
    return {
        name: erratum.alternative if name == erratum.selected_by else erratum.default
        for name in INTERPRETATIONS
    }


def _fault(fault: Fault) -> FaultRow:
    return FaultRow(text=fault.text, confidence=fault.confidence.value)
