"""The commands of §3, a class a row, and the parser of a request's bytes."""

from __future__ import annotations

from typing import Any

from mikas.commands.base import Command, MalformedRequest, Safety, SizeOf, Space
from mikas.commands.memory import (
    LARGEST_BLOCK,
    ReadCodeBlock,
    ReadCodeByte,
    ReadRamBlock,
    ReadRamByte,
    ReadSfr,
    ReadXramBlock,
    ReadXramByte,
    WriteCodeBlock,
    WriteCodeByte,
    WriteRamBlock,
    WriteRamByte,
    WriteSfr,
    WriteXramBlock,
    WriteXramByte,
)
from mikas.commands.parameters import (
    ERASE_FAULTS,
    CountParameters,
    Data,
    Datum,
    ReadList,
    ReadParameters,
    ReadUnknownSize,
    StreamAtStroke,
    StreamCyclic,
    WriteList,
    WriteParameter,
)
from mikas.commands.unit import (
    Availability,
    GoTo,
    ReadDataPassport,
    ReadFaults,
    ReadProgramPassport,
)
from mikas.errors import UsageError

__all__ = [
    "ALL_COMMANDS",
    "COMMANDS_BY_CODE",
    "ERASE_FAULTS",
    "LARGEST_BLOCK",
    "Availability",
    "Command",
    "CountParameters",
    "Data",
    "Datum",
    "GoTo",
    "MalformedRequest",
    "ReadCodeBlock",
    "ReadCodeByte",
    "ReadDataPassport",
    "ReadFaults",
    "ReadList",
    "ReadParameters",
    "ReadProgramPassport",
    "ReadRamBlock",
    "ReadRamByte",
    "ReadSfr",
    "ReadUnknownSize",
    "ReadXramBlock",
    "ReadXramByte",
    "Safety",
    "Space",
    "StreamAtStroke",
    "StreamCyclic",
    "WriteCodeBlock",
    "WriteCodeByte",
    "WriteList",
    "WriteParameter",
    "WriteRamBlock",
    "WriteRamByte",
    "WriteSfr",
    "WriteXramBlock",
    "WriteXramByte",
    "parse",
]

ALL_COMMANDS: tuple[type[Command[Any]], ...] = (
    Availability,
    ReadFaults,
    ReadRamByte,
    WriteRamByte,
    ReadXramByte,
    WriteXramByte,
    ReadCodeByte,
    WriteCodeByte,
    ReadRamBlock,
    WriteRamBlock,
    ReadXramBlock,
    WriteXramBlock,
    ReadCodeBlock,
    WriteCodeBlock,
    ReadSfr,
    WriteSfr,
    GoTo,
    ReadProgramPassport,
    ReadDataPassport,
    CountParameters,
    ReadParameters,
    WriteParameter,
    ReadList,
    WriteList,
    StreamCyclic,
    StreamAtStroke,
)
"""In the order of §3's table."""

COMMANDS_BY_CODE: dict[int, type[Command[Any]]] = {
    code: command for command in ALL_COMMANDS for code in command.CODES
}


def parse(body: bytes, size_of: SizeOf) -> Command[Any]:
    """Parse a request's body.

    Raises `MalformedRequest` for an unknown code, a wrong length, an invalid address or count, a
    parameter unknown to `size_of`, and for 63, whose list only the ECU's side knows.
    """
    if not body or (command := COMMANDS_BY_CODE.get(body[0])) is None:
        raise MalformedRequest("no such command")
    try:
        return command.parse(body, size_of)
    except UsageError as error:
        raise MalformedRequest(str(error)) from error
