"""Which commands the unit has, and the forms of their responses (§3, D7, D10).

Passports are asked with the recording paused unless their texts may be kept. Memory is read only
with a consent of its own: a read of external RAM may reach a device. The source does not say where
the passports' texts are stored, so blocks of memory are not recorded without that consent either.
"""

from __future__ import annotations

from functools import partial

from mikas import commands as c
from mikas import errors
from mikas.client.support import try_commands
from mikas.survey.person import Prompter
from mikas.survey.steps.greatest import CountedResponse, greatest
from mikas.survey.steps.step import Measured
from mikas.survey.unit import SurveyedUnit

MEMORY = frozenset((0x11, 0x13, 0x15, 0x21, 0x23, 0x25, 0x31))
PASSPORTS = frozenset(c.ReadProgramPassport.CODES + c.ReadDataPassport.CODES)
_STROKES = frozenset(c.StreamAtStroke.CODES)
_NEVER_COMMANDS = (0x00, 0xFF)
"""No row of §3, and one byte alone: without an address and a datum such a request writes none."""
_BLOCKS = {0x21: 1, 0x23: 2, 0x25: 2}  # bytes of the address by command
_COUNTED = (4, 1)  # bytes of the block that shows whether the count is repeated (D7)


def unknown(unit: SurveyedUnit, measured: Measured, _: Prompter) -> None:
    """Send two codes that are no commands, alone (D10)."""
    found = {}
    for code in _NEVER_COMMANDS:
        reply = unit.ask(bytes([code]))
        found[f"{code:02X}"] = None if reply is None else reply.body.hex().upper()
    measured["unknown"] = found


def support(unit: SurveyedUnit, measured: Measured, person: Prompter) -> None:
    """Try each command that changes nothing but the list; streams by strokes come later."""
    left_out = _STROKES | PASSPORTS | (frozenset() if measured["memory"] else MEMORY)
    tried = try_commands(unit.parameters, left_out)
    found = {}
    for done, each in enumerate(tried):
        if each.known is not None:
            found[f"{each.code:02X}"] = each.known
        person.progress(done + 1, len(c.ALL_COMMANDS))
    measured["commands"] = found


def blocks(unit: SurveyedUnit, measured: Measured, person: Prompter) -> None:
    """Find the largest block of 21, 23 and 25 from address 0, and the form of 23 and 25 (D7)."""
    if not measured["memory"]:
        return
    found = {}
    for done, (code, address) in enumerate(_BLOCKS.items()):
        person.progress(done, len(_BLOCKS))
        with unit.recording_paused(paused=not measured["passports_consent"]):
            counted = _counted(unit, code, address)
            overhead = address + (code == 0x21 or bool(counted))
            limits = greatest(partial(_block, unit, code, address, overhead))
        if limits["limit"] is not None:  # a unit that gives one byte only has seemed to lack it
            measured["commands"][f"{code:02X}"] = True
            found[f"{code:02X}"] = {**limits, "counted": counted}
    measured["blocks"] = found


def _block(
    unit: SurveyedUnit, code: int, address: int, overhead: int, count: int
) -> CountedResponse:
    reply = unit.ask(bytes([code, *bytes(address), count]))
    if reply is not None and not _is_of_block(reply.body, address) and reply.body != b"\x01":
        return CountedResponse(0, "other")
    return CountedResponse.of(reply, count, overhead=overhead)


def _is_of_block(body: bytes, address: int) -> bool:
    """Whether a response repeats the address 0, as each of a block does (§3, D13)."""
    return body.startswith(bytes(address))


def _counted(unit: SurveyedUnit, code: int, address: int) -> bool | None:
    for count in _COUNTED:
        reply = unit.ask(bytes([code, *bytes(address), count]))
        beyond = -1 if reply is None else len(reply.body) - address - count
        if reply is not None and beyond in (0, 1) and _is_of_block(reply.body, address):
            return beyond == 1 and reply.body[address] == count
    return None


def passports(unit: SurveyedUnit, measured: Measured, person: Prompter) -> None:
    """Ask for the passports; without consent only their lengths are kept, and no byte recorded."""
    consent = measured["passports_consent"]
    found: dict[str, dict[str, object] | None] = {}
    with unit.recording_paused(paused=not consent):
        for done, code in enumerate(sorted(PASSPORTS)):
            reply = unit.ask(bytes([code]))
            if reply is None:
                found[f"{code:02X}"] = None
            else:
                found[f"{code:02X}"] = {
                    "bytes": len(reply.body),
                    "refused": reply.body == b"\x01",
                    "raw": reply.body.hex().upper() if consent else None,
                }
            person.progress(done + 1, len(PASSPORTS))
    measured["passports"] = found


def faults(unit: SurveyedUnit, measured: Measured, _: Prompter) -> None:
    """Read the stored faults (02) and the number of parameters (60), as they come."""
    for name, code in (("faults", 0x02), ("count", 0x60)):
        reply = unit.ask(bytes([code]))
        measured[name] = None if reply is None else reply.body.hex().upper()


def fault_numbers(body: str | None) -> tuple[int, ...] | None:
    """Return the faults in a measured body; None: it has another form, or there is none."""
    if body is None:
        return None
    try:
        return c.ReadFaults().read(bytes.fromhex(body))
    except errors.MikasError:
        return None
