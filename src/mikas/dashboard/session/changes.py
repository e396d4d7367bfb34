"""The changes of the unit: each one's effect is read and shown, and made once it is confirmed.

The client library's gate asks at the last moment (`WriteApproval`), journals, and reads back.
"""

from __future__ import annotations

from dataclasses import dataclass

from mikas.catalog import Catalog, Parameter
from mikas.client import Ecu, Reading
from mikas.client.ecu import erasing
from mikas.client.gate import journal_hex
from mikas.client.memory import writing
from mikas.client.parameters.parameters import datum_to_write, decode
from mikas.commands.base import check_range
from mikas.dashboard.errors import BadRequest, api_hex
from mikas.dashboard.security.confirmations import (
    FaultShown,
    PendingChange,
    ValueShown,
    WriteApproval,
)
from mikas.dashboard.session.connection import Connection
from mikas.dashboard.session.history import FaultHistory
from mikas.errors import NotSupported
from mikas.i18n import Text

_PROGRAM = Text(
    "This is the unit's program and data: a wrong byte can leave it unable to run the engine.",
    "Это программа и данные блока: с неверным байтом двигатель может больше не завестись.",
)
_WORKING = Text(
    "This is working memory: the engine may stumble or stall; switching the ignition off undoes "
    "the change.",
    "Это рабочая память: двигатель может дёрнуться или заглохнуть; выключение зажигания отменит "
    "изменение.",
)


@dataclass(slots=True)
class UnitChanges:
    """Prepares the changes of the unit on the connection."""

    _connection: Connection
    _fault_history: FaultHistory
    _approval: WriteApproval
    _interpretation: str
    catalog: Catalog

    async def erase_faults(self) -> PendingChange:
        """Prepare erasing the stored faults."""
        stored = await self._connection.ask(self._fault_history.read)
        codes = [fault.code for fault in stored.faults]

        def erase(ecu: Ecu) -> list[int]:
            with self._approval.given(journal_hex(bytes(codes))):
                erased = ecu.erase_faults()
            self._fault_history.add(erased.after, ecu.tester.link.now(), erased=True)
            return [fault.code for fault in erased.after]

        return PendingChange(
            what=erasing(len(codes)),
            before=codes,
            after=[],
            lost=tuple(
                FaultShown(fault.text.en, fault.text.ru, fault.code) for fault in stored.faults
            ),
            make=lambda: self._connection.ask(erase),
        )

    async def write_parameter(
        self, name: str, *, value: float | None, raw: str | None
    ) -> PendingChange:
        """Prepare writing a physical `value`, or the `raw` bytes in hex.

        Raises for an unknown parameter, and for a value that does not fit it.
        """
        parameter = self.catalog.parameter(name)
        if (value is None) == (raw is None):
            raise BadRequest(
                problem=Text(
                    "give either a value or raw bytes", "нужно или значение, или исходные байты"
                )
            )
        given = None if raw is None else bytes.fromhex(raw)
        datum = datum_to_write(parameter, value, given, self._interpretation)
        before = await self._connection.ask(lambda ecu: _read(ecu, parameter))

        def write(ecu: Ecu) -> ValueShown | None:
            with self._approval.given(journal_hex(before.raw) if before else None):
                return _shown(ecu.write_parameter(parameter.name, raw=datum).after)

        after = decode(parameter, datum, self._connection.now(), self._interpretation)
        return PendingChange(
            what=Text(f"write parameter {parameter.name}", f"записать параметр {parameter.name}"),
            before=_shown(before),
            after=_shown(after),
            make=lambda: self._connection.ask(write),
            meaning=Text(
                f"{parameter.text.en}: {before or 'not readable'} → {after}",
                f"{parameter.text.ru}: {before or 'не читается'} → {after}",
            ),
            needs_unlock=True,
        )

    async def write_memory(self, space: str, address: int, data: bytes) -> PendingChange:
        """Prepare writing bytes. Raises for a range that the space does not have."""
        check_range(space, address, len(data))
        before = await self._connection.ask(
            lambda ecu: ecu.memory[space].read_block(address, len(data))
        )

        def write(ecu: Ecu) -> str | None:
            with self._approval.given(journal_hex(before)):
                return api_hex(ecu.memory[space].write_block(address, data).after)

        danger = space == "code"
        return PendingChange(
            what=writing(len(data), f"{space} {address:04X}"),
            before=api_hex(before),
            after=api_hex(data),
            make=lambda: self._connection.ask(write),
            danger=danger,
            meaning=_PROGRAM if danger else _WORKING,
            needs_unlock=True,
        )


def _read(ecu: Ecu, parameter: Parameter) -> Reading | None:
    try:
        return ecu.read(parameter.name)[parameter.name]
    except NotSupported:
        return None


def _shown(reading: Reading | None) -> ValueShown | None:
    return ValueShown(reading.value, reading.unit, reading.raw.hex().upper()) if reading else None
