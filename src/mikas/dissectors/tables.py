"""Commands (§3), parameters, faults and models (§4) as plain data, for decoders outside Python.

A generator prints these tables in the language of its decoder, where a small interpreter walks the
layouts. A layout names the parts of a body in their
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

from typing import Any, Final

from mikas import commands as c
from mikas.catalog import INTERPRETATIONS, Catalog, Conversion, Erratum, Parameter
from mikas.catalog.conversion import NO_TEXT
from mikas.commands.base import NO_COMPLETION_CODE
from mikas.commands.memory import OTHER_COUNT, ByteCommand, ReadBlock, WriteBlock, WriteByte
from mikas.commands.unit import NO_SEPARATOR, OTHER_NUMBER_OF_FAULTS
from mikas.errors import NotSupported, WriteRefused, WrongAddress, WrongContent, WrongLength
from mikas.i18n import Language, Text

_LAYOUTS: Final[dict[type[c.Command[Any]], tuple[str, ...]]] = {
    c.Availability: ("", "model"),
    c.ReadFaults: ("", "faults"),
    ByteCommand: ("address", "address value"),
    WriteByte: ("address value", "address value"),
    c.ReadRamBlock: ("address count", "address count bytes"),
    ReadBlock: ("address count", "address bytes", "address count bytes"),
    WriteBlock: ("address count bytes", "result"),
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
"""The request's layout, then those of the responses, the usual one first (D7); a family's is that
of its commands.
"""

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


def tables_of(catalog: Catalog, language: Language | None) -> dict[str, Any]:
    """Return the tables of all commands and of this catalog, own entries of the user included.

    They are dicts, lists, texts and numbers. `language`: of the texts; None: both, each text as a
    list of the English and the Russian one. `errata`: the sense by name and interpretation.
    """
    tables = {
        "version": catalog.version,
        "commands": {
            code: _command(command, code) for command in c.ALL_COMMANDS for code in command.CODES
        },
        "parameters": list(map(_parameter, catalog.parameters)),
        "faults": {
            number: {"text": fault.text, "confidence": fault.confidence.value}
            for number, fault in sorted(catalog.faults.items())
        },
        "models": {code: model.text for code, model in sorted(catalog.models.items())},
        "errata": {name: _senses(erratum) for name, erratum in catalog.errata.items()},
        "messages": MESSAGES,
    }
    return {name: _in_language(table, language) for name, table in tables.items()}


def _in_language(value: object, language: Language | None) -> object:
    match value:
        case Text():
            return [value.en, value.ru] if language is None else value.to(language)
        case dict():
            return {key: _in_language(each, language) for key, each in value.items()}
        case tuple() | list():
            return [_in_language(each, language) for each in value]
    return value


def _command(command: type[c.Command[Any]], code: int) -> dict[str, object]:
    """Return one code of §3. `shown`: its name in messages; `stream`: answered again and again
    (D12).
    """
    space: c.Space | None = getattr(command, "SPACE", None)
    layouts = next(_LAYOUTS[kind] for kind in command.__mro__ if kind in _LAYOUTS)
    request, *responses = (layout.split() for layout in layouts)
    return {
        "code": code,
        "name": command.SOURCE_NAME,
        "title": command.TITLE,
        "shown": command.name_by(code),
        "stream": command.STREAM,
        "address_bytes": space.address_bytes if space else 0,
        "request": request,
        "responses": responses,
    }


def _parameter(parameter: Parameter) -> dict[str, object]:
    return {
        "code": parameter.code,
        "name": parameter.name,
        "text": parameter.text,
        "size": parameter.size,
        "decimals": parameter.decimals,
        "interpretations": {
            name: _conversion(parameter.interpretation(name)) for name in INTERPRETATIONS
        },
        "errata": parameter.errata,
    }


def _conversion(conversion: Conversion) -> dict[str, object]:
    """Return `(raw * numerator + constant) / denominator`, exact below 2**52; with a `mask`, a
    flag.
    """
    return {
        "signed": conversion.signed,
        "mask": conversion.mask,
        "numerator": conversion.numerator,
        "constant": conversion.constant,
        "denominator": conversion.denominator,
        "unit": conversion.unit_text,
    }


def _senses(erratum: Erratum) -> dict[str, Text]:
    senses: dict[str, Text] = dict.fromkeys(INTERPRETATIONS, erratum.default)
    if erratum.selected_by:
        senses[erratum.selected_by] = erratum.alternative
    if erratum.family != NO_TEXT:
        senses["family"] = erratum.family
    return senses
