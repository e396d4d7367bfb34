"""The commands of §3, a class a row, and the parser of a request's bytes."""

from __future__ import annotations

from typing import Any

from mikas.commands.base import Command as Command
from mikas.commands.base import MalformedRequest as MalformedRequest
from mikas.commands.base import Safety as Safety
from mikas.commands.base import SizeOf, rows
from mikas.commands.base import Space as Space
from mikas.commands.memory import LARGEST_BLOCK as LARGEST_BLOCK
from mikas.commands.memory import ReadCodeBlock as ReadCodeBlock
from mikas.commands.memory import ReadCodeByte as ReadCodeByte
from mikas.commands.memory import ReadRamBlock as ReadRamBlock
from mikas.commands.memory import ReadRamByte as ReadRamByte
from mikas.commands.memory import ReadSfr as ReadSfr
from mikas.commands.memory import ReadXramBlock as ReadXramBlock
from mikas.commands.memory import ReadXramByte as ReadXramByte
from mikas.commands.memory import WriteCodeBlock as WriteCodeBlock
from mikas.commands.memory import WriteCodeByte as WriteCodeByte
from mikas.commands.memory import WriteRamBlock as WriteRamBlock
from mikas.commands.memory import WriteRamByte as WriteRamByte
from mikas.commands.memory import WriteSfr as WriteSfr
from mikas.commands.memory import WriteXramBlock as WriteXramBlock
from mikas.commands.memory import WriteXramByte as WriteXramByte
from mikas.commands.parameters import ERASE_FAULTS as ERASE_FAULTS
from mikas.commands.parameters import CountParameters as CountParameters
from mikas.commands.parameters import Data as Data
from mikas.commands.parameters import Datum as Datum
from mikas.commands.parameters import ReadList as ReadList
from mikas.commands.parameters import ReadParameters as ReadParameters
from mikas.commands.parameters import ReadUnknownSize as ReadUnknownSize
from mikas.commands.parameters import StreamAtStroke as StreamAtStroke
from mikas.commands.parameters import StreamCyclic as StreamCyclic
from mikas.commands.parameters import WriteList as WriteList
from mikas.commands.parameters import WriteParameter as WriteParameter
from mikas.commands.unit import Availability as Availability
from mikas.commands.unit import GoTo as GoTo
from mikas.commands.unit import ReadDataPassport as ReadDataPassport
from mikas.commands.unit import ReadFaults as ReadFaults
from mikas.commands.unit import ReadProgramPassport as ReadProgramPassport
from mikas.errors import UsageError

ALL_COMMANDS = tuple(sorted(rows, key=lambda command: command.CODES))
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
